/* problems/spec/name_index.h - the bodies and half-spaces of a scene by name. Sides are numbered: the bodies, then the
 * half-spaces. */
#pragma once

#include "problems/spec/spec.h"

typedef struct named_side {
  const char
      *name; /* of the scene: the index lives no longer than its arrays stay where they are */
  int side;
} named_side;

typedef struct name_index {
  int n;
  named_side *entry; /* by name, then by side; owned */
} name_index;

base_status name_index_open(name_index *k, const scene_spec *s, base_error *err);
void name_index_close(name_index *k);
/* The first side of that name, -1 if there is none. */
int name_index_find(const name_index *k, const char *name);
