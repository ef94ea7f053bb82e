/* plugin_solver.c - the functions of lcp_solver over those of a plug-in.
 *
 * The options of the solver are lcp_stop, then one slot of eight bytes for each option of the plug-in, and reach it as
 * plain doubles. Its workspace ends with a guard: who writes behind it is found out at the next return. */
#include "harness/choice/plugin_solver.h"

#include "harness/choice/solver_choice.h"
#include "include/lcpbench/lcp_plugin.h"
#include "lcp/base/clock.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(LCP_PLUGIN_ORTHANT == 1u << LCP_ORTHANT && LCP_PLUGIN_BOX == 1u << LCP_BOX &&
                   LCP_PLUGIN_FREE == 1u << LCP_FREE && LCP_PLUGIN_CONE == 1u << LCP_CONE,
               "sets are those of lcp_problem.h");
_Static_assert(LCP_PLUGIN_DENSE == 1u << LCP_DENSE && LCP_PLUGIN_CSC == 1u << LCP_CSC,
               "storages are those of lcp_problem.h");
_Static_assert((int)LCP_PLUGIN_SYMMETRIC == (int)LCP_SYMMETRIC &&
                   (int)LCP_PLUGIN_PSD == (int)LCP_PSD && (int)LCP_PLUGIN_PD == (int)LCP_PD &&
                   (int)LCP_PLUGIN_COPOSITIVE == (int)LCP_COPOSITIVE &&
                   (int)LCP_PLUGIN_COPOSITIVE_PLUS == (int)LCP_COPOSITIVE_PLUS &&
                   (int)LCP_PLUGIN_P_MATRIX == (int)LCP_P_MATRIX,
               "traits are those of lcp_problem.h");
_Static_assert(sizeof((lcp_plugin_block *)NULL)->part_dim == LCP_PARTS_MAX * sizeof(int),
               "parts are those of lcp_problem.h");

enum {
  SLOT = 8,
  STOP_FIELDS = 4,
  LONGEST_NAME = 40,
  MORE_OPTIONS = 24,
  GUARD = 64,
  GUARD_BYTE = 0xA5
};

typedef struct options {
  lcp_stop stop;
  unsigned char slot[MORE_OPTIONS][SLOT];
} options;

static const base_field stop_fields[STOP_FIELDS] = {LCP_STOP_FIELDS(options, 1e-8, 10000)};

typedef struct plugin {
  const lcp_plugin *d;
  base_field field[STOP_FIELDS + MORE_OPTIONS];
  lcp_solver solver;
} plugin;

typedef struct state {
  const plugin *self; /* lcp_solver.context */
  lcp_stop_state stop;
  unsigned char *work; /* size bytes, then the guard */
  size_t size;
  uint64_t seal;   /* of M and q */
  double *lo, *hi; /* n */
  lcp_plugin_block *block;
  double option[MORE_OPTIONS];
  lcp_plugin_problem view;
} state;

static void read_options(const plugin *self, const options *o, double *value) {
  for (int k = 0; k < self->d->n_option; k++) {
    if (self->field[STOP_FIELDS + k].kind == BASE_REAL) {
      memcpy(&value[k], o->slot[k], sizeof value[k]);
    } else {
      int number;
      memcpy(&number, o->slot[k], sizeof number);
      value[k] = number;
    }
  }
}

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  state *s = st;
  const lcp_plugin *d = s->self->d;
  read_options(s->self, opt, s->option);
  lcp_stop_layout(&s->stop, cap, a);
  s->lo = BASE_ARRAY(a, double, cap->n);
  s->hi = BASE_ARRAY(a, double, cap->n);
  s->block = BASE_ARRAY(a, lcp_plugin_block, cap->n_block + 1);
  s->size = (d->workspace != NULL)
                ? d->workspace(cap->n, (size_t)cap->nnz, cap->n_block + 1, s->option)
                : 0;
  s->work =
      BASE_ARRAY(a, unsigned char, (s->size <= SIZE_MAX - GUARD) ? s->size + GUARD : SIZE_MAX);
}

static void view_block(const lcp_block *b, lcp_plugin_block *to) {
  *to = (lcp_plugin_block){.set = 1 << b->set, .start = b->start, .size = b->size};
  if (b->set == LCP_CONE) {
    to->n_part = b->n_part;
    memcpy(to->part_dim, b->part_dim, sizeof to->part_dim);
    memcpy(to->part_mu, b->part_mu, sizeof to->part_mu);
  }
}

