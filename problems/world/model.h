/* problems/world/model.h - a mechanism in generalised coordinates, for systems that are not a set of
 * rigid bodies with shapes (woodpecker, slider-crank).
 *
 *   M(q) vdot = f(t, q, v) + sum Jn' lambda_n + Jt' lambda_t,   qdot = v
 * with f holding every other force: gravity, springs, and the velocity terms of a varying M.
 * World treats it as one block of n_dof dofs touching the ground in n_contact places.
 *
 * Every function is pure in (param, q, v, t); `param` is scene_spec.model_param. */
#pragma once

enum { MODEL_DOF_MAX = 16 };

/* One possible contact: names for checks and coefficients that hold where the scene has contact,
 * friction and restitution. */
typedef struct mech_contact {
  const char *a, *b;      /* names of the two sides */
  double mu, restitution; /* [1] */
} mech_contact;

typedef struct mech_model {
  const char *name;
  int dim;       /* of the mechanism; a contact has dim - 1 tangents where mu > 0 */
  int n_dof;     /* <= MODEL_DOF_MAX */
  int n_contact; /* possible contacts, listed in every set when their gap is below the margin */
  const char *const *dof_name; /* n_dof; observables "NAME", "NAME.v" */

  void (*start)(const void *param, double *q, double *v);
  void (*mass)(const void *param, const double *q, double *M); /* dense column-major SPD */
  void (*force)(const void *param, double t, const double *q, const double *v, double *f);
  double (*potential)(const void *param, double t, const double *q); /* [J]; NULL: 0 */

  void (*contact)(const void *param, int i, mech_contact *out);
  /* Gap [m], its gradient jn (n_dof), tangent rows jt ((dim-1) x n_dof, row-major). */
  void (*gap)(const void *param, const double *q, int i, double *gap, double *jn, double *jt);

  /* For pictures; 0 and NULL: none. Poses of n_body named parts, planar rectangles of half sizes
   * `half` [m], and where contact i touches: point, normal and tangent in the plane. */
  int n_body;
  const char *const *body_name;
  void (*half)(const void *param, int body, double half[2]);
  void (*pose)(const void *param, const double *q, int body, double pos[3], double quat[4]);
  void (*place)(const void *param, const double *q, int i, double point[3], double normal[3],
                double tangent[3]);
} mech_model;
