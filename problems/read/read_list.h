/* problems/read/read_list.h - the scenes of a file that is already in memory. */
#pragma once

#include "problems/read/scene_file.h"

#include <jansson.h>

/* Every scene of the groups "scenes" and "stress", of a list, or the one scene; none is fine. */
base_status scene_list_read(json_t *root, scene_file *out, base_error *err);
