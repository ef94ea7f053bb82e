#include "harness/check/conform.h"

#include "harness/measure/solve_once.h"
#include "harness/util/stop.h"
#include "problems/families/family.h"

#include <malloc.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What the rows of a family's matrix are made into. */
typedef enum conform_rows { ROWS_AS_POSED, ROWS_BOX, ROWS_FREE, ROWS_CONE, ROWS_ALL } conform_rows;

typedef struct conform_case {
  const char *family;
  conform_rows rows;
  bool easy;     /* M positive definite: every sound method gets there */
  bool hopeless; /* no feasible point */
} conform_case;

static const conform_case cases[] = {
    {"tridiagonal:n=1", ROWS_AS_POSED, true, false},
    {"tridiagonal:n=40", ROWS_AS_POSED, true, false},
    {"random_spd:n=24", ROWS_AS_POSED, true, false},
    {"lcg:n=8", ROWS_AS_POSED, true, false},
    {"random_p:n=12", ROWS_AS_POSED, false, false},
    {"random_psd:n=12", ROWS_AS_POSED, false, false},
    {"box_stack:n=4", ROWS_AS_POSED, false, false},
    {"murty:n=6", ROWS_AS_POSED, false, false},
    {"fathi:n=6", ROWS_AS_POSED, false, false},
    {"csizmadia:n=6", ROWS_AS_POSED, false, false},
    {"circulant:n=5", ROWS_AS_POSED, false, false},
    {"random_spd:n=24", ROWS_BOX, true, false},
    {"random_spd:n=24", ROWS_FREE, true, false},
    {"random_spd:n=24", ROWS_CONE, false, false},
    {"random_spd:n=24", ROWS_ALL, false, false},
    {"tridiagonal:n=3", ROWS_AS_POSED, false, true},
};

enum { ROWS = 24, BLOCKS = ROWS };

typedef struct unit {
  const conform_case *c;
  const solver_choice *choice;
  lcp_storage storage;
  check_outcome blank;
  known_lcp k;
  lcp_csc csc;
  double *dense;
  lcp_problem p;
  lcp_block block[BLOCKS];
  double lo[ROWS], hi[ROWS], minus_one[ROWS];
} unit;

static void emit(isolate_channel *out, const unit *u, const char *check, bool held,
                 const char *reason) {
  check_outcome o = u->blank;
  o.verdict = held ? CHECK_PASSED : CHECK_FAILED;
  (void)snprintf(o.check, sizeof o.check, "%s", check);
  (void)snprintf(o.reason, sizeof o.reason, "%.190s", reason);
  (void)isolate_emit(out, &o);
}

static void skip(isolate_channel *out, const unit *u, const char *check, const char *reason) {
  check_outcome o = u->blank;
  o.verdict = CHECK_SKIPPED;
  (void)snprintf(o.check, sizeof o.check, "%s", check);
  (void)snprintf(o.reason, sizeof o.reason, "%.190s", reason);
  (void)isolate_emit(out, &o);
}

/* ---- problems ------------------------------------------------------------------------------- */

static void add_rows(unit *u, int count, lcp_set set) {
  const int start =
      (u->p.n_block > 0) ? u->block[u->p.n_block - 1].start + u->block[u->p.n_block - 1].size : 0;
  for (int k = 0; k < ((set == LCP_CONE) ? count / 3 : 1); k++) {
    lcp_block *b = &u->block[u->p.n_block++];
    *b = (lcp_block){.start = start + 3 * k, .size = (set == LCP_CONE) ? 3 : count, .set = set};
    if (set == LCP_CONE) {
      b->n_part = 1;
      b->part_dim[0] = 2;
      b->part_mu[0] = 0.3 * (k + 1);
    }
  }
  for (int i = start; set == LCP_BOX && i < start + count; i++) {
    u->lo[i] = -0.5;
    u->hi[i] = (i % 3 == 0) ? HUGE_VAL : 0.25;
  }
}

static void pose_rows(unit *u) {
  u->p.lo = u->lo;
  u->p.hi = u->hi;
  switch (u->c->rows) {
  case ROWS_AS_POSED:
    u->p.lo = u->p.hi = NULL;
    return;
  case ROWS_BOX:
    add_rows(u, ROWS / 2, LCP_BOX);
    add_rows(u, ROWS / 2, LCP_ORTHANT);
    break;
  case ROWS_FREE:
    add_rows(u, ROWS / 4, LCP_FREE);
    add_rows(u, 3 * ROWS / 4, LCP_ORTHANT);
    break;
  case ROWS_CONE:
    add_rows(u, ROWS, LCP_CONE);
    break;
  case ROWS_ALL:
    add_rows(u, 6, LCP_FREE);
    add_rows(u, 6, LCP_BOX);
    add_rows(u, 6, LCP_ORTHANT);
    add_rows(u, 6, LCP_CONE);
    break;
  }
  u->p.block = u->block;
}