static void view_bounds(state *s, const lcp_problem *p, const lcp_block *b) {
  for (int i = b->start; i < b->start + b->size; i++) {
    const bool free = b->set == LCP_FREE || b->set == LCP_CONE;
    s->lo[i] = (b->set == LCP_BOX) ? p->lo[i] : free ? -HUGE_VAL : 0.0;
    s->hi[i] = (b->set == LCP_BOX) ? p->hi[i] : HUGE_VAL;
  }
}

static void view_problem(state *s, const lcp_problem *p) {
  const lcp_block whole = {.size = p->M.n, .set = LCP_ORTHANT};
  const int n_block = (p->block != NULL) ? p->n_block : (p->M.n > 0);
  for (int k = 0; k < n_block; k++) {
    const lcp_block *b = (p->block != NULL) ? &p->block[k] : &whole;
    view_block(b, &s->block[k]);
    view_bounds(s, p, b);
  }
  const bool sparse = p->M.storage == LCP_CSC;
  s->view = (lcp_plugin_problem){
      .n = p->M.n,
      .dense = sparse ? NULL : p->M.val,
      .colptr = sparse ? p->M.csc.colptr : NULL,
      .rowind = sparse ? p->M.csc.rowind : NULL,
      .val = sparse ? p->M.csc.val : NULL,
      .q = p->q,
      .lo = s->lo,
      .hi = s->hi,
      .n_block = n_block,
      .block = s->block,
      .traits = p->traits,
  };
}

static bool guard_holds(const state *s) {
  for (int i = 0; i < GUARD; i++) {
    if (s->work[s->size + (size_t)i] != GUARD_BYTE) {
      return false;
    }
  }
  return true;
}

enum { SEALS = 8 }; /* side by side: a product waits for the one before */

/* FNV-1a, a word at a time. */
static uint64_t add_bits(uint64_t seal, const double *x, size_t n) {
  uint64_t lane[SEALS] = {seal};
  for (size_t i = 0; i < n; i++) {
    uint64_t bits;
    memcpy(&bits, &x[i], sizeof bits);
    lane[i % SEALS] = (lane[i % SEALS] ^ bits) * 0x100000001b3u;
  }
  for (int k = 1; k < SEALS; k++) {
    lane[0] = (lane[0] ^ lane[k]) * 0x100000001b3u;
  }
  return lane[0];
}

/* Of the numbers of M and q, which a plug-in could write through a cast, as routines do that overwrite what they factor. */
static uint64_t seal_of(const lcp_problem *p) {
  const size_t n = (size_t)p->M.n;
  const bool sparse = p->M.storage == LCP_CSC;
  const uint64_t M =
      sparse ? add_bits(1, p->M.csc.val, (size_t)p->M.csc.colptr[n]) : add_bits(1, p->M.val, n * n);
  return add_bits(M, p->q, n);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  state *s = st;
  const lcp_plugin *d = s->self->d;
  char message[LCP_PLUGIN_MESSAGE] = "";
  view_problem(s, p);
  s->seal = seal_of(p);
  memset(s->work + s->size, GUARD_BYTE, GUARD);
  const int code =
      (d->prepare != NULL) ? d->prepare(s->work, &s->view, s->option, message) : LCP_PLUGIN_READY;
  message[sizeof message - 1] = '\0';
  if (!guard_holds(s)) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "%s: prepare wrote behind its workspace", d->name);
  }
  if (s->seal != seal_of(p)) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "%s: prepare wrote into M or q", d->name);
  }
  switch (code) {
  case LCP_PLUGIN_READY:
    return BASE_OK;
  case LCP_PLUGIN_UNSUPPORTED:
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: %s", d->name,
                     message[0] != '\0' ? message : "refused without a reason");
  case LCP_PLUGIN_NO_MEMORY:
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory", d->name);
  default:
    return BASE_FAIL(err, BASE_EEXTERNAL, "%s: %s", d->name,
                     message[0] != '\0' ? message : "prepare failed without a reason");
  }
}

/* What stop and trace need. */
typedef struct host {
  state *s;
  const options *o;
  const lcp_problem *p;
  lcp_trace *trace;
  lcp_result *res;
  bool ended;
} host;

static int stop(void *at, long iterations, const double *z) {
  host *h = at;
  h->res->work.iterations = iterations;
  h->ended = lcp_stop_test(&h->s->stop, &h->o->stop, h->p, z, h->trace, h->res);
  return h->ended;
}

static void trace(void *at, long iterations, double residual) {
  host *h = at;
  lcp_trace *t = h->trace;
  if (t != NULL && t->len < t->cap) {
    t->iteration[t->len] = iterations;
    t->residual[t->len++] = residual;
  }
}

