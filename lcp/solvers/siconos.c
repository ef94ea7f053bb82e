#include "lcp/solvers/siconos.h"

#include "lcp/lcp_column.h"

#include <FrictionContactProblem.h>
#include <LinearComplementarityProblem.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
#include <SparseBlockMatrix.h>
#include <stdlib.h>
#include <string.h>

const base_field siconos_fields[SICONOS_FIELDS] = {LCP_STOP_FIELDS(siconos_options, 1e-10, 100000)};

void siconos_layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  siconos_state *s = state;
  s->M = BASE_ARRAY(a, double, (size_t)cap->n *(size_t)cap->n);
  s->q = BASE_ARRAY(a, double, cap->n);
  s->w = BASE_ARRAY(a, double, cap->n);
}

void siconos_cone_layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  siconos_state *s = state;
  s->q = BASE_ARRAY(a, double, cap->n);
  s->w = BASE_ARRAY(a, double, cap->n);
  s->mu = BASE_ARRAY(a, double, cap->n_block);
}

void siconos_cone_release(void *state) {
  siconos_state *s = state;
  if (s->blocks != NULL) {
    NM_clear(s->blocks);
    free(s->blocks);
    s->blocks = NULL;
  }
}

/* NULL without memory. */
static NumericsMatrix *in_blocks(const lcp_matrix *M) {
  NumericsMatrix *sparse = NM_create(NM_SPARSE, M->n, M->n);
  SparseBlockStructuredMatrix *blocks = SBM_new();
  NumericsMatrix *out = NULL;
  if (sparse != NULL && blocks != NULL) {
    NM_triplet_alloc(sparse, M->n);
    for (int j = 0; j < M->n; j++) {
      const lcp_column c = lcp_column_of(M, j);
      for (int k = 0; k < c.count; k++) {
        if (c.val[k] != 0.0) {
          NM_entry(sparse, lcp_column_row(&c, k), j, c.val[k]);
        }
      }
    }
    if (SBM_from_csparse(3, NM_csc(sparse), blocks) == 0) {
      out = NM_new_SBM(M->n, M->n, blocks);
    }
  }
  if (sparse != NULL) {
    NM_clear(sparse);
    free(sparse);
  }
  return out;
}

base_status siconos_cone_prepare(void *state, const lcp_problem *p, const void *opt,
                                 base_error *err) {
  (void)opt;
  siconos_state *s = state;
  s->blocks = NULL;
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    const lcp_block *b = &p->block[k];
    if (b->set == LCP_CONE && (b->n_part != 1 || b->part_dim[0] != 2)) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "siconos: block %d is not a 3D contact cone", k);
    }
    s->mu[k] = (b->set == LCP_CONE) ? b->part_mu[0] : 0;
  }
  s->blocks = in_blocks(&p->M);
  return (s->blocks != NULL) ? BASE_OK
                             : BASE_FAIL(err, BASE_ENOMEM, "siconos: no memory for its matrix");
}

/* The matrix view is freed here, its data is not. */
static void drop(NumericsMatrix *M) {
  if (M != NULL) {
    M->matrix0 = NULL;
    NM_clear(M);
    free(M);
  }
}

static void conclude(const SolverOptions *o, int info, const lcp_stop *stop, lcp_result *res) {
  res->work.iterations = o->iparam[SICONOS_IPARAM_ITER_DONE];
  res->residual = o->dparam[SICONOS_DPARAM_RESIDU];
  if (info == 0) {
    res->outcome = LCP_SOLVED;
  } else {
    res->outcome = (res->work.iterations >= stop->max_iter) ? LCP_MAX_ITER : LCP_STALLED;
  }
}

static SolverOptions *options_for(int id, const lcp_stop *stop) {
  SolverOptions *o = solver_options_create(id);
  if (o != NULL) {
    o->iparam[SICONOS_IPARAM_MAX_ITER] = stop->max_iter;
    o->dparam[SICONOS_DPARAM_TOL] = stop->tol;
  }
  return o;
}

base_status siconos_solve_lcp(int id, siconos_state *s, const lcp_problem *p, const void *opt,
                              double *z, lcp_result *res) {
  const lcp_stop *stop = &((const siconos_options *)opt)->stop;
  const int n = p->M.n;
  lcp_matrix_to_dense(&p->M, s->M);
  memcpy(s->q, p->q, (size_t)n * sizeof *s->q);
  SolverOptions *o = options_for(id, stop);
  NumericsMatrix *M = NM_create_from_data(NM_DENSE, n, n, s->M);
  base_status status = BASE_EEXTERNAL;
  if (o != NULL && M != NULL) {
    LinearComplementarityProblem lcp = {.size = n, .M = M, .q = s->q};
    conclude(o, linearComplementarity_driver(&lcp, z, s->w, o), stop, res);
    status = BASE_OK;
  }
  drop(M);
  if (o != NULL) {
    solver_options_delete(o);
  }
  return status;
}

base_status siconos_solve_cone(int id, siconos_state *s, const lcp_problem *p, const void *opt,
                               double *z, lcp_result *res) {
  const lcp_stop *stop = &((const siconos_options *)opt)->stop;
  memcpy(s->q, p->q, (size_t)p->M.n * sizeof *s->q);
  if (s->blocks == NULL) {
    s->blocks = in_blocks(&p->M);
  }
  SolverOptions *o = options_for(id, stop);
  if (o == NULL || s->blocks == NULL) {
    if (o != NULL) {
      solver_options_delete(o);
    }
    return BASE_EEXTERNAL;
  }
  FrictionContactProblem fc = {
      .dimension = 3, .numberOfContacts = p->n_block, .M = s->blocks, .q = s->q, .mu = s->mu};
  conclude(o, fc3d_driver(&fc, z, s->w, o), stop, res);
  solver_options_delete(o);
  siconos_cone_release(s); /* proximal steps have written to it */
  return BASE_OK;
}
