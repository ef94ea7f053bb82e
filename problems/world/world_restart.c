/* world_restart.c - the scene that begins where a run of it has come to. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

static const char *load_in_the_way(const scene_spec *s) {
  for (int i = 0; i < s->n_load; i++) {
    if (s->load[i].kind == SPEC_FORCE_RAMP && s->load[i].rate != 0.0) {
      return "a force that grows with the time since its beginning";
    }
  }
  return NULL;
}

base_status world_can_restart(const scene_spec *s, base_error *err) {
  const char *why = (s->model != NULL)             ? "generalised coordinates"
                    : (s->contact_stiffness > 0.0) ? "compliant contact"
                                                   : load_in_the_way(s);
  return (why == NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EUNSUPPORTED,
                         "scene '%s': no scene file begins at its end: it has %s", s->id, why);
}

/* A rotation matrix of an orientation; planar: by the angle. */
static void turn_of(const scene_spec *s, const spec_body *b, double *R) {
  const double planar[4] = {cos(0.5 * b->angle), 0.0, 0.0, sin(0.5 * b->angle)};
  double q[4];
  memcpy(q, s->dim == 2 ? planar : b->quat, sizeof q);
  quat_normalise(q);
  quat_matrix(q, R);
}

/* The motion of a body from the beginning of the scene to where it is now. */
typedef struct motion {
  double from[3], to[3], R[9];
} motion;

static motion motion_of(const scene_spec *s, const spec_body *before, const spec_body *now) {
  motion m;
  double R0[9], R1[9];
  turn_of(s, before, R0);
  turn_of(s, now, R1);
  for (int i = 0; i < 3; i++) { /* R1 R0', by rows */
    for (int j = 0; j < 3; j++) {
      m.R[3 * i + j] = v3_dot(R1 + 3 * (ptrdiff_t)i, R0 + 3 * (ptrdiff_t)j);
    }
  }
  v3_copy(before->pos, m.from);
  v3_copy(now->pos, m.to);
  return m;
}

static void carry_point(const motion *m, double *p) {
  double arm[3];
  double turned[3];
  v3_sub(p, m->from, arm);
  m3_mul_vec(m->R, arm, turned);
  v3_add_scaled(m->to, 1.0, turned, p);
}

static void carry_axis(const motion *m, double *axis) {
  double turned[3];
  m3_mul_vec(m->R, axis, turned);
  v3_copy(turned, axis);
}

static void restart_body(const world *w, int i, spec_body *b) {
  const body *at = &w->body[i];
  double quat[4];
  world_body_pose(w, i, b->pos, quat);
  world_body_velocity(w, i, b->vel, b->omega);
  b->angle = (w->dim == 2) ? at->angle : b->angle;
  if (w->dim == 3) {
    memcpy(b->quat, quat, sizeof b->quat);
  }
  for (int k = 0; k < 6; k++) {
    b->prescribed_v0[k] += w->t * b->prescribed_a[k];
  }
}

static void restart_load(double t, spec_load *l) {
  l->phase += l->omega * t;
  v3_add_scaled(l->anchor, t, l->anchor_vel, l->anchor);
}

/* Nothing but this is known of a run that begins later. */
static void keep_checks(scene_spec *s) {
  int n = 0;
  for (int i = 0; i < s->n_check; i++) {
    if (s->check[i].kind == CHECK_FINITE) {
      s->check[n++] = s->check[i];
    }
  }
  s->n_check = n;
  s->n_off = 0;
}

void world_restart(const world *w, scene_spec *s) {
  for (int k = 0; k < s->n_joint; k++) {
    spec_joint *j = &s->joint[k];
    spec_body now = s->body[j->body];
    restart_body(w, j->body, &now);
    const motion m = motion_of(s, &s->body[j->body], &now);
    carry_point(&m, j->anchor);
    carry_axis(&m, j->axis);
    if (j->other >= 0) {
      now = s->body[j->other];
      restart_body(w, j->other, &now);
      const motion other = motion_of(s, &s->body[j->other], &now);
      carry_point(&other, j->other_anchor);
    }
  }
  for (int i = 0; i < s->n_body; i++) {
    restart_body(w, i, &s->body[i]);
  }
  for (int i = 0; i < s->n_load; i++) {
    restart_load(w->t, &s->load[i]);
  }
  keep_checks(s);
}
