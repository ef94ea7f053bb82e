/* tests/support/rig.h - contact sets built by hand, for tests of formulations without a world:
 * bodies whose contact points keep their offsets (no finite rotation), semi-implicit Euler. */
#pragma once

#include "formulations/formulation.h"
#include "problems/world/contact_set.h"

enum { RIG_BODIES = 32, RIG_CONTACTS = 160, RIG_JOINTS = 16 };
enum { RIG_GROUPS = RIG_CONTACTS + RIG_JOINTS };

typedef struct rig_contact {
  int a, b;                  /* bodies; b = -1: ground */
  double ra[3], rb[3];       /* offsets of the points [m] */
  double n[3], t1[3], t2[3]; /* n from b towards a */
  double mu, mu_k, e, torsion, rolling;
  double belt; /* velocity of side b along t1 [m/s] */
} rig_contact;

/* Points of two bodies that stay together. */
typedef struct rig_joint {
  int a, b;
  double ra[3], rb[3];
} rig_joint;

typedef struct rig {
  int dim; /* 2: dofs x, y, rz; 3: x, y, z, rx, ry, rz */
  double h, t, gravity[3];
  int n_body, n_contact;
  double mass[RIG_BODIES], inertia[RIG_BODIES][3];
  double x[RIG_BODIES][3];
  double v[6 * RIG_BODIES], v_start[6 * RIG_BODIES];
  rig_contact contact[RIG_CONTACTS];
  int n_joint;
  rig_joint joint[RIG_JOINTS];

  /* storage behind `set` */
  contact_set set;
  int dof_start[RIG_BODIES + 1], mass_start[RIG_BODIES + 1];
  double M[36 * RIG_BODIES], W[36 * RIG_BODIES], v_free[6 * RIG_BODIES];
  int row_start[RIG_GROUPS + 1], body[2 * RIG_GROUPS], jac_start[RIG_GROUPS + 1];
  double jac[RIG_GROUPS * 72], drift[RIG_GROUPS * 6], before[RIG_GROUPS * 6];
  double curve[RIG_GROUPS * 6]; /* zero: the points keep their offsets */
  double error[RIG_JOINTS * 3];
  uint64_t id[RIG_CONTACTS];
  contact_rows rows[RIG_CONTACTS];
  double gap[RIG_CONTACTS], mu_s[RIG_CONTACTS], mu_k[RIG_CONTACTS], torsion[RIG_CONTACTS],
      rolling[RIG_CONTACTS], e[RIG_CONTACTS], frame[9 * RIG_CONTACTS], spin[3 * RIG_CONTACTS];
  formulation_answer answer;
  long solves;
} rig;

rig *rig_new(int dim, double h); /* freed with free() */
int rig_body(rig *r, double mass, double ix, double iy, double iz);
/* Point contact; the tangents follow the convention of the case files. */
rig_contact *rig_touch(rig *r, int a, int b, const double *ra, const double *rb, const double *n,
                       double mu);
const contact_set *rig_set(rig *r);

void rig_pin(rig *r, int a, int b, const double *ra, const double *rb);

/* One step with the formulation and the tableau solver. */
void rig_step(rig *r, formulation_run *run);
double rig_kinetic(const rig *r);

/* A box of half sizes on the plane z = 0 (y = 0 in 2D), tilted by turning gravity. */
rig *rig_box(int dim, double h, double mu, double incline);
/* n unit boxes (half 0.5, mass 1) on top of each other, four contacts an interface. */
rig *rig_stack(int n, double h, double mu);
/* Random bodies and contacts with a given seed. */
rig *rig_random(uint64_t seed, int dim, double mu_most);

formulation_run *rig_open(const char *formulation, const char *options);
void rig_close(formulation_run *run); /* also frees the options */