static void take_counts(const lcp_plugin_result *r, lcp_result *res) {
  res->work.iterations = r->iterations;
  res->work.pivots = r->pivots;
  res->work.matvecs += r->matvecs;
  res->work.factorizations = r->factorizations;
  if (r->residual > 0.0) {
    res->residual = r->residual;
  }
}

static base_status take_claim(int code, bool ended, const lcp_plugin_result *r, lcp_result *res) {
  static const lcp_outcome claims[] = {[LCP_PLUGIN_SOLVED] = LCP_SOLVED,
                                       [LCP_PLUGIN_MAX_ITER] = LCP_MAX_ITER,
                                       [LCP_PLUGIN_TIME_LIMIT] = LCP_TIME_LIMIT,
                                       [LCP_PLUGIN_STALLED] = LCP_STALLED,
                                       [LCP_PLUGIN_RAY] = LCP_RAY,
                                       [LCP_PLUGIN_INFEASIBLE] = LCP_INFEASIBLE,
                                       [LCP_PLUGIN_NUMERICAL] = LCP_NUMERICAL};
  if (code == LCP_PLUGIN_NO_MEMORY) {
    return BASE_ENOMEM;
  }
  if (code < 0 || code >= BASE_COUNT(claims) || (code == LCP_PLUGIN_AS_STOPPED && !ended)) {
    return BASE_EEXTERNAL; /* also LCP_PLUGIN_FAILED */
  }
  if (code != LCP_PLUGIN_AS_STOPPED) {
    res->outcome = claims[code];
  }
  if (code == LCP_PLUGIN_INFEASIBLE && r->farkas != NULL) {
    res->certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = r->farkas};
  }
  return BASE_OK;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *history,
                         double *z, lcp_result *res) {
  state *s = st;
  const options *o = opt;
  host h = {s, o, p, history, res, false};
  const lcp_plugin_call call = {.host = &h,
                                .tol = o->stop.tol,
                                .max_iter = o->stop.max_iter,
                                .max_seconds = o->stop.max_seconds,
                                .option = s->option,
                                .stop = stop,
                                .trace = trace};
  lcp_plugin_result r = {0};
  lcp_stop_begin(&s->stop, p);
  const int code = s->self->d->solve(s->work, &s->view, &call, z, &r);
  take_counts(&r, res);
  const double done = base_seconds();
  const bool kept = guard_holds(s) && s->seal == seal_of(p);
  res->aside = base_seconds() - done;
  return kept ? take_claim(code, h.ended, &r, res) : BASE_EEXTERNAL;
}

static void release(void *st) {
  const state *s = st;
  s->self->d->release(s->work);
}

/* ---- the descriptor ------------------------------------------------------------------------- */

static bool is_name(const char *name) {
  const size_t length = (name != NULL) ? strlen(name) : 0;
  return length > 0 && length <= LONGEST_NAME && name[0] >= 'a' && name[0] <= 'z' &&
         strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_") == length;
}

static bool is_text(const char *text) {
  return text != NULL && text[0] != '\0';
}

static base_status take_option(plugin *self, int k, base_error *err) {
  const lcp_plugin_option *o = &self->d->options[k];
  base_field *f = &self->field[STOP_FIELDS + k];
  for (int i = 0; is_name(o->name) && i < STOP_FIELDS + k; i++) {
    if (strcmp(self->field[i].name, o->name) == 0) {
      return BASE_FAIL(err, BASE_EINVAL, "option '%s' is there already", o->name);
    }
  }
  if (!is_name(o->name) || !is_text(o->unit) || !is_text(o->help) || o->kind == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "option %d: need name, unit, kind and help", k);
  }
  *f = (base_field){.name = o->name,
                    .unit = o->unit,
                    .offset = offsetof(options, slot) + SLOT * (size_t)k,
                    .dflt = o->standard,
                    .min = o->least,
                    .max = o->most,
                    .help = o->help};
  if (strcmp(o->kind, "choice") == 0 && is_text(o->words)) {
    int words = 1;
    for (const char *c = o->words; *c != '\0'; c++) {
      words += *c == '|';
    }
    f->kind = BASE_CHOICE;
    f->words = o->words;
    f->min = 0.0;
    f->max = words - 1;
  } else if (strcmp(o->kind, "int") == 0 || strcmp(o->kind, "real") == 0) {
    f->kind = (o->kind[0] == 'i') ? BASE_INT : BASE_REAL;
  } else {
    return BASE_FAIL(err, BASE_EINVAL, "option '%s': need the kind int, real, or choice with words",
                     o->name);
  }
  const double limit = (f->kind == BASE_INT) ? 2e9 : HUGE_VAL;
  if (!(f->min <= f->dflt && f->dflt <= f->max && -limit <= f->min && f->max <= limit)) {
    return BASE_FAIL(err, BASE_EINVAL, "option '%s': need its default inside its range", o->name);
  }
  return BASE_OK;
}