/* M = 0 and q = -1: w = q < 0 whatever z is. */
static void make_hopeless(unit *u) {
  memset(u->dense, 0, (size_t)u->p.M.n * (size_t)u->p.M.n * sizeof *u->dense);
  for (int i = 0; i < u->p.M.n; i++) {
    u->minus_one[i] = -1.0;
  }
  u->p.q = u->minus_one;
  u->p.traits = 0;
}

static base_status pose(unit *u, base_error *err) {
  BASE_TRY(lcp_family_load(u->c->family, &u->k, err));
  const size_t n = (size_t)u->k.p.M.n;
  u->p = u->k.p;
  u->dense = malloc(n * n * sizeof *u->dense);
  if (u->dense == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "conform: no memory");
  }
  lcp_matrix_to_dense(&u->k.p.M, u->dense);
  if (u->c->hopeless) {
    make_hopeless(u);
  }
  u->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = u->k.p.M.n, .val = u->dense};
  if (u->storage == LCP_CSC) {
    BASE_TRY(lcp_matrix_to_csc(&u->p.M, &u->csc, err));
    u->p.M = (lcp_matrix){.storage = LCP_CSC, .n = u->csc.n_row, .csc = u->csc};
  }
  pose_rows(u);
  return lcp_problem_check(&u->p, err);
}

static void free_unit(unit *u) {
  lcp_csc_free(&u->csc);
  free(u->dense);
  known_lcp_free(&u->k);
}

static uint64_t add_bytes(uint64_t h, const void *data, size_t n) {
  const unsigned char *byte = data;
  for (size_t i = 0; i < n; i++) {
    h = (h ^ byte[i]) * 1099511628211u; /* FNV-1a */
  }
  return h;
}

static uint64_t data_hash(const unit *u) {
  const size_t n = (size_t)u->p.M.n;
  uint64_t h = add_bytes(14695981039346656037u, u->p.q, n * sizeof *u->p.q);
  h = add_bytes(h, u->dense, n * n * sizeof *u->dense);
  h = add_bytes(h, u->block, sizeof u->block);
  h = add_bytes(add_bytes(h, u->lo, sizeof u->lo), u->hi, sizeof u->hi);
  if (u->storage == LCP_CSC) {
    const size_t entries = (size_t)u->csc.colptr[n];
    h = add_bytes(h, u->csc.val, entries * sizeof *u->csc.val);
    h = add_bytes(h, u->csc.rowind, entries * sizeof *u->csc.rowind);
    h = add_bytes(h, u->csc.colptr, (n + 1) * sizeof *u->csc.colptr);
  }
  return h;
}

/* ---- checks --------------------------------------------------------------------------------- */

/* True: a claim that the judge agrees with; `held` is false for a lie, and for an easy problem that was taken and not
 * solved. */
static bool solved(const unit *u, const solve_record *r, bool *held, char *why, size_t cap) {
  const bool ok = r->status == RUN_OK;
  const bool lie = r->status == RUN_UNVERIFIED || (ok && u->c->hopeless);
  *held =
      !lie && (ok || r->status == RUN_INFEASIBLE || r->status == RUN_UNSUPPORTED || !u->c->easy);
  (void)snprintf(why, cap, "%s%s: claimed %s, rho %.3g", lie ? "a false claim: " : "",
                 run_status_name(r->status),
                 r->has_claim ? lcp_outcome_name(r->claim.outcome) : "nothing", r->verdict.rho);
  return ok && !lie;
}

static void check_answer(isolate_channel *out, const unit *u, const solve_record *r) {
  char why[200];
  bool held;
  const bool ok = solved(u, r, &held, why, sizeof why);
  if (ok || !held || r->status == RUN_INFEASIBLE) {
    emit(out, u, "answer", held, ok ? "" : why);
  } else {
    char text[sizeof why + sizeof r->note + 32];
    (void)snprintf(text, sizeof text, "honest failure: %s %s", why, r->note);
    skip(out, u, "answer", text);
  }
}

static void check_again(isolate_channel *out, const unit *u, const double *z,
                        const solve_record *first, double *again) {
  solve_record r;
  base_error err = {0};
  memset(again, 0, (size_t)u->p.M.n * sizeof *again);
  const bool done = solve_once(&u->p, u->choice, again, &r, &err) == BASE_OK;
  emit(out, u, "again",
       done && memcmp(z, again, (size_t)u->p.M.n * sizeof *z) == 0 && r.status == first->status,
       done ? "the same problem, another answer" : err.text);
}

static void check_start(isolate_channel *out, const unit *u, const double *z, double *from) {
  solve_record r;
  base_error err = {0};
  char why[200] = "";
  bool held = false;
  memcpy(from, z, (size_t)u->p.M.n * sizeof *from);
  if (solve_once(&u->p, u->choice, from, &r, &err) != BASE_OK) {
    emit(out, u, "start", false, err.text);
    return;
  }
  emit(out, u, "start", solved(u, &r, &held, why, sizeof why), why);
}

