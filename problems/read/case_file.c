#include "problems/read/case_file.h"

#include "problems/read/node.h"
#include "problems/read/read_lcp.h"
#include "problems/read/read_list.h"
#include "problems/read/read_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BAD(n, ...) BASE_FAIL((n)->err, BASE_EINVAL, __VA_ARGS__)

void case_file_free(case_file *f) {
  for (int i = 0; i < f->n_lcp; i++) {
    lcp_case_free(&f->lcp[i]);
  }
  free(f->lcp);
  free(f->equivalence);
  free(f->painleve);
  scene_file_free(&f->scenes);
  memset(f, 0, sizeof *f);
}

/* ---- equivalences --------------------------------------------------------------------------- */

static base_status read_override(const node *n, case_equivalence *e) {
  json_t *v = json_object_get(n->v, "override_b");
  node o;
  if (v == NULL) {
    return BASE_OK;
  }
  BASE_TRY(node_open(&o, v, n->err, "%s: override_b", n->where));
  const char *key;
  json_t *value;
  json_object_foreach(v, key, value) {
    unsigned bit = 0;
    for (int i = 0; i < EFFECT_COUNT; i++) {
      char word[48];
      (void)snprintf(word, sizeof word, "%s_off", effect_name(i));
      bit |= (strcmp(word, key) == 0) ? 1u << i : 0u;
    }
    const bool number = strcmp(key, "nd") == 0 || strcmp(key, "multiplicity") == 0;
    if (bit == 0 && !number) {
      return BAD(n, "%s: unknown key '%.40s'", o.where, key);
    }
    if (bit != 0 && !json_is_true(value)) {
      return BAD(n, "%s: %s: need true", o.where, key);
    }
    e->off_b |= bit;
  }
  BASE_TRY(node_int(&o, "nd", &e->facets_b));
  return node_int(&o, "multiplicity", &e->multiplicity_b);
}

static base_status read_equivalence(json_t *v, int index, case_equivalence *e, base_error *err) {
  node n;
  json_t *map;
  BASE_TRY(node_open(&n, v, err, "equivalence %d", index + 1));
  BASE_TRY(node_keys(&n, "id|a|b|t|map|tol|why|override_b"));
  BASE_TRY(node_text(&n, "id", e->id, sizeof e->id));
  BASE_TRY(node_need(&n, "a"));
  BASE_TRY(node_need(&n, "b"));
  BASE_TRY(node_text(&n, "a", e->a, sizeof e->a));
  BASE_TRY(node_text(&n, "b", e->b, sizeof e->b));
  BASE_TRY(node_text(&n, "why", e->why, sizeof e->why));
  BASE_TRY(node_real(&n, "t", &e->t));
  BASE_TRY(node_real(&n, "tol", &e->tol));
  BASE_TRY(node_list(&n, "map", SPEC_OBSERVE, &map, &e->n_var));
  for (int i = 0; i < e->n_var; i++) {
    const json_t *pair = json_array_get(map, (size_t)i);
    BASE_TRY(node_string(&n, json_array_get(pair, 0), "map", e->var_a[i], sizeof e->var_a[i]));
    BASE_TRY(node_string(&n, json_array_get(pair, 1), "map", e->var_b[i], sizeof e->var_b[i]));
  }
  return read_override(&n, e);
}

/* `equal_to` of a scene: the same scene with another contact multiplicity. */
static base_status read_equal_to(json_t *owner, json_t *v, case_equivalence *e, base_error *err) {
  node n, o;
  json_t *vars;
  BASE_TRY(node_open(&n, owner, err, "scene"));
  BASE_TRY(node_text(&n, "id", e->id, sizeof e->id));
  (void)snprintf(e->a, sizeof e->a, "%s", e->id);
  (void)snprintf(e->b, sizeof e->b, "%s", e->id);
  BASE_TRY(node_real(&n, "T", &e->t));
  BASE_TRY(node_open(&o, v, err, "scene '%s': equal_to", e->id));
  BASE_TRY(node_keys(&o, "multiplicity|vars|tol"));
  BASE_TRY(node_int(&o, "multiplicity", &e->multiplicity_b));
  BASE_TRY(node_real(&o, "tol", &e->tol));
  BASE_TRY(node_list(&o, "vars", SPEC_OBSERVE, &vars, &e->n_var));
  for (int i = 0; i < e->n_var; i++) {
    BASE_TRY(
        node_string(&o, json_array_get(vars, (size_t)i), "vars", e->var_a[i], sizeof e->var_a[i]));
    memcpy(e->var_b[i], e->var_a[i], sizeof e->var_b[i]);
  }
  return BASE_OK;
}

static base_status read_equivalences(json_t *root, case_file *f, base_error *err) {
  json_t *list = json_object_get(root, "equivalences"), *stress = json_object_get(root, "stress"),
         *v;
  size_t i;
  const size_t room = json_array_size(list) + json_array_size(stress);
  f->equivalence = calloc(room + 1, sizeof *f->equivalence);
  if (f->equivalence == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu equivalences", room);
  }
  json_array_foreach(list, i, v) {
    BASE_TRY(read_equivalence(v, (int)i, &f->equivalence[f->n_equivalence], err));
    f->n_equivalence++;
  }
  json_array_foreach(stress, i, v) {
    json_t *equal = json_object_get(v, "equal_to");
    if (equal != NULL) {
      BASE_TRY(read_equal_to(v, equal, &f->equivalence[f->n_equivalence], err));
      f->n_equivalence++;
    }
  }
  return BASE_OK;
}