static base_status check_descriptor(const lcp_plugin *d, base_error *err) {
  const unsigned sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX | LCP_PLUGIN_FREE | LCP_PLUGIN_CONE;
  if (d->abi != LCP_PLUGIN_ABI || d->size < sizeof *d) {
    return BASE_FAIL(err, BASE_EINVAL, "made for interface %d (%zu bytes): need %d (%zu)", d->abi,
                     d->size, LCP_PLUGIN_ABI, sizeof *d);
  }
  if (!is_name(d->name)) {
    return BASE_FAIL(err, BASE_EINVAL, "name: need a-z, 0-9, _, at most %d", LONGEST_NAME);
  }
  if (registry_solver_find(d->name) != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "a solver '%s' is there already", d->name);
  }
  if (!is_text(d->title) || !is_text(d->words) || !is_text(d->when)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: need title, words and when", d->name);
  }
  if (d->sets == 0 || (d->sets & ~sets) != 0 || d->storages == 0 || d->storages > 3 ||
      d->needs > 63) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: sets, storages or needs out of range", d->name);
  }
  if (d->solve == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: no solve", d->name);
  }
  if (d->n_option < 0 || d->n_option > MORE_OPTIONS || (d->n_option > 0 && d->options == NULL)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: %d options: need 0 to %d", d->name, d->n_option,
                     MORE_OPTIONS);
  }
  if (!(d->tol >= 0.0 && d->tol <= 1.0) || d->max_iter < 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: defaults tol %g, max_iter %d out of range", d->name,
                     d->tol, d->max_iter);
  }
  return BASE_OK;
}

static base_status take_descriptor(plugin *self, base_error *err) {
  const lcp_plugin *d = self->d;
  BASE_TRY(check_descriptor(d, err));
  memcpy(self->field, stop_fields, sizeof stop_fields);
  self->field[0].dflt = (d->tol > 0.0) ? d->tol : self->field[0].dflt;
  self->field[1].dflt = (d->max_iter > 0) ? d->max_iter : self->field[1].dflt;
  for (int k = 0; k < d->n_option; k++) {
    BASE_TRY(take_option(self, k, err));
  }
  self->solver = (lcp_solver){.name = d->name,
                              .title = d->title,
                              .words = d->words,
                              .when = d->when,
                              .cite = "",
                              .sets = d->sets,
                              .storages = d->storages,
                              .needs = d->needs,
                              .exact = d->exact != 0,
                              .warm = d->warm != 0,
                              .allocates = d->release != NULL,
                              .peer = true,
                              .fields = self->field,
                              .n_fields = STOP_FIELDS + d->n_option,
                              .options_size = sizeof(options),
                              .state_size = sizeof(state),
                              .context = self,
                              .layout = layout,
                              .prepare = prepare,
                              .solve = solve,
                              .release = (d->release != NULL) ? release : NULL};
  return registry_add(&self->solver, err);
}

/* A path with a slash is opened as it is; without, dlopen would search. */
static void *open_file(const char *file) {
  char path[4096];
  (void)snprintf(path, sizeof path, "%s%s", strchr(file, '/') == NULL ? "./" : "", file);
  return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}

base_status plugin_load(const char *file, const lcp_solver **out, base_error *err) {
  void *object = open_file(file);
  if (object == NULL) {
    const char *why = dlerror();
    return BASE_FAIL(err, BASE_EIO, "plug-in %.150s: %.200s", file, why != NULL ? why : "unknown");
  }
  plugin *self = calloc(1, sizeof *self);
  base_error why = {0};
  base_status done = (self != NULL) ? BASE_OK : BASE_FAIL(&why, BASE_ENOMEM, "no memory");
  if (done == BASE_OK) {
    self->d = dlsym(object, "lcp_plugin_descriptor");
    done = (self->d != NULL)
               ? take_descriptor(self, &why)
               : BASE_FAIL(&why, BASE_EINVAL, "has no lcp_plugin_descriptor: not a plug-in");
  }
  if (done != BASE_OK) {
    free(self);
    (void)dlclose(object);
    return BASE_FAIL(err, done, "plug-in %.150s: %s", file, why.text);
  }
  *out = &self->solver;
  return BASE_OK;
}
