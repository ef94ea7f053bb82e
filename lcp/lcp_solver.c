#include "lcp/lcp_solver.h"

#include "lcp_solver_list.h"

#include <string.h>

#define DECLARE_(name) extern const lcp_solver lcp_solver_##name;
LCP_SOLVER_LIST(DECLARE_)
#define ADDRESS_(name) &lcp_solver_##name,
static const lcp_solver *const all[] = {LCP_SOLVER_LIST(ADDRESS_) NULL};

const lcp_solver *const *lcp_solvers(int *count) {
  *count = BASE_COUNT(all) - 1;
  return all;
}

const lcp_solver *lcp_solver_find(const char *name) {
  for (int i = 0; all[i] != NULL; i++) {
    if (strcmp(all[i]->name, name) == 0) {
      return all[i];
    }
  }
  return NULL;
}

#define NAME_(id, text) text,
static const char *const outcome_names[] = {LCP_OUTCOME_LIST(NAME_)};

void lcp_work_add(lcp_work *sum, const lcp_work *more) {
  sum->iterations += more->iterations;
  sum->pivots += more->pivots;
  sum->sweeps += more->sweeps;
  sum->matvecs += more->matvecs;
  sum->factorizations += more->factorizations;
  sum->backsolves += more->backsolves;
  sum->refinements += more->refinements;
  sum->linesearches += more->linesearches;
  sum->fallbacks += more->fallbacks;
}

const char *lcp_outcome_name(lcp_outcome o) {
  return ((unsigned)o < LCP_OUTCOME_COUNT) ? outcome_names[o] : "unknown";
}

static const char *const set_names[] = {"orthant", "box", "free", "cone"};

const char *lcp_set_name(int set) {
  return (set >= 0 && set < BASE_COUNT(set_names)) ? set_names[set] : NULL;
}

static const char *const trait_names[] = {
    "symmetric", "psd", "pd", "copositive", "copositive_plus", "p_matrix", "zero_diagonal"};

const char *lcp_trait_name(int trait) {
  return (trait >= 0 && trait < BASE_COUNT(trait_names)) ? trait_names[trait] : NULL;
}

unsigned lcp_trait_find(const char *name) {
  for (int i = 0; i < BASE_COUNT(trait_names); i++) {
    if ((1u << i) != LCP_ZERO_DIAGONAL && strcmp(trait_names[i], name) == 0) {
      return 1u << i;
    }
  }
  return 0;
}

/* What is declared, what follows from it, and exact symmetry of the stored numbers where asked. */
static unsigned known_traits(const lcp_problem *p, unsigned asked) {
  unsigned t = p->traits;
  t |= ((t & LCP_PD) != 0) ? (unsigned)(LCP_PSD | LCP_P_MATRIX) : 0u;
  t |= ((t & LCP_PSD) != 0) ? (unsigned)LCP_COPOSITIVE_PLUS : 0u;
  t |= ((t & LCP_COPOSITIVE_PLUS) != 0) ? (unsigned)LCP_COPOSITIVE : 0u;
  if ((asked & ~t & LCP_SYMMETRIC) != 0 && lcp_matrix_is_symmetric(&p->M)) {
    t |= LCP_SYMMETRIC;
  }
  return t;
}

base_status lcp_solver_admits(const lcp_solver *s, const lcp_problem *p, base_error *err) {
  const unsigned sets = lcp_problem_sets(p) & ~s->sets;
  for (int i = 0; i < BASE_COUNT(set_names); i++) {
    if ((sets & (1u << i)) != 0) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: does not solve %s blocks", s->name,
                       set_names[i]);
    }
  }
  const unsigned traits = s->needs & ~known_traits(p, s->needs);
  for (int i = 0; i < BASE_COUNT(trait_names); i++) {
    if ((traits & (1u << i)) != 0) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: needs a problem known to be %s", s->name,
                       trait_names[i]);
    }
  }
  return BASE_OK;
}
