#include "problems/scenes/scene.h"

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

/* Moves scene `id` (or the only one, id NULL) of a file that was read into *out. */
static base_status pick_scene(scene_file *f, const char *path, const char *id, scene_spec *out,
                              base_error *err) {
  for (int i = 0; i < f->n_failed; i++) {
    if (id == NULL || strcmp(f->failed[i].id, id) == 0) {
      return BASE_FAIL(err, f->failed[i].err.code, "%s: %s", path, f->failed[i].err.text);
    }
  }
  if (id == NULL && f->n_scene > 1) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: holds %d scenes; pick one with '%s#ID'", path,
                     f->n_scene, path);
  }
  for (int i = 0; i < f->n_scene; i++) {
    if (id == NULL || strcmp(f->scene[i].id, id) == 0) {
      *out = f->scene[i];
      f->scene[i] = f->scene[--f->n_scene];
      return BASE_OK;
    }
  }
  return BASE_FAIL(err, BASE_EINVAL, "%s: no scene '%s' in it", path, id);
}

static base_status load_file(const char *path, const char *id, scene_spec *out, base_error *err) {
  scene_file f;
  BASE_TRY(scene_file_read(path, &f, err));
  const base_status status = pick_scene(&f, path, id, out, err);
  scene_file_free(&f);
  return status;
}

/* Texts with a slash or an ending of a scene file are paths. */
static bool is_path(const char *text) {
  return strchr(text, '/') != NULL || strstr(text, ".json") != NULL ||
         strstr(text, ".yaml") != NULL || strstr(text, ".yml") != NULL;
}

base_status scene_load(const char *text, scene_spec *out, base_error *err) {
  char head[1024];
  if (strlen(text) >= sizeof head) {
    return BASE_FAIL(err, BASE_EINVAL, "scene '%.40s...': name or path too long", text);
  }
  memcpy(head, text, strlen(text) + 1);
  if (is_path(text)) {
    char *hash = strrchr(head, '#');
    if (hash != NULL) {
      *hash = '\0';
    }
    return load_file(head, hash != NULL ? hash + 1 : NULL, out, err);
  }
  char *colon = strchr(head, ':');
  if (colon != NULL) {
    *colon = '\0';
  }
  const scene *sc = scene_find(head);
  if (sc == NULL) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "unknown scene '%s': need one of `lcpbench list scenes` or a .json or .yaml "
                     "file",
                     head);
  }
  return build_named(sc, colon != NULL ? colon + 1 : NULL, out, err);
}