static void check_few(isolate_channel *out, const unit *u, double *z) {
  solver_choice one;
  solve_record r;
  base_error err = {0};
  char why[200] = "";
  bool held = false;
  memset(z, 0, (size_t)u->p.M.n * sizeof *z);
  base_status done = solver_choose(u->choice->solver->name, &one, &err);
  if (done == BASE_OK) {
    done = solver_choice_set(&one, "max_iter", "1", &err);
    done = (done == BASE_OK) ? solve_once(&u->p, &one, z, &r, &err) : done;
    solver_choice_free(&one);
  }
  if (done == BASE_OK) {
    (void)solved(u, &r, &held, why, sizeof why);
    held = r.status != RUN_UNVERIFIED && !(r.status == RUN_OK && u->c->hopeless);
  }
  emit(out, u, "few", held, done == BASE_OK ? why : err.text);
}

/* Bytes that the process holds from malloc. */
static size_t heap(void) {
  const struct mallinfo2 m = mallinfo2();
  return m.uordblks + m.hblkhd;
}

/* The first solves may fill caches of a library. From then on a solver leaks that holds more after each single solve; the
 * allocator's own lists go up and down. */
static void check_heap(isolate_channel *out, const unit *u, double *z) {
  enum { WARM_UP = 8, COUNTED = 16 };
  solve_record r;
  base_error err = {0};
  size_t least = SIZE_MAX;
  size_t before = 0;
  for (int i = 0; i < WARM_UP + COUNTED; i++) {
    memset(z, 0, (size_t)u->p.M.n * sizeof *z);
    if (solve_once(&u->p, u->choice, z, &r, &err) != BASE_OK) {
      emit(out, u, "heap", false, err.text);
      return;
    }
    const size_t now = heap();
    const size_t more = (now > before) ? now - before : 0;
    least = (i >= WARM_UP && more < least) ? more : least;
    before = now;
  }
  char why[120];
  (void)snprintf(why, sizeof why, "%zu bytes more after each solve", least);
  emit(out, u, "heap", least == 0, why);
}

static void check_all(isolate_channel *out, const unit *u, double *z, double *other) {
  solve_record r;
  base_error err = {0};
  const uint64_t before = data_hash(u);
  if (solve_once(&u->p, u->choice, z, &r, &err) != BASE_OK) {
    emit(out, u, "run", false, err.text);
    return;
  }
  check_answer(out, u, &r);
  if (r.status != RUN_UNSUPPORTED) {
    check_again(out, u, z, &r, other);
    if (u->choice->solver->warm && r.status == RUN_OK) {
      check_start(out, u, z, other);
    }
    check_few(out, u, other);
    check_heap(out, u, other);
    emit(out, u, "data", data_hash(u) == before, "the problem was written to");
  }
}

static void run_unit(void *ctx, isolate_channel *out) {
  unit *u = ctx;
  const size_t n = (size_t)u->p.M.n;
  double *z = calloc(2 * n + 1, sizeof *z);
  if (z == NULL) {
    emit(out, u, "run", false, "no memory for the answer");
    return;
  }
  check_all(out, u, z, z + n);
  free(z);
}

/* ---- all ------------------------------------------------------------------------------------ */

static const char *const row_words[] = {"", "+box", "+free", "+cone", "+all"};

/* Nothing is run where the solver does not read the storage. */
static base_status run_case(const check_plan *plan, const conform_case *c, lcp_storage storage,
                            base_error *err) {
  if ((plan->solver[0].solver->storages & (1u << storage)) == 0) {
    return BASE_OK;
  }
  unit u = {.c = c, .choice = &plan->solver[0], .storage = storage, .blank = {.check = "run"}};
  u.blank.got = u.blank.expected = u.blank.tolerance = (double)NAN;
  (void)snprintf(u.blank.id, sizeof u.blank.id, "%s%s%s/%s", c->hopeless ? "hopeless_" : "",
                 c->family, row_words[c->rows], storage_name(storage));
  (void)snprintf(u.blank.solver, sizeof u.blank.solver, "%s", u.choice->solver->name);
  base_status done = pose(&u, err);
  if (done == BASE_OK && lcp_solver_admits(u.choice->solver, &u.p, NULL) == BASE_OK) {
    done = check_isolated(plan, &u.blank, run_unit, &u, err);
  }
  free_unit(&u);
  return done;
}

base_status conform_solver(const check_plan *plan, base_error *err) {
  for (int i = 0; i < BASE_COUNT(cases) && stop_requested() == 0; i++) {
    for (int storage = LCP_DENSE; storage <= LCP_CSC; storage++) {
      BASE_TRY(run_case(plan, &cases[i], (lcp_storage)storage, err));
    }
  }
  return BASE_OK;
}
