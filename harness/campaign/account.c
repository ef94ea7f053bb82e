#include "harness/campaign/account.h"

#include "harness/util/json_out.h"

#include <stdlib.h>
#include <string.h>

/* What of each cell is there: [n_cell] units done, and units in all. */
typedef struct tally {
  int done, all;
} tally;

static bool measured(const tally *t) {
  return t->done == t->all;
}

static tally *count_units(const plan *p, const bool *done) {
  tally *of = calloc((size_t)p->n_cell + 1, sizeof *of);
  for (int u = 0; of != NULL && u < p->n_unit; u++) {
    of[p->unit[u].cell].all++;
    of[p->unit[u].cell].done += done[u] ? 1 : 0;
  }
  return of;
}

/* A text as a key: the name of a file may not be UTF-8. */
static const char *key_of(const char *text, char *buf, size_t cap) {
  json_t *as_text = json_string(text);
  const char *key = (as_text != NULL) ? text : base_printable(text, buf, cap);
  json_decref(as_text);
  return key;
}

/* {key: [measured, cells]}, one more cell of it. */
static void add_to(json_t *o, const char *text, bool good) {
  char shown[2048];
  const char *key = key_of(text, shown, sizeof shown);
  json_t *pair = json_object_get(o, key);
  if (pair == NULL) {
    pair = json_pack("[i,i]", 0, 0);
    (void)json_object_set_new(o, key, pair);
  }
  for (int i = 0; i < 2; i++) {
    json_t *n = json_array_get(pair, (size_t)i);
    (void)json_integer_set(n, json_integer_value(n) + (i == 1 || good ? 1 : 0));
  }
}

/* The object under a key, made where there is none. */
static json_t *below(json_t *o, const char *key) {
  json_t *found = json_object_get(o, key);
  if (found == NULL) {
    found = json_object();
    (void)json_object_set_new(o, key, found);
  }
  return found;
}

/* {part: {axis: {value: [measured, cells]}}} */
static void add_values(json_t *values, const cell *c, bool good) {
  const char *value[AXIS_COUNT];
  json_t *part = below(values, c->part);
  cell_values(c, value);
  for (int a = 0; a < AXIS_COUNT; a++) {
    add_to(below(part, campaign_axis_name(a)), value[a], good);
  }
}

/* {part: {axis: [value]}} of the values of a part without a measured cell. */
static void add_absent(json_t *out, const char *part, json_t *axes) {
  const char *axis;
  const char *value;
  json_t *of;
  json_t *pair;
  json_object_foreach(axes, axis, of) {
    json_t *list = json_array();
    json_object_foreach(of, value, pair) {
      if (json_integer_value(json_array_get(pair, 0)) == 0) {
        (void)json_array_append_new(list, json_string(value));
      }
    }
    if (json_array_size(list) > 0) {
      (void)json_object_set(below(out, part), axis, list);
    }
    json_decref(list);
  }
}

/* The values without a measured cell, of parts that have one. */
static json_t *absent(json_t *values, json_t *parts) {
  json_t *out = json_object();
  const char *part;
  json_t *axes;
  json_object_foreach(values, part, axes) {
    if (json_integer_value(json_array_get(json_object_get(parts, part), 0)) > 0) {
      add_absent(out, part, axes);
    }
  }
  return out;
}

static json_t *write_account(const plan *p, const cover *order, const tally *of) {
  json_t *cut = json_object();
  json_t *parts = json_object();
  json_t *stages = json_object();
  json_t *values = json_object();
  int cells = 0;
  int whole = 0;
  int begun = 0;
  for (int i = 0; i < p->n_cell; i++) {
    if (of[i].all > 0) {
      const bool good = measured(&of[i]);
      cells++;
      whole += good ? 1 : 0;
      begun += (!good && of[i].done > 0) ? 1 : 0;
      add_to(parts, p->cell[i].part, good);
      add_values(values, &p->cell[i], good);
    }
  }
  for (int k = 0; order != NULL && k < order->n; k++) {
    add_to(stages, cover_stage_name(order->stage[k]), measured(&of[order->cell[k]]));
  }
  json_out_int(cut, "cells", cells);
  json_out_int(cut, "measured", whole);
  json_out_int(cut, "begun", begun);
  if (order != NULL) {
    (void)json_object_set(cut, "stages", stages);
  }
  (void)json_object_set_new(cut, "parts", parts);
  (void)json_object_set_new(cut, "absent", absent(values, parts));
  json_decref(stages);
  json_decref(values);
  return cut;
}

json_t *account_json(const plan *p, const cover *order, const bool *done) {
  tally *of = count_units(p, done);
  bool left = false;
  for (int i = 0; of != NULL && i < p->n_cell; i++) {
    left = left || !measured(&of[i]);
  }
  json_t *cut = left ? write_account(p, order, of) : NULL;
  free(of);
  return cut;
}

/* ---- for a reader -----------------------------------------------------------------------------*/

static void print_pairs(json_t *o, const char *what, FILE *to) {
  const char *key;
  json_t *pair;
  json_object_foreach(o, key, pair) {
    const long long done = json_integer_value(json_array_get(pair, 0));
    const long long of = json_integer_value(json_array_get(pair, 1));
    if (done < of) {
      (void)fprintf(to, "  left of %s %s: %lld of %lld cells\n", what, key, of - done, of);
    }
  }
}

void account_print(json_t *cut, int n_cell, FILE *to) {
  const char *part;
  const char *axis;
  json_t *axes;
  json_t *list;
  (void)fprintf(to, "  cut: %d of %lld cells have rows\n", n_cell,
                json_integer_value(json_object_get(cut, "cells")));
  print_pairs(json_object_get(cut, "stages"), "stage", to);
  print_pairs(json_object_get(cut, "parts"), "part", to);
  json_object_foreach(json_object_get(cut, "absent"), part, axes) {
    json_object_foreach(axes, axis, list) {
      size_t i;
      json_t *value;
      (void)fprintf(to, "  without a cell, %s, %s:", part, axis);
      json_array_foreach(list, i, value) {
        (void)fprintf(to, " %s", json_string_value(value));
      }
      (void)fputc('\n', to);
    }
  }
}
