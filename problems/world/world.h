/* problems/world/world.h - a scene in motion: bodies, exact gap functions, contact sets, energies.
 *
 * One step of the caller:
 *   world_contacts(w, h, &set) -> formulation, solver -> world_advance(w, v_next, impulse)
 * Semi-implicit Euler: everything is evaluated at the start of the step, q+ = q + h N v+, with the
 * orientation turned exactly by h omega+. Loads are explicit (a spring is symplectic Euler, refused
 * where h^2 k/m >= 4); gyroscopic torques follow the implicit midpoint rule (body.h), which keeps
 * energy and |angular momentum| of free bodies for every h. Driven velocities count at the end of
 * the step. Bodies joined by a joint still collide unless the spec says no_collision. */
#pragma once

#include "problems/spec/spec.h"
#include "problems/world/contact_set.h"

typedef struct world world; /* opaque: owns every array */

/* Builds the world of a checked spec with the effects in `effects` (EFFECT_ bits; what is missing
 * gets no dof, row or force). The spec is copied. */
base_status world_open(world **out, const scene_spec *spec, unsigned effects, base_error *err);
/* The same over the spec itself, which is not copied: it stays as it is until the world is closed. */
base_status world_open_over(world **out, const scene_spec *spec, unsigned effects, base_error *err);
/* Bodies go on from where they are with other effects, the clock too; the last contact set is no longer valid. An axis that stands
 * still without an effect is at rest. */
base_status world_set_effects(world *w, unsigned effects, base_error *err);
void world_close(world *w);

/* Sleeping: a body that lay still at the end of four steps in a row, with all that it is in contact with or joined to, has no dofs, no
 * contacts and no joint rows from there on; its velocity is 0. Bodies under a load that may change sleep never, nor what touches a belt or a
 * driven body that moves. A moving side that comes as near as a contact is listed wakes all of the group that fell asleep together.
 *
 * Still is what moves by less than 2e-11 of the velocity that gravity and its loads give the body in the step, and does not get faster from
 * step to step, as what begins to fall. Behind world_advance (and world_shift with `shift`, NULL: none): may some body fall asleep? */
bool world_count_still(world *w, const double *shift);
/* What is remembered of this contact of the last set has changed by so much in it [N s]: its bodies may not yet, if that is more than 1e-9 of what
 * their loads give. */
void world_stir(world *w, uint64_t id, double by);
/* *some: bodies fell asleep, and the last set is no longer valid. BASE_ENOMEM. */
base_status world_fall_asleep(world *w, bool *some, base_error *err);
/* Does a contact of the last set have a side that sleeps? It is to be woken then, and the contacts are others. */
bool world_is_reached(const world *w);
/* The groups that it reaches, or all. */
base_status world_wake(world *w, bool all, base_error *err);
int world_n_asleep(const world *w);                     /* bodies */
bool world_just_fell_asleep(const world *w, int i);     /* in the last world_fall_asleep */
bool world_contact_sleeps(const world *w, uint64_t id); /* a side of it does, and none is awake */
/* Who sleeps, and for how many steps the others lay still: world_sleep_size numbers, to come back to. BASE_ENOMEM. */
size_t world_sleep_size(const world *w);
void world_sleep_save(const world *w, double *asleep);
base_status world_sleep_load(world *w, const double *asleep, base_error *err);

/* Detects contacts with gap below margin at the current configuration and fills *out with views
 * valid until the next call. margin < 0: chosen from h and the speeds. Grows its arrays when the
 * number of contacts does (outside the hot loop after the first steps). */
base_status world_contacts(world *w, double h, double margin, contact_set *out, base_error *err);

/* The same with u_curve, for formulations at acceleration level: at contacts central differences of u over two
 * displaced configurations, so three detections instead of one; at joints in closed form. A contact that is not found at
 * both displacements has u_curve from the one side that has it, zero if neither. */
base_status world_contacts_curved(world *w, double h, double margin, contact_set *out,
                                  base_error *err);

/* The same with u_curve in u_drift, of contacts that are closed and of joints: velocities at the end of the step obey them as they have
 * turned by then, and a step from velocities that do has the forces which hold bodies on their curved ways. Along a slip friction keeps
 * the direction of the start. */
