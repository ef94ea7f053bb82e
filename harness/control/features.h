/* harness/control/features.h - what is known of a scene before it runs, as numbers that scenes are compared by. */
#pragma once

#include "problems/spec/spec.h"

enum { FEATURES = 12 };

typedef struct features {
  double x[FEATURES]; /* each of the size of 1; see features_name */
} features;

/* "bodies" log2(1 + bodies that move) / 4, "contacts" log2(1 + contacts in reach at the start) / 4, "per_body" log2(1 + contacts
 * a body) / 2, "redundant" contacts and joint rows over degrees of freedom, at most 2; shares of the contacts: "sliding",
 * "closing"; 0 or 1: "spatial", "friction", "restitution", "resisting" (rolling or torsion), "joints", "moving" (a
 * body has a velocity at the start). */
const char *features_name(int i);
double features_of_name(const features *f, const char *name); /* 0: there is none of this name */

/* Contacts are looked for as a step of h does. */
base_status features_of(const scene_spec *spec, unsigned effects, double h, features *out,
                        base_error *err);

/* Euclid's. */
double features_distance(const features *a, const features *b);
