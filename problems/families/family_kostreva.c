#include "problems/families/family.h"
#include "problems/families/generate.h"

typedef struct kostreva {
  int variant;
} kostreva;

static const base_field fields[] = {
    BASE_FIELD(kostreva, variant, BASE_INT, "1", 1, 1, 5,
               "1: P-matrix; 2: infeasible; 3: reversed; 4: both row rules cycle; 5: all do"),
};

typedef struct example {
  int n;
  double M[25]; /* row by row */
  known_answer answer;
  double z[5]; /* the solution, or the Farkas vector */
} example;

static const example examples[] = {
    {3, {1, 2, 0, 0, 1, 2, 2, 0, 1}, KNOWN_UNIQUE, {1.0 / 3, 1.0 / 3, 1.0 / 3}},
    {3, {1, -1, 3, 2, -1, 3, -1, -2, 0}, KNOWN_INFEASIBLE, {0, 0, 1}},
    {3, {1, 0, 2, 2, 1, 0, 0, 2, 1}, KNOWN_UNIQUE, {1.0 / 3, 1.0 / 3, 1.0 / 3}},
    {4,
     {1, 0, 0, 2, 0, 1, 0, 0, 2, 0, 1, 0, 0, 0, 2, 1},
     KNOWN_UNIQUE,
     {1.0 / 3, 1, 1.0 / 3, 1.0 / 3}},
    {5,
     {1, 0, 1, 2, 2, 2, 1, 1, 1, 2, 0, 2, 1, 0, 2, 0, -1, 2, 1, 0, 2, 2, -1, 2, 1},
     KNOWN_UNIQUE,
     {0, 0, 3.0 / 11, 5.0 / 11, 4.0 / 11}},
};

static base_status build(const void *param, known_lcp *k, base_error *err) {
  const kostreva *p = param;
  const example *e = &examples[p->variant - 1];
  double *M, *q;
  BASE_TRY(known_dense(k, e->n, &M, &q, err));
  double *answer = KNOWN_ARRAY(k, double, e->n);
  if (answer == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory");
  }
  for (int i = 0; i < e->n; i++) {
    for (int j = 0; j < e->n; j++) {
      M[j * e->n + i] = e->M[i * e->n + j];
    }
    q[i] = -1.0;
    answer[i] = e->z[i];
  }
  k->answer = e->answer;
  *((e->answer == KNOWN_UNIQUE) ? &k->z : &k->farkas) = answer;
  return BASE_OK;
}

const lcp_family family_kostreva = {
    .name = "kostreva",
    .title = "small problems on which naive Lemke cycles",
    .cite = "kostreva1979",
    .about =
        "Degenerate problems of size 3 to 5 with q = -1 on which Lemke's method with a simple tie "
        "rule (lowest row, highest row, lowest or highest index, largest pivot) cycles for ever; "
        "variant 5 defeats six of them at once. Lexicographic ties solve all (MATHEMATICS F5).",
    FAMILY_PARTS(kostreva),
};
