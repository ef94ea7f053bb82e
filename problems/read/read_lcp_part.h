/* problems/read/read_lcp_part.h - parts of the reader of complementarity problems (read_lcp*.c only). */
#pragma once

#include "problems/read/case_file.h"
#include "problems/read/node.h"

#define READ_BAD(n, ...) BASE_FAIL((n)->err, BASE_EINVAL, __VA_ARGS__)

/* `count` numbers of a list into a new array; NaN, Infinity and -Infinity may be given as texts. */
base_status read_numbers(const node *n, const json_t *v, const char *what, int count, double **out);

base_status read_no_memory(const node *n);

/* M and q from lists or from a generator, into c->k; a wrong shape is told in c->shape_error. Needs c->n. */
base_status read_lcp_problem(const node *n, lcp_case *c);
