/* ode_room.c - a world of ODE behind the plain arrays of plain_room.py: what is called once for each pair of
 * bodies would cost more in Python than the step does. Built by scripts/engines where ODE's headers are.
 *
 * Numbers are doubles, as ODE's (dDOUBLE); indices of bodies count in the order of their making, planes
 * are -1, -2, ... Functions that make something answer its index. */
#include <ode/ode.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 16 }; /* of a pair, as many as dCollide is asked for */

typedef struct room_contact {
  dJointFeedback force;
  double point[3];
  int a, b;
} room_contact;

typedef struct room {
  dWorldID world;
  dSpaceID space;
  dJointGroupID joints;
  int n_body, n_plane, n_contact, cap_contact;
  dBodyID *body;
  unsigned char *apart; /* n_apart pairs */
  int n_apart, pair[64][2];
  double mu, bounce;
  room_contact **contact; /* each stays where it is: ODE holds its address */
} room;

room *room_new(const double g[3], double mu, double bounce, int iterations) {
  dInitODE2(0);
  room *r = calloc(1, sizeof *r);
  r->world = dWorldCreate();
  r->space = dHashSpaceCreate(0);
  r->joints = dJointGroupCreate(0);
  r->mu = mu;
  r->bounce = bounce;
  dWorldSetGravity(r->world, g[0], g[1], g[2]);
  if (iterations > 0) {
    dWorldSetQuickStepNumIterations(r->world, iterations);
  }
  return r;
}

void room_soften(room *r, double erp, double cfm) {
  dWorldSetERP(r->world, erp);
  dWorldSetCFM(r->world, cfm);
}

static void keep(dGeomID g, int index) {
  dGeomSetData(g, (void *)(size_t)(index + 1024)); /* planes are negative */
}

static int index_of(dGeomID g) {
  return (int)(size_t)dGeomGetData(g) - 1024;
}

int room_plane(room *r, const double up[3], double offset) {
  keep(dCreatePlane(r->space, up[0], up[1], up[2], offset), -1 - r->n_plane);
  return -1 - r->n_plane++;
}

/* size: radius, or three half sides. holds: 0 free, 1 does not turn, 2 fixed, 3 + k axis k is left. */
int room_body(room *r, int is_ball, const double *size, double mass, const double *inertia,
              const double *state, int holds) {
  r->body = realloc(r->body, (size_t)(r->n_body + 1) * sizeof *r->body);
  dBodyID b = dBodyCreate(r->world);
  dGeomID g = is_ball ? dCreateSphere(r->space, size[0])
                      : dCreateBox(r->space, 2.0 * size[0], 2.0 * size[1], 2.0 * size[2]);
  dMass m;
  const double heavy = (holds == 1) ? 1e12 : 1.0; /* no joint of ODE holds three turns alone */
  dMassSetParameters(&m, mass, 0.0, 0.0, 0.0, heavy * inertia[0], heavy * inertia[1],
                     heavy * inertia[2], 0.0, 0.0, 0.0);
  dBodySetMass(b, &m);
  dGeomSetBody(g, b);
  keep(g, r->n_body);
  dBodySetPosition(b, state[0], state[1], state[2]);
  dBodySetQuaternion(b, state + 3);
  dBodySetLinearVel(b, state[7], state[8], state[9]);
  dBodySetAngularVel(b, state[10], state[11], state[12]);
  if (holds == 2) {
    dBodySetKinematic(b);
  } else if (holds >= 3) {
    dJointID j = dJointCreateSlider(r->world, 0);
    dJointAttach(j, b, 0);
    dJointSetSliderAxis(j, holds == 3, holds == 4, holds == 5);
  }
  r->body[r->n_body] = b;
  return r->n_body++;
}

/* At most 64 pairs: 1 where there is no room for another. */
int room_apart(room *r, int a, int b) {
  if (r->n_apart == 64) {
    return 1;
  }
  r->pair[r->n_apart][0] = a;
  r->pair[r->n_apart++][1] = b;
  return 0;
}

