/* Scene files and the scenes of case files. */
#include "problems/read/scene_file.h"

#include "lcp/base/nearest.h"
#include "problems/read/read_list.h"
#include "problems/read/read_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static base_status read_checked(json_t *v, scene_spec *s, base_error *err) {
  base_status status = read_scene(v, s, err);
  if (status == BASE_OK) {
    status = spec_check_all(s, err);
  }
  return status;
}

static void note_failure(scene_file *out, const scene_spec *s, int index, const base_error *err) {
  struct scene_file_failure *f = &out->failed[out->n_failed++];
  (void)snprintf(f->id, sizeof f->id, "%s", s->id);
  if (s->id[0] == '\0') {
    (void)snprintf(f->id, sizeof f->id, "#%d", index + 1);
  }
  f->err = *err;
}

/* Each name has one scene; the ids of the file so far are keys of `seen`. */
static base_status check_id(json_t *seen, const char *id, base_error *err) {
  if (json_object_get(seen, id) != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "scene '%s': the id is used twice", id);
  }
  return (json_object_set_new(seen, id, json_true()) == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "scene '%s': no memory for its id", id);
}

/* Appends the scenes of a list; room for all of them is there. */
static void read_list(json_t *list, json_t *seen, scene_file *out) {
  size_t index;
  json_t *v;
  json_array_foreach(list, index, v) {
    base_error err = {0};
    scene_spec *s = &out->scene[out->n_scene];
    if (read_checked(v, s, &err) == BASE_OK && check_id(seen, s->id, &err) == BASE_OK) {
      out->n_scene++;
    } else {
      note_failure(out, s, (int)index, &err);
      spec_free(s);
    }
  }
}

/* The lists of scenes in a file: its groups, or the file itself; none in one scene, which has an id. */
static int find_lists(json_t *root, json_t *list[2]) {
  int n = 0;
  if (json_object_get(root, "id") != NULL) {
    return 0;
  }
  if (json_is_array(root)) {
    list[n++] = root;
    return n;
  }
  static const char *const groups[] = {"scenes", "stress"};
  for (int i = 0; i < BASE_COUNT(groups); i++) {
    json_t *v = json_object_get(root, groups[i]);
    if (json_is_array(v)) {
      list[n++] = v;
    }
  }
  return n;
}

base_status scene_list_read(json_t *root, scene_file *out, base_error *err) {
  json_t *list[2], *single = NULL, *seen = json_object();
  memset(out, 0, sizeof *out);
  int n = find_lists(root, list);
  if (n == 0 && json_object_get(root, "id") != NULL) {
    single = json_array();
    if (single == NULL || json_array_append(single, root) != 0) {
      json_decref(seen);
      json_decref(single);
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for a scene");
    }
    list[n++] = single;
  }
  size_t count = 0;
  for (int i = 0; i < n; i++) {
    count += json_array_size(list[i]);
  }
  out->scene = calloc(count + 1, sizeof *out->scene);
  out->failed = calloc(count + 1, sizeof *out->failed);
  if (out->scene == NULL || out->failed == NULL) {
    json_decref(seen);
    json_decref(single);
    scene_file_free(out);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu scenes", count);
  }
  for (int i = 0; i < n; i++) {
    read_list(list[i], seen, out);
  }
  json_decref(seen);
  json_decref(single);
  return BASE_OK;
}

base_status scene_file_read(const char *path, scene_file *out, base_error *err) {
  json_t *root;
  memset(out, 0, sizeof *out);
  BASE_TRY(node_read_file(path, &root, err));
  base_status status = scene_list_read(root, out, err);
  json_decref(root);
  if (status == BASE_OK && out->n_scene + out->n_failed == 0) {
    scene_file_free(out);
    status = BASE_FAIL(err, BASE_EINVAL,
                       "%s: no scene in it: need one scene (with an id), a list "
                       "of scenes, or groups 'scenes' or 'stress'",
                       path);
  }
  return status;
}

void scene_file_free(scene_file *f) {
  for (int i = 0; i < f->n_scene; i++) {
    spec_free(&f->scene[i]);
  }
  free(f->scene);
  free(f->failed);
  memset(f, 0, sizeof *f);
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
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(id != NULL ? id : "", BASE_NEAREST_WORD);
  for (int i = 0; i < f->n_scene; i++) {
    base_nearest_offer(&near, f->scene[i].id);
    if (id == NULL || strcmp(f->scene[i].id, id) == 0) {
      *out = f->scene[i];
      f->scene[i] = f->scene[--f->n_scene];
      return BASE_OK;
    }
  }
  return BASE_FAIL(err, BASE_EINVAL, "%s: no scene '%s' in it%s", path, id,
                   base_nearest_hint(&near, hint));
}

static base_status load_file(const char *path, const char *id, scene_spec *out, base_error *err) {
  scene_file f;
  BASE_TRY(scene_file_read(path, &f, err));
  const base_status status = pick_scene(&f, path, id, out, err);
  scene_file_free(&f);
  return status;
}

bool scene_is_file(const char *text) {
  const bool standard = text[0] == '-' && (text[1] == '\0' || text[1] == '#');
  return standard || strchr(text, '/') != NULL || strstr(text, ".json") != NULL ||
         strstr(text, ".yaml") != NULL || strstr(text, ".yml") != NULL;
}

void scene_file_split(const char *text, char *path, size_t cap, const char **id) {
  const char *hash = (access(text, F_OK) != 0) ? strrchr(text, '#') : NULL;
  *id = (hash != NULL) ? hash + 1 : NULL;
  (void)snprintf(path, cap, "%.*s", (int)(hash != NULL ? (size_t)(hash - text) : strlen(text)),
                 text);
}

base_status scene_load(const char *text, scene_spec *out, base_error *err) {
  char path[1024];
  const char *id;
  if (strlen(text) >= sizeof path || !scene_is_file(text)) {
    return scene_build(text, out, err);
  }
  scene_file_split(text, path, sizeof path, &id);
  return load_file(path, id, out, err);
}
