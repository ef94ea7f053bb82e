#include "problems/scene.h"

#include "scene_list.h"

#include <string.h>

#define DECLARE_(name) extern const scene scene_##name;
SCENE_LIST(DECLARE_)
#define ADDRESS_(name) &scene_##name,
static const scene *const all[] = {SCENE_LIST(ADDRESS_) NULL};

const scene *const *scenes(int *count) {
  *count = BASE_COUNT(all) - 1;
  return all;
}

const scene *scene_find(const char *name) {
  for (int i = 0; all[i] != NULL; i++) {
    if (strcmp(all[i]->name, name) == 0) {
      return all[i];
    }
  }
  return NULL;
}
