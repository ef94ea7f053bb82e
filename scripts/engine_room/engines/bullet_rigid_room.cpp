/* bullet_rigid_room.cpp - Bullet's world of rigid bodies (btDiscreteDynamicsWorld, sequential impulses) behind the plain arrays
 * of plain_room.py, as ode_room.c is ODE's. PyBullet has the world of multibodies only, whose solver is another one. Built by
 * scripts/engines where Bullet's headers are.
 *
 * Indices of bodies count in the order of their making, planes are -1, -2, ... Functions that make something answer its index.
 * Nothing sleeps, and nothing is damped; all else is as Bullet sets it. */
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace {

struct touch {
  int side[2];
  double point[3], force[3];
};

std::pair<int, int> ordered(int a, int b) {
  return a < b ? std::make_pair(a, b) : std::make_pair(b, a);
}

struct apart : btOverlapFilterCallback {
  std::set<std::pair<int, int>> pairs;

  bool needBroadphaseCollision(btBroadphaseProxy *p, btBroadphaseProxy *q) const override {
    const int a = static_cast<btCollisionObject *>(p->m_clientObject)->getUserIndex();
    const int b = static_cast<btCollisionObject *>(q->m_clientObject)->getUserIndex();
    return (a >= 0 || b >= 0) && pairs.count(ordered(a, b)) == 0;
  }
};

btVector3 vector(const double *x) {
  return {btScalar(x[0]), btScalar(x[1]), btScalar(x[2])};
}

void out3(const btVector3 &v, double *to) {
  for (int k = 0; k < 3; k++) {
    to[k] = v[k];
  }
}

} // namespace

extern "C" {

struct room {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  apart kept;
  std::vector<std::unique_ptr<btCollisionShape>> shape;
  std::vector<std::unique_ptr<btMotionState>> place;
  std::vector<std::unique_ptr<btRigidBody>> object;
  std::vector<btRigidBody *> body;
  std::vector<touch> contact;
  double mu = 0, bounce = 0;
  int n_plane = 0;
};

room *room_new(const double g[3], double mu, double bounce, int iterations) {
  auto *r = new room;
  r->mu = mu;
  r->bounce = bounce;
  r->world.setGravity(vector(g));
  r->world.getPairCache()->setOverlapFilterCallback(&r->kept);
  if (iterations > 0) {
    r->world.getSolverInfo().m_numIterations = iterations;
  }
  return r;
}

/* Friction and restitution of a pair are products, so each body has the root. */
static btRigidBody *add(room *r, double mass, btCollisionShape *shape, const btTransform &at,
                        const btVector3 &inertia, int index) {
  r->shape.emplace_back(shape);
  r->place.emplace_back(new btDefaultMotionState(at));
  r->object.emplace_back(new btRigidBody(btScalar(mass), r->place.back().get(), shape, inertia));
  btRigidBody *b = r->object.back().get();
  b->setFriction(btScalar(std::sqrt(r->mu)));
  b->setRestitution(btScalar(std::sqrt(r->bounce)));
  b->setActivationState(DISABLE_DEACTIVATION);
  b->setUserIndex(index);
  r->world.addRigidBody(b);
  return b;
}

int room_plane(room *r, const double up[3], double offset) {
  const int index = -1 - r->n_plane++;
  add(r, 0.0, new btStaticPlaneShape(vector(up), btScalar(offset)), btTransform::getIdentity(),
      btVector3(0, 0, 0), index);
  return index;
}

/* size: radius, or three half sides. holds: 0 free, 1 does not turn, 2 fixed, 3 + k axis k is left. */
int room_body(room *r, int is_ball, const double *size, double mass, const double *inertia,
              const double *state, int holds) {
  const int index = int(r->body.size());
  btCollisionShape *shape =
      is_ball ? static_cast<btCollisionShape *>(new btSphereShape(btScalar(*size)))
              : new btBoxShape(vector(size));
  const btVector3 axis = vector(state + 4);
  const btQuaternion turn{axis.x(), axis.y(), axis.z(), static_cast<btScalar>(state[3])};
  btRigidBody *b = add(r, holds == 2 ? 0.0 : mass, shape, btTransform(turn, vector(state)),
                       vector(inertia), index);
  b->setLinearVelocity(vector(state + 7));
  b->setAngularVelocity(vector(state + 10));
  if (holds == 1 || holds >= 3) {
    b->setAngularFactor(btScalar(0));
  }
  if (holds >= 3) {
    b->setLinearFactor(btVector3(holds == 3, holds == 4, holds == 5));
  }
  r->body.push_back(b);
  return index;
}

int room_apart(room *r, int a, int b) {
  btBroadphaseProxy *p = r->body[size_t(a)]->getBroadphaseProxy();
  btBroadphaseProxy *q = r->body[size_t(b)]->getBroadphaseProxy();
  r->kept.pairs.insert(ordered(a, b));
  r->world.getPairCache()->removeOverlappingPair(p, q, &r->dispatcher);
  return 0;
}

void room_push(room *r, int body, const double force[3]) {
  r->body[size_t(body)]->applyCentralForce(vector(force));
}

/* Collides and steps once by h. */
void room_step(room *r, double h, int) {
  r->world.stepSimulation(btScalar(h), 0);
}

/* 13 numbers a body: position, quaternion (w, x, y, z), velocity, angular velocity. */
void room_states(const room *r, double *out) {
  for (const btRigidBody *b : r->body) {
    const btQuaternion q = b->getWorldTransform().getRotation();
    out3(b->getWorldTransform().getOrigin(), out);
    out[3] = q.w();
    out[4] = q.x();
    out[5] = q.y();
    out[6] = q.z();
    out3(b->getLinearVelocity(), out + 7);
    out3(b->getAngularVelocity(), out + 10);
    out += 13;
  }
}

/* The contacts of the last step, of length h. */
int room_n_contact(room *r, double h) {
  r->contact.clear();
  for (int m = 0; m < r->dispatcher.getNumManifolds(); m++) {
    const btPersistentManifold *of = r->dispatcher.getManifoldByIndexInternal(m);
    for (int k = 0; k < of->getNumContacts(); k++) {
      const btManifoldPoint &p = of->getContactPoint(k);
      touch t = {{of->getBody0()->getUserIndex(), of->getBody1()->getUserIndex()}, {}, {}};
      out3(p.getPositionWorldOnB(), t.point);
      out3((p.m_normalWorldOnB * p.m_appliedImpulse +
            p.m_lateralFrictionDir1 * p.m_appliedImpulseLateral1 +
            p.m_lateralFrictionDir2 * p.m_appliedImpulseLateral2) /
               btScalar(h),
           t.force);
      r->contact.push_back(t);
    }
  }
  return int(r->contact.size());
}

/* Contact i: its bodies, and point and force on the first of them. */
void room_contact_at(const room *r, int i, int side[2], double out[6]) {
  const touch &t = r->contact[size_t(i)];
  for (int k = 0; k < 3; k++) {
    side[k % 2] = t.side[k % 2];
    out[k] = t.point[k];
    out[3 + k] = t.force[k];
  }
}
}