/* ---- Painleve regimes ------------------------------------------------------------------------ */

static base_status read_impulse(const node *n, case_painleve *p) {
  json_t *v = json_object_get(n->v, "stick_impulse");
  node s;
  if (json_is_object(v)) {
    BASE_TRY(node_open(&s, v, n->err, "%s: stick_impulse", n->where));
    BASE_TRY(node_keys(&s, "Pn|Pt|inside_cone"));
    p->has_impulse = true;
    BASE_TRY(node_real(&s, "Pn", &p->impulse_n));
    BASE_TRY(node_real(&s, "Pt", &p->impulse_t));
    BASE_TRY(node_bool(&s, "inside_cone", &p->impulse_in_cone));
  }
  v = json_object_get(n->v, "post_impulse");
  if (json_is_object(v)) {
    BASE_TRY(node_open(&s, v, n->err, "%s: post_impulse", n->where));
    BASE_TRY(node_keys(&s, "vG|omega"));
    p->has_after = true;
    BASE_TRY(node_vector(&s, "vG", 2, p->after));
    BASE_TRY(node_real(&s, "omega", &p->after[2]));
  }
  return BASE_OK;
}

static base_status read_regime(json_t *v, int index, case_painleve *p, base_error *err) {
  node n;
  BASE_TRY(node_open(&n, v, err, "painleve regime %d", index + 1));
  BASE_TRY(node_keys(&n, "tan_theta|theta|mu|omega|v_tip_t|p|b|mu_crit|regime|"
                         "acceleration_level_solutions|N_slip|stick_impulse|post_impulse"));
  BASE_TRY(node_real(&n, "tan_theta", &p->tan_theta));
  BASE_TRY(node_real(&n, "theta", &p->theta));
  BASE_TRY(node_real(&n, "mu", &p->mu));
  BASE_TRY(node_real(&n, "omega", &p->omega));
  BASE_TRY(node_real(&n, "v_tip_t", &p->v_tip));
  BASE_TRY(node_real(&n, "p", &p->p));
  BASE_TRY(node_real(&n, "b", &p->b));
  BASE_TRY(node_real(&n, "mu_crit", &p->mu_crit));
  BASE_TRY(node_text(&n, "regime", p->regime, sizeof p->regime));
  BASE_TRY(node_text(&n, "acceleration_level_solutions", p->solutions, sizeof p->solutions));
  p->has_n_slip = json_is_number(json_object_get(v, "N_slip"));
  if (p->has_n_slip) {
    BASE_TRY(node_real(&n, "N_slip", &p->n_slip));
  }
  return read_impulse(&n, p);
}

static base_status read_regimes(json_t *root, case_file *f, base_error *err) {
  json_t *list = json_object_get(root, "painleve_regimes"), *v;
  size_t i;
  f->painleve = calloc(json_array_size(list) + 1, sizeof *f->painleve);
  if (f->painleve == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for regimes");
  }
  json_array_foreach(list, i, v) {
    BASE_TRY(read_regime(v, (int)i, &f->painleve[i], err));
    f->n_painleve++;
  }
  return BASE_OK;
}

/* ---- the file ------------------------------------------------------------------------------- */

static base_status read_lcps(json_t *root, case_file *f, base_error *err) {
  json_t *list = json_object_get(root, "lcp"), *v;
  size_t i;
  f->lcp = calloc(json_array_size(list) + 1, sizeof *f->lcp);
  if (f->lcp == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu problems", json_array_size(list));
  }
  json_array_foreach(list, i, v) {
    f->n_lcp = (int)i + 1; /* a half-read one is freed as well */
    BASE_TRY(read_lcp_case(v, &f->lcp[i], err));
  }
  return BASE_OK;
}

static base_status read_root(json_t *root, case_file *f, base_error *err) {
  if (json_is_object(root) && json_object_get(root, "id") == NULL) {
    node n;
    BASE_TRY(node_open(&n, root, err, "case file"));
    BASE_TRY(node_keys(&n, "format|conventions|lcp|painleve_regimes|scenes|equivalences|stress"));
  }
  BASE_TRY(scene_list_read(root, &f->scenes, err));
  if (!json_is_object(root)) {
    return BASE_OK;
  }
  BASE_TRY(read_lcps(root, f, err));
  BASE_TRY(read_equivalences(root, f, err));
  return read_regimes(root, f, err);
}

base_status case_file_read(const char *path, case_file *out, base_error *err) {
  json_t *root;
  base_error inner = {0};
  memset(out, 0, sizeof *out);
  BASE_TRY(node_read_file(path, &root, err));
  base_status status = read_root(root, out, &inner);
  json_decref(root);
  if (status == BASE_OK && out->n_lcp + out->scenes.n_scene + out->scenes.n_failed == 0) {
    status = BASE_FAIL(&inner, BASE_EINVAL, "neither a problem nor a scene in it");
  }
  if (status != BASE_OK) {
    case_file_free(out);
    return BASE_FAIL(err, status, "%s: %s", path, inner.text);
  }
  return BASE_OK;
}
