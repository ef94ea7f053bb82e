/* The invariants that builds with assertions check: a fault is planted in each structure, and the process aborts. */
#include "tests/support/check.h"

#include "formulations/assembly.h"
#include "formulations/regularized/regularized_factor.h"
#include "lcp/lcp_instance.h"
#include "lcp/linear/basis.h"
#include "lcp/linear/tableau.h"
#include "lcp/solvers/contact_sweep.h"
#include "tests/support/plain_sweep.h"
#include "tests/support/rig.h"
#include "tests/support/small_world.h"

#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* True where act(x), in a child without a core file or a word, ends by abort; false where it returns. */
static bool aborts(void (*act)(void *x), void *x) {
  int how = 0;
  (void)fflush(NULL);
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    const struct rlimit none = {0, 0};
    (void)setrlimit(RLIMIT_CORE, &none);
    (void)signal(SIGABRT, SIG_DFL);
    (void)close(STDERR_FILENO);
    act(x);
    _exit(0);
  }
  assert_int_equal(waitpid(child, &how, 0), child);
  assert_true(WIFSIGNALED(how) || (WIFEXITED(how) && WEXITSTATUS(how) == 0));
  return WIFSIGNALED(how) && WTERMSIG(how) == SIGABRT;
}

#define ASSERT_ABORTS(act, x)         assert_true(aborts((act), (x)))
#define ASSERT_DOES_NOT_ABORT(act, x) assert_false(aborts((act), (x)))

/* ---- bases ------------------------------------------------------------------------------------ */

static const int identity_start[] = {0, 1, 2}, identity_row[] = {0, 1};
static const double identity_value[] = {1, 1}, cover[] = {1, 1};
static const lin_system two_rows = {2, identity_start, identity_row, identity_value, cover};

static void enter_z(void *x) {
  const double d[] = {1, 0};
  lin_basis_replace(x, 0, 2, d);
}

static void a_basis_names_each_variable_once(void **state) {
  (void)state;
  lin_basis b = {0};
  const unsigned char none[] = {0, 0};
  base_arena a = base_arena_measuring();
  lin_basis_layout(&b, 2, 2, &a);
  void *mem = base_alloc(a.used);
  a = base_arena_over(mem, a.used);
  lin_basis_layout(&b, 2, 2, &a);
  lin_basis_start(&b, &two_rows, none);
  assert_true(lin_basis_factor(&b));
  ASSERT_DOES_NOT_ABORT(enter_z, &b);
  b.head[1] = 0; /* w_0 in both positions */
  ASSERT_ABORTS(enter_z, &b);
  b.head[1] = 1;
  b.where[2] = 1; /* z_0 enters although it is basic */
  ASSERT_ABORTS(enter_z, &b);
  free(mem);
}

static void exchange(void *x) {
  lin_tableau_replace(x, 0, 2);
}

static void a_tableau_names_each_variable_once(void **state) {
  (void)state;
  lin_tableau b = {0};
  base_arena a = base_arena_measuring();
  lin_tableau_layout(&b, 2, &a);
  void *mem = base_alloc(a.used);
  a = base_arena_over(mem, a.used);
  lin_tableau_layout(&b, 2, &a);
  lin_tableau_start(&b, 2);
  for (int j = 0; j < 2; j++) {
    lin_tableau_entries(&b, j)[j] = -1;
    lin_tableau_entries(&b, j)[1 - j] = 0;
    b.x[j] = -1;
  }
  ASSERT_DOES_NOT_ABORT(exchange, &b);
  b.head[1] = 0;
  ASSERT_ABORTS(exchange, &b);
  free(mem);
}

/* ---- problems --------------------------------------------------------------------------------- */

typedef struct posed {
  int colptr[3], rowind[3];
  double val[3], q[2];
  lcp_block block[2];
  lcp_problem p;
} posed;

static void pose(posed *x) {
  *x = (posed){.colptr = {0, 2, 3},
               .rowind = {0, 1, 1},
               .val = {2, 1, 2},
               .q = {-1, -1},
               .block = {{.start = 0, .size = 1}, {.start = 1, .size = 1}}};
  x->p =
      (lcp_problem){.M = {.storage = LCP_CSC, .n = 2, .csc = {2, 2, x->colptr, x->rowind, x->val}},
                    .q = x->q,
                    .block = x->block,
                    .n_block = 2};
}

