/* Scenes as scene files: what is written is read back to the same numbers, and what a file does not
 * hold is refused. */
#include "tests/support/check.h"

#include "problems/read/case_file.h"
#include "problems/write/scene_write.h"
#include "tests/support/files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char path[256];

/* The text of a scene; the caller frees it. */
static char *written(const scene_spec *s) {
  char *text = NULL;
  size_t size = 0;
  base_error err = {0};
  FILE *to = open_memstream(&text, &size);
  assert_non_null(to);
  check_ok(scene_write(to, s, &err), &err);
  assert_int_equal(fclose(to), 0);
  return text;
}

static void read_text(const char *text, scene_spec *s) {
  base_error err = {0};
  FILE *to = fopen(path, "wb");
  assert_non_null(to);
  assert_int_equal(fwrite(text, 1, strlen(text), to), strlen(text));
  assert_int_equal(fclose(to), 0);
  check_ok(scene_load(path, s, &err), &err);
}

static void same(const double *a, const double *b, int n) { /* -0 is 0 */
  for (int i = 0; i < n; i++) {
    assert_true(a[i] == b[i]);
  }
}

static void same_bodies(const scene_spec *a, const scene_spec *b) {
  assert_int_equal(a->n_body, b->n_body);
  for (int i = 0; i < a->n_body; i++) {
    const spec_body *p = &a->body[i], *q = &b->body[i];
    assert_string_equal(p->name, q->name);
    assert_int_equal(p->shape.kind, q->shape.kind);
    same(p->shape.half, q->shape.half, a->dim);
    assert_int_equal(p->shape.n_vertex, q->shape.n_vertex);
    for (int k = 0; k < p->shape.n_vertex; k++) {
      same(p->shape.vertex[k], q->shape.vertex[k], 2);
    }
    same(p->pos, q->pos, 3);
    same(p->vel, q->vel, 3);
    same(p->omega, q->omega, 3);
    same(p->prescribed_a, q->prescribed_a, 6);
    assert_true(p->shape.r == q->shape.r && p->lock == q->lock);
    if (a->dim == 2) {
      assert_true(p->angle == q->angle);
    } else {
      same(p->quat, q->quat, 4);
    }
    assert_true(p->kinematic == q->kinematic && (p->kinematic || p->mass == q->mass));
    if (!p->kinematic) {
      same(p->inertia, q->inertia, a->dim == 2 ? 1 : 3);
    }
  }
}

static void same_ties(const scene_spec *a, const scene_spec *b) {
  assert_int_equal(a->n_load, b->n_load);
  assert_int_equal(a->n_joint, b->n_joint);
  assert_int_equal(a->n_check, b->n_check);
  assert_int_equal(a->n_off, b->n_off);
  assert_int_equal(a->effects, b->effects);
  for (int i = 0; i < a->n_load; i++) {
    const spec_load *p = &a->load[i], *q = &b->load[i];
    assert_true(p->kind == q->kind && p->body == q->body && p->other == q->other);
    if (p->kind == SPEC_FORCE) {
      same(p->force, q->force, 3);
    } else if (p->kind == SPEC_SPRING) {
      assert_true(p->k == q->k && p->c == q->c);
      same(p->anchor_vel, q->anchor_vel, 3);
    }
  }
  for (int i = 0; i < a->n_joint; i++) {
    assert_true(a->joint[i].kind == b->joint[i].kind && a->joint[i].body == b->joint[i].body);
    same(a->joint[i].anchor, b->joint[i].anchor, 3);
  }
  for (int i = 0; i < a->n_check; i++) {
    const spec_check *p = &a->check[i], *q = &b->check[i];
    assert_true(p->kind == q->kind && p->value == q->value && p->t == q->t && p->t1 == q->t1);
    assert_memory_equal(&p->tol, &q->tol, sizeof p->tol);
    assert_string_equal(p->var, q->var);
    assert_int_equal(p->n_form, q->n_form);
  }
}

static void comes_back(const scene_spec *s) {
  scene_spec again;
  char *first = written(s);
  read_text(first, &again);
  char *second = written(&again);
  assert_string_equal(first, second);
  same_bodies(s, &again);
  same_ties(s, &again);
  free(second);
  free(first);
  spec_free(&again);
}

/* What a scene file does not hold. */
static bool is_refused(const scene_spec *s) {
  base_error err = {0};
  FILE *to = fopen("/dev/null", "w");
  assert_non_null(to);
  const base_status status = scene_write(to, s, &err);
  assert_int_equal(fclose(to), 0);
  assert_true(status == BASE_OK || status == BASE_EUNSUPPORTED);
  return status == BASE_EUNSUPPORTED;
}

static void built_in_scenes_come_back(void **state) {
  (void)state;
  int n, n_refused = 0;
  const scene *const *all = scenes(&n);
  for (int i = 0; i < n; i++) {
    scene_spec s;
    base_error err = {0};
    check_ok(scene_build(all[i]->name, &s, &err), &err);
    assert_int_equal(is_refused(&s), s.model != NULL);
    if (s.model == NULL) {
      comes_back(&s);
    } else {
      n_refused++;
    }
    spec_free(&s);
  }
  assert_int_equal(n_refused, 2);
  assert_true(n > 40);
}

static void cases_come_back(void **state) {
  (void)state;
  scene_file f;
  base_error err = {0};
  int n_back = 0;
  check_ok(scene_file_read(tests_file("cases/cases.json"), &f, &err), &err);
  for (int i = 0; i < f.n_scene; i++) {
    const bool compliant = f.scene[i].contact_stiffness > 0.0;
    assert_int_equal(is_refused(&f.scene[i]), compliant);
    if (!compliant) {
      comes_back(&f.scene[i]);
      n_back++;
    }
  }
  assert_int_equal(n_back, f.n_scene - 6);
  scene_file_free(&f);
}

static int remove_file(void **state) {
  (void)state;
  return unlink(path);
}

int main(void) {
  const char *folder = getenv("TMPDIR");
  (void)snprintf(path, sizeof path, "%s/lcpbench_write_%d.json", folder != NULL ? folder : "/tmp",
                 (int)getpid());
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(built_in_scenes_come_back),
      cmocka_unit_test(cases_come_back),
  };
  return cmocka_run_group_tests(tests, NULL, remove_file);
}