base_status world_contacts_turned(world *w, double h, double margin, contact_set *out,
                                  base_error *err);
/* Does a contact frame turn in a step of h [s]? */
bool world_turns(const world *w, double h);

/* v <- v_next, q <- q + h N v_next, t <- t + h. `impulse` (n_row of the last set) is kept for
 * world_contact_force; NULL: none. */
base_status world_advance(world *w, const double *v_next, const double *impulse, base_error *err);

/* q <- q + h N shift of bodies after world_advance (formulation_answer.shift); velocities stay. */
void world_shift(world *w, const double *shift);

/* Makes s, a copy of the scene that w was opened with, begin where w is now: places and velocities of the bodies, what moves
 * with them (joints) and with the time (anchors, phases, prescribed velocities). It keeps no check but that all is finite: the others
 * tell of a motion from the old beginning. Impulses and bristles are no part of a scene. */
void world_restart(const world *w, scene_spec *s);

/* BASE_EUNSUPPORTED: such a scene has none, for the line says what (generalised coordinates, compliant contact, a force that grows
 * with the time). */
base_status world_can_restart(const scene_spec *s, base_error *err);

double world_time(const world *w);
unsigned world_effects(const world *w);
unsigned world_occurring(const world *w);   /* those of them that occur in the scene's data */
bool world_has_coordinates(const world *w); /* generalised coordinates instead of bodies */
int world_n_dof(const world *w);

/* Configuration access for formulations that integrate themselves (penalty, event): the free
 * dofs' configuration as one vector; N v by finite step. Sizes from world_n_config. */
int world_n_config(const world *w);
void world_get_state(const world *w, double *config, double *v);
void world_set_state(world *w, double t, const double *config, const double *v);
void world_config_rate(const world *w, const double *config, const double *v, double *rate);
/* a = W f: acceleration of the free dofs at the current state without contacts and joints. */
base_status world_acceleration(world *w, double *a, base_error *err);

/* Everything of a world that its next step depends on, its clock included, as world_saved_size numbers: a step from a
 * loaded state has the bits of the step from the state that was saved. Of a world of the same spec; where the effects
 * differ world_set_effects follows, after which an axis that stands still without one of them is at rest. */
size_t world_saved_size(const world *w);
void world_save(const world *w, double *state);
void world_load(world *w, const double *state);
/* How far two saved states of a world are apart: the largest way between two places of one point of a body [m], and the
 * largest difference of its velocities [m/s]. Generalised coordinates count as metres. */
void world_saved_distance(const world *w, const double *a, const double *b, double *position,
                          double *velocity);
/* Richardson's extrapolation of two saved states of the same time, one of them reached by half the steps: 2 fine - coarse in
 * places, turns and velocities. What is first order in the step cancels. */
void world_extrapolate(world *w, const double *coarse, const double *fine);
/* What one step of h from `start` and two of h/2 differ by beyond what a constant acceleration explains, h (v_fine -
 * v_start) / 4: the largest over the points of all bodies [m]; of third order where the motion is smooth. */
double world_saved_bend(const world *w, double h, const double *start, const double *coarse,
                        const double *fine);
/* A step of h [s] from `start` and two of h/2, as they were saved. */
typedef struct saved_step {
  double h;
  const double *start, *coarse, *fine;
} saved_step;
/* The most that a velocity differs in a body between the ends of `next`, where that is more than `slight` of what it does between those of `own`
 * [m/s]. `coarse` is not read. */
double world_saved_swerve(const world *w, const saved_step *own, const saved_step *next,
                          double slight);
/* As world_saved_bend and the distance of the velocities over h, from two steps in a row between which nothing begins or ends: what the
 * later one's extrapolation may be off by [m], of third order also where velocities lag: what a joint or a contact holds is held with the
 * directions at the start of a step, so that v_fine - v_coarse = h r is of first order, but what is left of it has only the change of r.
 * What the accelerations v_coarse - v_start = h a change by, j = (a - a_before) over the shorter step, is that of free motion; an acceleration
 * that changes at once is in the step that it is seen in. */
double world_saved_unsteady(const world *w, const saved_step *before, const saved_step *now);

