#include "tests/support/golden.h"

#include <stdio.h>
#include <stdlib.h>

/* Matrices are written by rows; hand() transposes. */
typedef struct hand_case {
  const char *name;
  int n;
  double M[36], q[6], z[6];
  known_answer answer;
  unsigned traits;
  bool easy;
  lcp_block block[2];
  int n_block;
  double lo[6], hi[6];
} hand_case;

#define SPD      (LCP_SYMMETRIC | LCP_PSD | LCP_PD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS | LCP_P_MATRIX)
#define MONOTONE (LCP_PSD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS)

static const hand_case cases[] = {
    {.name = "scalar",
     .n = 1,
     .M = {3},
     .q = {-7.155},
     .z = {2.385},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true},
    /* 11 z = (3 - 2, -1 + 8) */
    {.name = "spd pair",
     .n = 2,
     .M = {4, 1, 1, 3},
     .q = {-1, -2},
     .z = {1.0 / 11, 7.0 / 11},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true},
    {.name = "spd pair, one open",
     .n = 2,
     .M = {4, 1, 1, 3},
     .q = {-1, 2},
     .z = {0.25, 0},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true},
    {.name = "nothing to do",
     .n = 2,
     .M = {4, 1, 1, 3},
     .q = {0.7, 0},
     .z = {0, 0},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true},
    /* the velocity scale is 2^-60: absolute tolerances accept z = 0 */
    {.name = "tiny q",
     .n = 2,
     .M = {4, 1, 1, 3},
     .q = {-0x1p-60, -0x1p-59},
     .z = {0x1p-60 / 11, 0x7p-60 / 11},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true},
    {.name = "scaled by 2^40",
     .n = 2,
     .M = {0x4p40, 0x1p0, 0x1p0, 0x3p-40},
     .q = {-0x1p20, -0x1p-19},
     .z = {0x1p-20 / 11, 0x7p20 / 11},
     .answer = KNOWN_UNIQUE,
     .traits = SPD},
    {.name = "redundant pair",
     .n = 2,
     .M = {1, 1, 1, 1},
     .q = {-2.385, -2.385},
     .z = {2.385, 0},
     .answer = KNOWN_SOLVABLE,
     .traits = LCP_SYMMETRIC | MONOTONE},
    {.name = "two walls",
     .n = 2,
     .M = {2, -2, -2, 2},
     .q = {-1, -3},
     .answer = KNOWN_INFEASIBLE,
     .traits = LCP_SYMMETRIC | MONOTONE},
    {.name = "no coupling",
     .n = 2,
     .M = {0, 0, 0, 2},
     .q = {-1, -3},
     .answer = KNOWN_INFEASIBLE,
     .traits = LCP_SYMMETRIC | MONOTONE | LCP_ZERO_DIAGONAL},
    /* w = (2.5 - z2, z1 - 1.5) */
    {.name = "skew",
     .n = 2,
     .M = {0, -1, 1, 0},
     .q = {2.5, -1.5},
     .z = {1.5, 2.5},
     .answer = KNOWN_UNIQUE,
     .traits = MONOTONE | LCP_ZERO_DIAGONAL},
    /* w2 = 2 > 0 forces z2 = 0 and w1 = -3; z2 >= 3 is feasible */
    {.name = "feasible, unsolvable",
     .n = 2,
     .M = {0, 1, 0, 0},
     .q = {-3, 2},
     .answer = KNOWN_UNSOLVABLE,
     .traits = LCP_COPOSITIVE | LCP_ZERO_DIAGONAL},
    {.name = "negative scalar", .n = 1, .M = {-2}, .q = {-3}, .answer = KNOWN_INFEASIBLE},
    {.name = "two answers", .n = 1, .M = {-2}, .q = {3}, .z = {1.5}, .answer = KNOWN_SOLVABLE},
    {.name = "rotation dominates",
     .n = 2,
     .M = {1, -4, 4, 1},
     .q = {3, -5},
     .z = {1, 1},
     .answer = KNOWN_UNIQUE,
     .traits = LCP_PD | LCP_P_MATRIX | MONOTONE},
    /* 2 kg block sliding at 3 m/s, mu = 0.4, unknowns n, t+, t-, lambda: 2 N s, brake 0.8 N s */
    {.name = "sliding block",
     .n = 4,
     .M = {0.5, 0, 0, 0, 0, 0.5, -0.5, 1, 0, -0.5, 0.5, 1, 0.4, -1, -1, 0},
     .q = {-1, 3, -3, 0},
     .z = {2, 0, 0.8, 2.6},
     .answer = KNOWN_UNIQUE,
     .traits = LCP_COPOSITIVE | LCP_ZERO_DIAGONAL},
    {.name = "free row",
     .n = 2,
     .M = {2, 1, 1, 3},
     .q = {1, -2},
     .z = {-1, 1},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true,
     .n_block = 2,
     .block = {{.start = 0, .size = 1, .set = LCP_FREE},
               {.start = 1, .size = 1, .set = LCP_ORTHANT}}},
    {.name = "box, one end reached",
     .n = 2,
     .M = {2, 1, 1, 2},
     .q = {-3, 0.5},
     .z = {0.5, -0.5},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true,
     .lo = {-1, -1},
     .hi = {0.5, 1},
     .n_block = 1,
     .block = {{.start = 0, .size = 2, .set = LCP_BOX}}},
    /* normal impulse 2, slip against (6, -8) at the limit 0.5 * 2 */
    {.name = "cone, slip",
     .n = 3,
     .M = {2, 0, 0, 0, 2, 0, 0, 0, 2},
     .q = {-4, 6, -8},
     .z = {2, -0.6, 0.8},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true,
     .n_block = 1,
     .block = {{.start = 0,
                .size = 3,
                .set = LCP_CONE,
                .n_part = 1,
                .part_dim = {2},
                .part_mu = {0.5}}}},
    {.name = "cone, stick",
     .n = 3,
     .M = {2, 0, 0, 0, 2, 0, 0, 0, 2},
     .q = {-4, 0.6, -0.8},
     .z = {2, -0.3, 0.4},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true,
     .n_block = 1,
     .block = {{.start = 0,
                .size = 3,
                .set = LCP_CONE,
                .n_part = 1,
                .part_dim = {2},
                .part_mu = {0.5}}}},
    {.name = "cone, open",
     .n = 3,
     .M = {2, 0, 0, 0, 2, 0, 0, 0, 2},
     .q = {0.3, 0.6, -0.8},
     .z = {0, 0, 0},
     .answer = KNOWN_UNIQUE,
     .traits = SPD,
     .easy = true,
     .n_block = 1,
     .block = {{.start = 0,
                .size = 3,
                .set = LCP_CONE,
                .n_part = 1,
                .part_dim = {2},
                .part_mu = {0.5}}}},
};

