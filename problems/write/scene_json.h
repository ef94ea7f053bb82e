/* problems/write/scene_json.h - JSON text of a tree: numbers in the fewest digits that read back to the
 * same double, lists of numbers and words on one line. The tree is only read. */
#pragma once

#include <jansson.h>
#include <stdio.h>

void scene_json_print(FILE *to, json_t *v);