static void prepare(void *x) {
  const lcp_solver *pgs = lcp_solver_find("pgs");
  const posed *t = x;
  const lcp_capacity cap = {.n = 2, .n_block = 2, .nnz = 3};
  unsigned char opt[256] = {0};
  base_error err = {0};
  lcp_instance *k;
  base_fields_default(pgs->fields, pgs->n_fields, opt);
  if (lcp_instance_open(&k, pgs, &cap, opt, &err) == BASE_OK) {
    (void)lcp_instance_prepare(k, &t->p, &err);
    lcp_instance_close(k);
  }
}

static void columns_are_sorted_and_blocks_cover_the_rows(void **state) {
  (void)state;
  posed x;
  pose(&x);
  ASSERT_DOES_NOT_ABORT(prepare, &x);
  x.rowind[0] = 1; /* twice the same row */
  ASSERT_ABORTS(prepare, &x);
  pose(&x);
  x.rowind[2] = 2;
  ASSERT_ABORTS(prepare, &x);
  pose(&x);
  x.block[1].start = 0;
  ASSERT_ABORTS(prepare, &x);
  pose(&x);
  x.p.n_block = 1;
  ASSERT_ABORTS(prepare, &x);
}

/* ---- sweeps in batches ------------------------------------------------------------------------ */

typedef struct batches {
  contact_bed bed;
  lcp_gs gs;
  lcp_contact_sweep fast;
} batches;

static void carve(batches *f, base_arena *a) {
  const lcp_capacity cap = lcp_problem_capacity(&f->bed.p);
  lcp_gs_layout(&f->gs, &cap, a);
  lcp_contact_sweep_layout(&f->fast, &cap, a);
}

static void import_zero(void *x) {
  batches *f = x;
  double *z = calloc((size_t)f->bed.p.M.n, sizeof *z);
  lcp_contact_sweep_import(&f->fast, &f->bed.p, z);
  free(z);
}

static void batches_are_a_partition_without_shared_bodies(void **state) {
  (void)state;
  base_error err = {0};
  batches f = {.bed = contact_bed_open(200, 3)};
  base_arena a = base_arena_measuring();
  carve(&f, &a);
  void *mem = base_alloc(a.used);
  a = base_arena_over(mem, a.used);
  carve(&f, &a);
  check_ok(lcp_gs_prepare(&f.gs, &f.bed.p, &err), &err);
  assert_true(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p) && f.fast.in.n_batch > 1);
  ASSERT_DOES_NOT_ABORT(import_zero, &f);
  const int first = f.fast.in.order[0];
  f.fast.in.order[0] = f.fast.in.order[1];
  ASSERT_ABORTS(import_zero, &f);
  f.fast.in.order[0] = first;
  const int count = f.fast.in.n_batch--; /* a contact without a place */
  ASSERT_ABORTS(import_zero, &f);
  f.fast.in.n_batch = count;
  free(mem);
  contact_bed_close(&f.bed);
}

/* ---- contact sets and formulations ------------------------------------------------------------ */

static void begin_velocity(void *x) {
  base_error err = {0};
  formulation_run *run = rig_open("velocity", "");
  (void)formulation_begin(run, x, FORM_COLD, &err);
  rig_close(run);
}

static void contacts_are_unique_sorted_and_normal_first(void **state) {
  (void)state;
  rig *r = rig_box(3, 0.01, 0.5, 0);
  const contact_set *c = rig_set(r);
  ASSERT_DOES_NOT_ABORT(begin_velocity, &r->set);
  const uint64_t id = r->id[1];
  r->id[1] = r->id[0];
  ASSERT_ABORTS(begin_velocity, &r->set);
  r->id[1] = id;
  r->rows[2].tangent = 1; /* of two rows after the normal */
  ASSERT_ABORTS(begin_velocity, &r->set);
  r->rows[2].tangent = 2;
  r->body[2] = c->n_body;
  ASSERT_ABORTS(begin_velocity, &r->set);
  free(r);
}

static rig *two_pinned(void) {
  rig *r = rig_new(3, 0.01);
  const double left[3] = {-0.5, 0, 0}, right[3] = {0.5, 0, 0};
  for (int b = 0; b < 3; b++) {
    (void)rig_body(r, 1, 0.2, 0.3, 0.4);
    r->x[b][0] = b;
  }
  rig_pin(r, 1, 0, left, right);
  rig_pin(r, 2, 1, left, right);
  return r;
}

