/* Blocks in a turning drum of eight sides. */
#include "problems/scenes/kit.h"
#include "problems/vec.h"

#include <stdlib.h>
#include <string.h>

enum { FACES = 8 };

typedef struct drum {
  int columns, layers, dim;
  double froude, mu, radius, mass, gravity, duration;
} drum;

static const base_field fields[] = {
    BASE_FIELD(drum, columns, BASE_INT, "1", 1, 1, 1000, "blocks side by side on a face"),
    BASE_FIELD(drum, layers, BASE_INT, "1", 2, 1, 1000, "blocks on each other there"),
    BASE_FIELD(drum, froude, BASE_REAL, "1", 6.0, 1e-6, 1e3,
               "omega^2 R/g: acceleration at the faces over gravity"),
    BASE_FIELD(drum, mu, BASE_REAL, "1", 0.6, 1e-6, 10.0, "friction coefficient"),
    BASE_FIELD(drum, radius, BASE_REAL, "m", 0.5, 1e-3, 1e2,
               "R, of the circle inside the eight faces"),
    BASE_FIELD(drum, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass of a block"),
    BASE_FIELD(drum, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(drum, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(drum, duration, BASE_REAL, "s", 0.2, 1e-3, 1e3, "time simulated"),
};

/* The blocks of a face take the middle 0.4 R of it, with a gap of a tenth between columns, and are half as high as wide. */
typedef struct lattice {
  double cell, half, half_height;
} lattice;

static lattice lattice_of(const drum *p) {
  const double cell = 0.4 * p->radius / p->columns, half = 0.45 * cell;
  return (lattice){cell, half, fmin(0.5 * half, 0.2 * p->radius / p->layers)};
}

/* At `along` on a face of the drum and `depth` from its axis, `face` eighths of a turn after the lowest. */
static void place(const scene_spec *s, int face, double along, double depth, double pos[3]) {
  const double turn = face * 2.0 * KIT_PI / FACES;
  pos[0] = along * cos(turn) + depth * sin(turn);
  pos[1] = 0.0;
  pos[kit_up(s)] = along * sin(turn) - depth * cos(turn);
}

/* The turn that does so: about z, and in space, where up is z, about -y. */
static void axis_of(const scene_spec *s, double axis[3]) {
  axis[0] = 0.0;
  axis[1] = (s->dim == 2) ? 0.0 : -1.0;
  axis[2] = (s->dim == 2) ? 1.0 : 0.0;
}

/* Half sizes of a part that is `along` by `high`, and `wide` along the axis. */
static void half_of(const scene_spec *s, double along, double high, double wide, double half[3]) {
  half[0] = along;
  half[1] = wide;
  half[kit_up(s)] = high;
}

static base_status add_drum(const drum *p, double omega, double wide, scene_spec *s,
                            base_error *err) {
  const double thick = 0.1 * p->radius, length = (p->radius + thick) * tan(KIT_PI / FACES);
  double axis[3];
  spec_body *b;
  BASE_TRY(spec_add_body(s, "drum", &b, err));
  axis_of(s, axis);
  b->kinematic = true;
  b->mass = 1.0;
  for (int k = 0; k < 3; k++) {
    b->inertia[k] = 1.0;
    b->omega[k] = omega * axis[k];
  }
  b->shape.kind = SPEC_COMPOUND;
  b->shape.part = calloc(FACES, sizeof *b->shape.part);
  if (b->shape.part == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the faces of a drum");
  }
  b->shape.n_part = FACES;
  for (int i = 0; i < FACES; i++) {
    spec_part *part = &b->shape.part[i];
    const double turn = i * KIT_PI / FACES;
    part->shape.kind = SPEC_BOX;
    half_of(s, length, thick, wide, part->shape.half);
    place(s, i, 0.0, p->radius + thick, part->pos);
    part->quat[0] = cos(turn);
    for (int k = 0; k < 3; k++) {
      part->quat[k + 1] = sin(turn) * axis[k];
    }
  }
  return BASE_OK;
}

static base_status add_blocks(const drum *p, double omega, scene_spec *s, base_error *err) {
  const lattice l = lattice_of(p);
  double half[3], axis[3], spin[3];
  half_of(s, l.half, l.half_height, l.half, half);
  axis_of(s, axis);
  for (int k = 0; k < 3; k++) {
    spin[k] = omega * axis[k];
  }
  for (int i = 0, n = 0; i < FACES; i++) {
    for (int at = 0; at < p->columns * p->layers; at++) {
      const double along = (at % p->columns - 0.5 * (p->columns - 1)) * l.cell;
      const int layer = at / p->columns;
      const double depth = p->radius - (2 * layer + 1) * l.half_height;
      char name[SPEC_NAME];
      double pos[3];
      spec_body *b;
      place(s, i, along, depth, pos);
      kit_name(name, "b", n++);
      BASE_TRY(kit_box(s, name, p->mass, half, pos, &b, err));
      memcpy(b->omega, spin, sizeof spin);
      v3_cross(spin, pos, b->vel);
      if (s->dim == 2) {
        b->angle = i * 2.0 * KIT_PI / FACES;
      } else {
        kit_turn(b, axis, i * 2.0 * KIT_PI / FACES);
      }
    }
  }
  return BASE_OK;
}

/* No block slips or tips: beside its face a block of the innermost layer feels omega^2 depth and gravity, and along it, at most
 * at `off` from the middle, |g sin + omega^2 off| <= mu (omega^2 depth + g cos) for every angle. */
static bool all_ride(const drum *p, double omega) {
  const lattice l = lattice_of(p);
  const double w2 = omega * omega, depth = p->radius - (2 * p->layers - 1) * l.half_height;
  const double off = 0.5 * (p->columns - 1) * l.cell;
  const double grip = fmin(p->mu, l.half / (p->layers * l.half_height));
  return w2 * (grip * depth - off) >= p->gravity * sqrt(1.0 + grip * grip);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const drum *p = param;
  const lattice l = lattice_of(p);
  const double omega = sqrt(p->froude * p->gravity / p->radius), T = p->duration;
  const double depth = p->radius - l.half_height, wide = 1.5 * l.half;
  if ((double)FACES * p->columns * p->layers > 2e6) {
    return BASE_FAIL(err, BASE_EINVAL, "8 columns layers = %g: need at most 2e6 blocks",
                     (double)FACES * p->columns * p->layers);
  }
  kit_world(s, p->dim, p->gravity, T, 0.002);
  BASE_TRY(add_drum(p, omega, wide, s, err));
  BASE_TRY(add_blocks(p, omega, s, err));
  if (p->dim == 3) {
    BASE_TRY(kit_wall(s, "front", 1, 1.0, -wide, err));
    BASE_TRY(kit_wall(s, "back", 1, -1.0, wide, err));
  }
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "b0.pos", err));
  BASE_TRY(kit_finite(s, err));
  BASE_TRY(kit_penetration(s, 1e-6, p->gravity * (1.0 + p->froude) * T, err));
  if (all_ride(p, omega)) {
    const double off = -0.5 * (p->columns - 1) * l.cell, w = omega * T;
    const double x = off * cos(w) + depth * sin(w), y = off * sin(w) - depth * cos(w);
    const double grows = omega * omega * p->radius * T;
    BASE_TRY(kit_expect(s, "b0.x", T, x, grows, "rides round: no block slips", err));
    BASE_TRY(kit_expect(s, (p->dim == 2) ? "b0.y" : "b0.z", T, y, grows,
                        "rides round: no block slips", err));
  }
  return BASE_OK;
}

KIT_SCENE(drum, "blocks in a turning drum", "mellmann2001",
          "A barrel of eight sides turns with blocks on all of them. They ride round with it "
          "where omega^2 r/g is at least sqrt(1 + 1/mu^2) for the innermost, in the middle of a "
          "face and too low to tip, and slip, fall and tumble below: centrifuging and cascading, "
          "from 8 blocks to thousands.",
          .situation = SITUATION_SLIDING);