/* What a step makes of one body that is not where it should be, or not as fast. Velocities by turning, and angles, are those of a point at
 * the radius that contains it. By what was left out, at most, the velocity of its centre is `moved` and its turning `spun`; by friction that
 * was simulated the centre has `acted`, by rolling and torsion the turning `held` (world_acted) [m/s]. A deviation of places adds `place` times
 * itself to that of the velocity, and `arm` times to that of the turning where it turns [1/s]; in space that of the turning adds `speed`
 * times itself [1], and that of the angle `whirl` times itself [1/s], to that of the turning. */
typedef struct world_growth {
  double moved, spun, acted, held;
  double place, arm, speed, whirl;
  int group; /* first of the bodies that push each other in one piece with it; itself: none does */
  int floor; /* a contact that carries it, where all that do are of one plane; below 0: not so */
  bool turned; /* it turns, but about the normal of its floor, or may by the deviation */
  bool pushed; /* something acts on it that may turn it */
} world_growth;

/* How far the velocity [m/s] and the place [m] of any point of a body may be off. */
typedef struct world_deviation {
  double speed, place;
} world_deviation;

/* What the effects that the world leaves out of `effects` would do in the step from its last set to v_next with these
 * impulses (n_row), before world_advance: for each the largest change of velocity of any point of a body that it could bring [m/s], an
 * upper bound; up to `least` it is none. 0: the step is one of the whole scene too. Friction, rolling, torsion and restitution at contacts
 * with a normal impulse; rotation and spatial as axes that are locked without them, and by what friction that slides changes by load that
 * bodies may take off each other (at the press of the step; contacts that are about to slide do not count). Not seen: damping and gyroscopic
 * without rotation.
 * grown[n_body]: the same by bodies, and what the step makes of deviations before it (`deviates`: some may, or would); nothing where
 * nothing changes and none deviates, which is not asked then. */
void world_omitted(const world *w, unsigned effects, bool deviates, double least,
                   const double *v_next, const double *impulse, double change[EFFECT_COUNT],
                   world_growth *grown);
/* Of that step, `acted` and `held` of grown [n_body]. */
void world_acted(const world *w, const double *impulse, world_growth *grown);
/* Do the contacts of that step act alike on bodies that are off by `off` [n_body] before it, and in it by `grown` more? True where no
 * friction is simulated and each contact, whatever the deviation is, rests (pressed by loads, or idle), passes, or is closed now, and was
 * a step before or was not: an impact is a projection then (mirrored, where it bounces), by which no deviation grows in the norm of
 * kinetic energy but for what goes with places. */
bool world_contacts_alike(const world *w, const double *v_next, const double *impulse,
                          const world_deviation *off, const world_growth *grown);
/* May two sides that this step leaves apart meet in it by what they are off? */
bool world_may_meet(const world *w, const double *v_next, const double *impulse,
                    const world_deviation *off, const world_growth *grown);
/* As world_omitted, guessed before the step of the last set is solved, of `effects` that the world has or not: friction of bodies that touch in one
 * direction only and slide, the third dimension where a contact pushes out of the plane. 0: nothing is known before. Of `grown` what is said of
 * deviations is kept. */
void world_foreseen(const world *w, unsigned effects, double change[EFFECT_COUNT],
                    world_growth *grown);
/* Those of `effects` (rotation, spatial) that a velocity or a prescribed motion of the scene needs. */
unsigned world_moved_by(const scene_spec *spec, unsigned effects);
/* Does turning in the plane turn some body out of it, by a product of its inertia? */
bool world_turns_out_of_plane(const world *w);
/* The most that the law of friction gives over mu times the normal force, for what it would do (world_omitted); 1 at first [1]. */
void world_set_friction_reach(world *w, double reach);
/* Those that some body now moves along by more than `least` [m/s]. */
unsigned world_moves(const world *w, unsigned effects, double least);

/* "body.x", "body.pos", "body.vel", "body.omega.z", "body.angle", ...: false if there is no such
 * quantity. dir (or NULL) picks a component of a vector; without dir a vector gives its norm. */
bool world_observe(const world *w, const char *var, const double *dir, double *value);
const char *world_observe_unit(const char *var);

