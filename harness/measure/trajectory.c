#include "harness/measure/trajectory.h"

#include "harness/util/csv.h"
#include "lcp/base/fields.h"
#include "problems/world/model.h"

static const double nothing[3] = {0.0, 0.0, 0.0};
static const double upright[4] = {1.0, 0.0, 0.0, 0.0};

/* Ends a run whose trajectory has nowhere to go; closing the file tells why (base_out_close). */
static base_status written(FILE *to, base_error *err) {
  return ferror(to) ? BASE_FAIL(err, BASE_EIO, "trajectory: could not be written") : BASE_OK;
}

static void put(FILE *to, const double *x, int n) {
  for (int i = 0; i < n; i++) {
    char number[32];
    base_real_print(x[i], number, sizeof number);
    (void)fprintf(to, ",%s", number);
  }
}

typedef struct line {
  double t;
  const char *kind, *name, *word;
  const double *pos, *quat, *vel, *omega, *size; /* NULL: zero, upright */
} line;

static void put_line(FILE *to, const line *l) {
  char time[32];
  base_real_print(l->t, time, sizeof time);
  (void)fprintf(to, "%s,%s,", time, l->kind);
  csv_put(l->name, to);
  (void)fprintf(to, ",%s", l->word);
  put(to, l->pos != NULL ? l->pos : nothing, 3);
  put(to, l->quat != NULL ? l->quat : upright, 4);
  put(to, l->vel != NULL ? l->vel : nothing, 3);
  put(to, l->omega != NULL ? l->omega : nothing, 3);
  put(to, l->size != NULL ? l->size : nothing, 3);
  (void)fputc('\n', to);
}

/* One line for a shape, one for each vertex of a polygon, those of its parts for a compound. */
static void put_shape(FILE *to, const char *body, const spec_shape *s, const double *pos,
                      const double *quat) {
  static const char *const words[] = {"point", "sphere",  "box",     "rod",
                                      "disc",  "polygon", "compound"};
  const double round[3] = {s->r, s->r, s->r};
  const double rod[3] = {s->half[0], s->r, s->r};
  const double disc[3] = {s->r, s->r, s->half[2]};
  const double *const sizes[] = {nothing, round, s->half, rod, disc, nothing, nothing};
  if (s->kind == SPEC_COMPOUND) {
    for (int i = 0; i < s->n_part; i++) {
      const spec_part *part = &s->part[i];
      if (part->shape.kind != SPEC_COMPOUND) {
        put_shape(to, body, &part->shape, part->pos, part->quat);
      }
    }
    return;
  }
  put_line(to, &(line){.kind = "shape",
                       .name = body,
                       .word = words[s->kind],
                       .pos = pos,
                       .quat = quat,
                       .size = sizes[s->kind]});
  for (int i = 0; s->kind == SPEC_POLYGON && i < s->n_vertex; i++) {
    const double at[3] = {s->vertex[i][0], s->vertex[i][1], 0.0};
    put_line(to, &(line){.kind = "vertex", .name = body, .word = "", .pos = at});
  }
}

/* Parts of a mechanism in generalised coordinates. */
static void put_parts(FILE *to, const scene_spec *spec) {
  const mech_model *m = spec->model;
  for (int b = 0; m != NULL && b < m->n_body; b++) {
    double size[3] = {0.0};
    m->half(spec->model_param, b, size);
    put_line(to, &(line){.kind = "shape", .name = m->body_name[b], .word = "box", .size = size});
  }
}

base_status trajectory_header(FILE *to, const scene_spec *spec, base_error *err) {
  if (to == NULL) {
    return BASE_OK;
  }
  (void)fputs("t_s,kind,name,word,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,omega_x_rad_s,"
              "omega_y_rad_s,omega_z_rad_s,sx,sy,sz\n",
              to);
  put_line(to, &(line){.kind = "scene", .name = spec->id, .word = spec->dim == 2 ? "2" : "3"});
  for (int i = 0; i < spec->n_static; i++) {
    const spec_static *s = &spec->fixed[i];
    const double foot[3] = {s->offset * s->normal[0], s->offset * s->normal[1],
                            s->offset * s->normal[2]};
    put_line(to, &(line){.kind = "plane",
                         .name = s->name,
                         .word = "",
                         .pos = foot,
                         .vel = s->surface_velocity,
                         .size = s->normal});
  }
  put_parts(to, spec);
  for (int b = 0; b < spec->n_body; b++) {
    put_shape(to, spec->body[b].name, &spec->body[b].shape, NULL, NULL);
  }
  return written(to, err);
}

base_status trajectory_row(FILE *to, const world *w, base_error *err) {
  if (to == NULL) {
    return BASE_OK;
  }
  for (int b = 0; b < world_n_body(w); b++) {
    double pos[3];
    double quat[4];
    double vel[3];
    double omega[3];
    world_body_pose(w, b, pos, quat);
    world_body_velocity(w, b, vel, omega);
    put_line(to, &(line){.t = world_time(w),
                         .kind = "body",
                         .name = world_body_name(w, b),
                         .word = "",
                         .pos = pos,
                         .quat = quat,
                         .vel = vel,
                         .omega = omega});
  }
  return written(to, err);
}

base_status trajectory_contacts(FILE *to, const world *w, const contact_set *set,
                                const unsigned char *mode, base_error *err) {
  static const char *const words[] = {"open", "stick", "slip"};
  if (to == NULL) {
    return BASE_OK;
  }
  for (int i = 0; i < set->n_contact; i++) {
    double point[3];
    double force[3];
    const char *a;
    const char *b;
    char name[2 * SPEC_NAME + 2];
    world_contact_point(w, i, point);
    world_contact_force(w, i, force);
    world_contact_pair(w, set->id[i], &a, &b);
    (void)snprintf(name, sizeof name, "%s|%s", a, b);
    put_line(to, &(line){.t = world_time(w),
                         .kind = "contact",
                         .name = name,
                         .word = (mode != NULL && mode[i] < 3) ? words[mode[i]] : "",
                         .pos = point,
                         .size = force});
  }
  return written(to, err);
}
