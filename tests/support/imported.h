/* tests/support/imported.h - the problems of other codes: what each file must read as, and when two of
 * them are the same to the bit. tests/data/README.md tells where they come from. */
#pragma once

#include "problems/import/import.h"

#include <stdbool.h>

typedef struct imported_file {
  const char *name; /* below data/, in this repository and in the folder of the originals */
  bool here;        /* its numbers are in tests/data, written by lcpbench export */
  int n, n_block;   /* of the LCP, mixed LCP, or friction problem on its cone */
  unsigned sets;    /* bits of lcp_set */
} imported_file;

extern const imported_file imported_files[];
extern const int n_imported_file;

bool imported_is_fclib(const imported_file *f);

/* The file reads as the table says; a friction problem has a positive diagonal. */
void imported_reads(const imported_file *f, const char *path);

/* Siconos text or FCLIB, as it lies in the file. The caller frees *out. */
void imported_friction(const imported_file *f, const char *path, friction_problem *out);

/* From path to text, from there to FCLIB, and back: the same bits. Friction problems only. */
void imported_round_trip(const imported_file *f, const char *path);

/* The problem of a file alone, without the cone that facets are judged on. *out is freed with known_lcp_free. */
base_status imported_problem(const char *path, int facets, known_lcp *out, base_error *err);

void same_matrix(const lcp_csc *a, const lcp_csc *b);
void same_vector(const double *a, const double *b, int n);
void same_friction(const friction_problem *a, const friction_problem *b);
void same_problem(const lcp_problem *a, const lcp_problem *b);
