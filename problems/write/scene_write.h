/* problems/write/scene_write.h - a scene as a scene file (FORMATS 1 to 5): what is built in can be
 * read, changed, and given to other programs. */
#pragma once

#include "problems/spec/spec.h"

#include <stdio.h>

/* Writes s, checked, as one JSON object; scene_load reads it back to the same numbers. Everything
 * that the reader would fill in is written out, as inertias. BASE_EUNSUPPORTED: a mechanism in
 * generalised coordinates, compliant contact, or two answers for one effect switched off, which scene
 * files do not hold; BASE_ENOMEM; BASE_EIO: it could not be written. */
base_status scene_write(FILE *to, const scene_spec *s, base_error *err);