void room_push(room *r, int body, const double force[3]) {
  dBodyAddForce(r->body[body], force[0], force[1], force[2]);
}

static int is_apart(const room *r, int a, int b) {
  for (int i = 0; i < r->n_apart; i++) {
    const int *p = r->pair[i];
    if ((p[0] == a && p[1] == b) || (p[0] == b && p[1] == a)) {
      return 1;
    }
  }
  return 0;
}

static room_contact *next_contact(room *r) {
  if (r->n_contact == r->cap_contact) {
    r->contact = realloc(r->contact, (size_t)(r->cap_contact + 64) * sizeof *r->contact);
    for (int i = 0; i < 64; i++) {
      r->contact[r->cap_contact + i] = calloc(1, sizeof **r->contact);
    }
    r->cap_contact += 64;
  }
  return r->contact[r->n_contact++];
}

static void near(void *data, dGeomID p, dGeomID q) {
  room *r = data;
  dContact c[POINTS];
  memset(c, 0, sizeof c);
  const int a = index_of(p), b = index_of(q);
  if ((a < 0 && b < 0) || is_apart(r, a, b)) {
    return;
  }
  const int n = dCollide(p, q, POINTS, &c[0].geom, sizeof c[0]);
  for (int i = 0; i < n; i++) {
    c[i].surface.mode = dContactApprox1; /* mu is a coefficient, by a pyramid; else it is a force */
    c[i].surface.mu = r->mu;
    if (r->bounce > 0.0) {
      c[i].surface.mode |= dContactBounce;
      c[i].surface.bounce = r->bounce;
    }
    room_contact *to = next_contact(r);
    dJointID j = dJointCreateContact(r->world, r->joints, &c[i]);
    dJointAttach(j, dGeomGetBody(p), dGeomGetBody(q));
    to->a = a;
    to->b = b;
    memcpy(to->point, c[i].geom.pos, sizeof to->point);
    memset(&to->force, 0, sizeof to->force);
    dJointSetFeedback(j, &to->force);
  }
}

/* Collides and steps; the contacts of the step stay readable until the next one. */
void room_step(room *r, double h, int quick) {
  r->n_contact = 0;
  dJointGroupEmpty(r->joints);
  dSpaceCollide(r->space, r, near);
  if (quick) {
    dWorldQuickStep(r->world, h);
  } else {
    dWorldStep(r->world, h);
  }
}

/* 13 numbers a body: position, quaternion (w, x, y, z), velocity, angular velocity. */
void room_states(const room *r, double *out) {
  for (int i = 0; i < r->n_body; i++, out += 13) {
    memcpy(out, dBodyGetPosition(r->body[i]), 3 * sizeof *out);
    memcpy(out + 3, dBodyGetQuaternion(r->body[i]), 4 * sizeof *out);
    memcpy(out + 7, dBodyGetLinearVel(r->body[i]), 3 * sizeof *out);
    memcpy(out + 10, dBodyGetAngularVel(r->body[i]), 3 * sizeof *out);
  }
}

/* Of the last step, of length h. */
int room_n_contact(const room *r, double h) {
  (void)h;
  return r->n_contact;
}

/* Contact i: its bodies, and point and force on the first of them. ODE tells the force on the body
 * that a joint is attached to first, which of a plane and a body is the body. */
void room_contact_at(const room *r, int i, int side[2], double out[6]) {
  const room_contact *c = r->contact[i];
  side[0] = c->a;
  side[1] = c->b;
  memcpy(out, c->point, sizeof c->point);
  for (int k = 0; k < 3; k++) {
    out[3 + k] = (c->a < 0) ? -c->force.f1[k] : c->force.f1[k];
  }
}

const char *room_configuration(void) {
  return dGetConfiguration();
}