double world_energy(const world *w);  /* kinetic + gravity + springs [J] */
double world_kinetic(const world *w); /* [J] */
void world_momentum(const world *w, double p[3]);
void world_angular_momentum(const world *w, double L[3]); /* about the origin */
double world_min_gap(world *w); /* exact, all pairs; HUGE_VAL if none, NaN without memory [m] */
/* How deep two sides are in each other at most [m]; 0: none are. BASE_ENOMEM. */
base_status world_depth(world *w, double *depth, base_error *err);
/* Did two bodies carry each other in the last step whose sides end? Those of planes and of round bodies do not. */
bool world_sides_touch(const world *w);
/* The world has come here from the saved state `start` in h [s], bodies evenly accelerated. *at: when two sides that do not carry at the end come
 * as near as `near` [m], and are further apart again at the end, or deeper in each other than a tenth of the smallest body [s]; h: none do.
 * *speed: the largest at which two sides that do not carry come into each other and begin to go apart again before the end, as if there were
 * no contact [m/s]; 0: none do. BASE_ENOMEM. */
base_status world_first_touch(world *w, double h, const double *start, double near, double *at,
                              double *speed, base_error *err);
/* The largest speed at which two sides no farther apart than `near` [m] come nearer to each other now [m/s]. BASE_ENOMEM. */
base_status world_nearing(world *w, double near, double *speed, base_error *err);
double world_max_speed(const world *w); /* max |v| over bodies' centres [m/s] */
/* Bound of the speed of every point of every body whose n_dof velocities are v [m/s]. */
double world_speed_at(const world *w, const double *v);
/* Does nothing move or turn, and no load or drive change with time? */
bool world_may_rest(const world *w);
/* Bound of the speed of every point of every body that could meet another side in the last step [m/s]. */
double world_meeting_speed(const world *w);
double
world_surface_speed(const world *w); /* bound of the speed of every point of every body [m/s] */
/* Largest ratio, over the pairs that may collide, of the speed at which two sides come nearer at most to the
 * distance between their bounding balls, or `margin` [m] where that is more [1/s]. A pair that slides along a
 * half-space comes no nearer. */
double world_closing_rate(const world *w, double margin);
/* Springs and dampers, which are explicit, refuse steps of this length and longer; HUGE_VAL: there are none [s]. */
double world_longest_step(const world *w);
/* The fastest at which what is off a steady turning grows now, as about a middle axis [1/s]; 0: none does. */
double world_growth_rate(const world *w);
/* That gravity and all loads together give the lightest body at most, however joints pass them on [m/s^2]. */
double world_most_acceleration(const world *w);
/* Of the loads that swing; HUGE_VAL: none does [s]. */
double world_shortest_period(const world *w);
double world_size(const world *w); /* of the smallest body: the scale of tolerances [m] */
/* Has no body a size? world_size is how far they may come by speed or gravity then. */
bool world_of_points(const world *w);
/* Of body i: its mass [kg], the radius that contains it [m], and its least radius of gyration over that [1]; 0 where it cannot turn with
 * `effects`. Prescribed: mass 0. */
typedef struct world_inertia {
  double mass, bound, gyration;
} world_inertia;
world_inertia world_inertia_of(const world *w, unsigned effects, int i);
bool world_finite(const world *w);

/* All of them below the limit in size. */
bool world_below(const world *w, double limit);

/* Names of the two sides of contact id (for pairs in checks); static storage of the world. */
void world_contact_pair(const world *w, uint64_t id, const char **a, const char **b);

/* Body poses for trajectories and pictures. */
int world_n_body(const world *w);
void world_body_pose(const world *w, int i, double pos[3], double quat[4]);
void world_body_velocity(const world *w, int i, double vel[3], double omega[3]);
const char *world_body_name(const world *w, int i);

/* World point of a contact of the last set, and the mean force on its side 0 over the step after
 * world_advance [N]: for arrows. */
void world_contact_point(const world *w, int contact, double point[3]);
/* Impulses over the rows of the last contact set (NULL: none) for world_contact_force, as world_advance takes them: from
 * what advances the world itself. */
void world_note_impulses(world *w, const double *impulse);
void world_contact_force(const world *w, int contact, double force[3]);