static const char *const members[] = {
    "murty:n=6",
    "murty:n=6,upper=1",
    "murty:n=6,q=hat",
    "fathi:n=6",
    "csizmadia:n=8",
    "circulant",
    "kostreva:variant=1",
    "kostreva:variant=2",
    "kostreva:variant=3",
    "kostreva:variant=4",
    "kostreva:variant=5",
    "lcg",
    "lcg:kind=p_nonsym,seed=3",
    "random_spd:n=40",
    "random_p:n=30",
    "random_psd:n=40",
    "random_copositive:n=20",
    "stack:n=12,mass_ratio=3",
    "tridiagonal",
    "box_stack:n=3",
    "box_stack:n=3,storage=sparse",
    "subset_sum:n=4,largest=9",
};

enum { N_HAND = BASE_COUNT(cases), N_MEMBER = BASE_COUNT(members) };

static golden list[N_HAND + N_MEMBER];
static double columns[N_HAND][36];
static known_lcp known[N_MEMBER];

static golden hand(const hand_case *c, double *M) {
  for (int i = 0; i < c->n; i++) {
    for (int j = 0; j < c->n; j++) {
      M[j * c->n + i] = c->M[i * c->n + j];
    }
  }
  golden g = {.name = c->name, .answer = c->answer, .easy = c->easy};
  g.p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = c->n, .val = M},
                      .q = c->q,
                      .lo = c->lo,
                      .hi = c->hi,
                      .block = (c->n_block > 0) ? c->block : NULL,
                      .n_block = c->n_block,
                      .traits = c->traits};
  g.z = (c->answer == KNOWN_UNIQUE || c->answer == KNOWN_SOLVABLE) ? c->z : NULL;
  return g;
}

const golden *goldens(int *count) {
  static int filled;
  for (; filled < N_HAND; filled++) {
    list[filled] = hand(&cases[filled], columns[filled]);
  }
  for (; filled < N_HAND + N_MEMBER; filled++) {
    known_lcp *k = &known[filled - N_HAND];
    base_error err = {0};
    if (lcp_family_load(members[filled - N_HAND], k, &err) != BASE_OK) {
      (void)fprintf(stderr, "%s: %s\n", members[filled - N_HAND], err.text);
      abort(); /* a test fixture that cannot be built: every test using it would be void */
    }
    list[filled] =
        (golden){.name = members[filled - N_HAND], .p = k->p, .answer = k->answer, .z = k->z};
  }
  *count = filled;
  return list;
}