static void eliminate(void *x) {
  base_error err = {0};
  (void)form_assembly_eliminate(x, &err);
}

static void joint_impulses(void *x) {
  double lambda[16] = {0};
  form_assembly_joint_impulses(x, lambda);
}

static void coupled_groups_and_joints_are_listed_once(void **state) {
  (void)state;
  base_error err = {0};
  rig *r = two_pinned();
  form_assembly a = {0};
  contact_memory memory = {0};
  const form_rule rule = {.level = FORM_LEVEL_VELOCITY, .activation = FORM_CLOSED};
  check_ok(contact_memory_begin(&memory, (contact_layout){.head = 1}, rig_set(r), &err), &err);
  check_ok(form_assembly_begin(&a, &r->set, FORM_ROWS_TANGENT, &rule, &memory, &err), &err);
  ASSERT_DOES_NOT_ABORT(eliminate, &a);
  const int near = a.near[1];
  a.near[1] = a.near[0];
  ASSERT_ABORTS(eliminate, &a);
  a.near[1] = near;
  check_ok(form_assembly_eliminate(&a, &err), &err);
  ASSERT_DOES_NOT_ABORT(joint_impulses, &a);
  a.joints.member[1] = a.joints.member[0];
  ASSERT_ABORTS(joint_impulses, &a);
  form_assembly_close(&a);
  contact_memory_close(&memory);
  free(r);
}

/* ---- what is reused --------------------------------------------------------------------------- */

typedef struct planned {
  reg_mass mass;
  const contact_set *set;
} planned;

static void fill_mass(void *x) {
  planned *t = x;
  reg_sparse_mass(t->set, &t->mass);
}

/* Two free bodies have a block each; planned for them, the factor does not stand for one. */
static void a_symbolic_factor_keeps_its_pattern(void **state) {
  (void)state;
  base_error err = {0};
  rig *two = rig_new(3, 0.01), *one = rig_new(3, 0.01);
  for (int b = 0; b < 2; b++) {
    (void)rig_body(two, 1, 0.2, 0.3, 0.4);
  }
  (void)rig_body(one, 1, 0.2, 0.3, 0.4);
  int order[] = {1, 0}, place[] = {0, 6}, link_start[] = {0, 0, 0}, link[1] = {0};
  planned t = {.set = rig_set(two)};
  t.mass.order = order;
  t.mass.place = place;
  t.mass.link_start = link_start;
  t.mass.link = link;
  check_ok(reg_sparse_plan(t.set, &t.mass, &err), &err);
  ASSERT_DOES_NOT_ABORT(fill_mass, &t);
  t.set = rig_set(one);
  ASSERT_ABORTS(fill_mass, &t);
  reg_sparse_close(&t.mass);
  free(two);
  free(one);
}

static void open_world(void *x) {
  base_error err = {0};
  world *w;
  if (world_open(&w, x, ~0u, &err) == BASE_OK) {
    world_close(w);
  }
}

static void a_world_starts_finite(void **state) {
  (void)state;
  scene_spec s;
  spec_init(&s);
  s.dim = 3;
  s.duration = 1;
  spec_body *b = add_body(&s, "ball", SPEC_SPHERE, 0.1);
  ASSERT_DOES_NOT_ABORT(open_world, &s);
  b->vel[1] = NAN; /* as no spec that was checked has */
  ASSERT_ABORTS(open_world, &s);
  spec_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_basis_names_each_variable_once),
      cmocka_unit_test(a_tableau_names_each_variable_once),
      cmocka_unit_test(columns_are_sorted_and_blocks_cover_the_rows),
      cmocka_unit_test(batches_are_a_partition_without_shared_bodies),
      cmocka_unit_test(contacts_are_unique_sorted_and_normal_first),
      cmocka_unit_test(coupled_groups_and_joints_are_listed_once),
      cmocka_unit_test(a_symbolic_factor_keeps_its_pattern),
      cmocka_unit_test(a_world_starts_finite),
  };
#ifdef NDEBUG
  print_message("1..%zu\n", sizeof tests / sizeof tests[0]);
  for (size_t i = 0; i < sizeof tests / sizeof tests[0]; i++) {
    print_message("ok %zu - %s # SKIP assertions are off\n", i + 1, tests[i].name);
  }
  return 0;
#else
  return cmocka_run_group_tests(tests, NULL, NULL);
#endif
}
