/* lcp/io/zip_write.h - an archive of stored files (APPNOTE 6.3), each of less than 2 GiB, as is the whole: what lcp/io/zip.h
 * reads. Its times are those of 1980-01-01, so that the same content has the same bytes. */
#pragma once

#include "lcp/io/zip.h"

#include <stdbool.h>
#include <stdio.h>

typedef struct lcp_zip_out {
  const char *path; /* for messages; borrowed */
  FILE *to;         /* borrowed */
  size_t at;        /* bytes written */
  bool too_large;
  int n;
  lcp_zip_file file[LCP_ZIP_FILES];
} lcp_zip_out;

/* One more file (at most LCP_ZIP_FILES, names below LCP_ZIP_NAME characters): head, then data. */
void lcp_zip_put(lcp_zip_out *z, const char *name, const void *head, size_t n_head,
                 const void *data, size_t n_data);

/* The list of files, which ends the archive. BASE_EUNSUPPORTED: too large for the format. Whether all was written the owner
 * of the stream finds out. */
base_status lcp_zip_end(lcp_zip_out *z, base_error *err);
