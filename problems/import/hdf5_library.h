/* problems/import/hdf5_library.h - HDF5, loaded when a file of FCLIB is read or written.
 *
 * The macros of its header that call H5open on their way are replaced: hdf5_begin calls it once. Native and stored types
 * are variables of the library, to be read after that. */
#pragma once

#include "lcp/base/library.h"

#include <hdf5.h>

#undef H5OPEN
#define H5OPEN
#undef H5CHECK
#define H5CHECK

/* clang-format off */
#define HDF5_SYMBOLS(X) \
  X(H5open) \
  X(H5get_libversion) \
  X(H5Dclose) \
  X(H5Dcreate2) \
  X(H5Dget_space) \
  X(H5Dget_storage_size) \
  X(H5Dget_type) \
  X(H5Dopen2) \
  X(H5Dread) \
  X(H5Dwrite) \
  X(H5Eget_auto2) \
  X(H5Eset_auto2) \
  X(H5Fclose) \
  X(H5Fcreate) \
  X(H5Fopen) \
  X(H5Gclose) \
  X(H5Gcreate2) \
  X(H5Lexists) \
  X(H5Pclose) \
  X(H5Pcreate) \
  X(H5Pset_fapl_core) \
  X(H5Pset_file_image) \
  X(H5Pset_obj_track_times) \
  X(H5Sclose) \
  X(H5Screate_simple) \
  X(H5Sget_simple_extent_dims) \
  X(H5Sget_simple_extent_ndims) \
  X(H5Tclose) \
  X(H5Tget_class) \
  X(H5Tget_size) \
  X(H5P_CLS_DATASET_CREATE_ID_g) \
  X(H5P_CLS_FILE_ACCESS_ID_g) \
  X(H5T_IEEE_F64LE_g) \
  X(H5T_NATIVE_DOUBLE_g) \
  X(H5T_NATIVE_INT_g) \
  X(H5T_STD_I32LE_g)
/* clang-format on */
BASE_LIBRARY(hdf5, HDF5_SYMBOLS, LCPBENCH_LIB_HDF5, "an FCLIB file")

/* Loaded and opened: its types may be read. */
static inline base_status hdf5_begin(hdf5_library *h5, base_error *err) {
  BASE_TRY(hdf5_open(h5, err));
  return (h5->H5open() >= 0) ? BASE_OK
                             : BASE_FAIL(err, BASE_EEXTERNAL, "HDF5: could not be started");
}
