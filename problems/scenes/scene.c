#include "problems/scenes/scene.h"

#include "lcp/base/nearest.h"
#include "scene_list.h"

#include <stdio.h>
#include <stdlib.h>
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

#define NAME_(id, name, words)  name,
#define WORDS_(id, name, words) words,

const char *scene_situation_name(scene_situation s) {
  static const char *const names[] = {"", SCENE_SITUATIONS(NAME_)};
  return names[s];
}

const char *scene_situation_words(scene_situation s) {
  static const char *const plain[] = {"", SCENE_SITUATIONS(WORDS_)};
  return plain[s];
}

base_status scene_unknown(const char *name, base_error *err) {
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(name, strlen(name));
  for (int i = 0; all[i] != NULL; i++) {
    base_nearest_offer(&near, all[i]->name);
  }
  return BASE_FAIL(err, BASE_EINVAL,
                   "unknown scene '%.100s': need one of `lcpbench list scenes` or a .json or .yaml "
                   "file%s",
                   name, base_nearest_hint(&near, hint));
}

static base_status build_named(const scene *sc, const char *parameters, scene_spec *out,
                               base_error *err) {
  void *param = calloc(1, sc->param_size + 1);
  if (param == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "scene '%s': no memory for parameters", sc->name);
  }
  base_error inner = {0};
  base_fields_default(sc->fields, sc->n_fields, param);
  base_status status = base_fields_parse(sc->fields, sc->n_fields, param, parameters, &inner);
  if (status == BASE_OK) {
    spec_init(out);
    (void)snprintf(out->id, sizeof out->id, "%s", sc->name);
    (void)snprintf(out->title, sizeof out->title, "%s", sc->title);
    status = sc->build(param, out, &inner);
    if (status == BASE_OK) {
      status = spec_check_all(out, &inner);
    }
    if (status != BASE_OK) {
      spec_free(out);
    }
  }
  free(param);
  return (status == BASE_OK) ? BASE_OK
                             : BASE_FAIL(err, status, "scene %s: %s", sc->name, inner.text);
}

base_status scene_build(const char *text, scene_spec *out, base_error *err) {
  char head[1024];
  if (strlen(text) >= sizeof head) {
    return BASE_FAIL(err, BASE_EINVAL, "scene '%.40s...': name or path too long", text);
  }
  memcpy(head, text, strlen(text) + 1);
  char *colon = strchr(head, ':');
  if (colon != NULL) {
    *colon = '\0';
  }
  const scene *sc = scene_find(head);
  if (sc == NULL) {
    return scene_unknown(head, err);
  }
  return build_named(sc, colon != NULL ? colon + 1 : NULL, out, err);
}
