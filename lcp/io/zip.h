/* lcp/io/zip.h - the files in a ZIP archive (APPNOTE 6.3): stored or deflated, without encryption, of less than 4 GiB
 * each. What is inflated comes from zlib; its size and its CRC-32 are held to. */
#pragma once

#include "lcp/base/status.h"

enum { LCP_ZIP_FILES = 64, LCP_ZIP_NAME = 64 };

typedef struct lcp_zip_file {
  char name[LCP_ZIP_NAME];
  unsigned method, crc;
  size_t packed, size; /* [bytes] */
  size_t at;           /* of its local header */
} lcp_zip_file;

typedef struct lcp_zip {
  const char *path;    /* borrowed */
  unsigned char *data; /* the archive, owned */
  size_t size;
  int n;
  lcp_zip_file file[LCP_ZIP_FILES];
} lcp_zip;

/* BASE_EINVAL: no archive, a damaged one, or one beyond the limits above. */
base_status lcp_zip_open(lcp_zip *z, const char *path, base_error *err);

/* The content of file i, to be freed; f->size bytes. */
base_status lcp_zip_read(const lcp_zip *z, int i, unsigned char **out, base_error *err);
void lcp_zip_close(lcp_zip *z);
