/* joint_parts.c - joints by connected components, the contacts that each touches, and the pattern of what an
 * elimination leaves: contacts that touch the same component are coupled, too. */
#include "formulations/joint/joint.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static void layout_lists(void *state, base_arena *m) {
  form_joints *j = &((form_assembly *)state)->joints;
  j->component = BASE_ARRAY(m, int, j->cap_group);
  j->part = BASE_ARRAY(m, form_component, j->cap_group);
  j->member = BASE_ARRAY(m, int, j->cap_group);
  j->mark = BASE_ARRAY(m, int, j->cap_group);
  j->touch = BASE_ARRAY(m, int, 2 * (size_t)j->cap_group);
  j->column = BASE_ARRAY(m, int, 2 * (size_t)j->cap_group);
  j->offset = BASE_ARRAY(m, int, j->cap_group);
  j->left.near_start = BASE_ARRAY(m, int, j->cap_group + 1);
  j->pivot = BASE_ARRAY(m, int, j->cap_row);
  j->unit = BASE_ARRAY(m, double, j->cap_row);
  j->before = BASE_ARRAY(m, double, j->cap_row);
  j->speed = BASE_ARRAY(m, double, j->cap_row);
  j->y = BASE_ARRAY(m, double, j->cap_row);
  j->work = BASE_ARRAY(m, double, 2 * (size_t)j->cap_row);
}

static void layout_dense(void *state, base_arena *m) {
  form_joints *j = &((form_assembly *)state)->joints;
  j->dense = BASE_ARRAY(m, double, j->cap_dense);
  j->left.near = BASE_ARRAY(m, int, j->cap_near);
  j->left.block_at = BASE_ARRAY(m, size_t, j->cap_near + 1);
}

static void layout_blocks(void *state, base_arena *m) {
  form_joints *j = &((form_assembly *)state)->joints;
  j->left.block = BASE_ARRAY(m, double, j->cap_block);
}

/* Gives every unlabelled joint that meets g the label of g. */
static int spread(form_assembly *a, int g, int listed) {
  form_joints *j = &a->joints;
  for (int k = a->near_start[g]; k < a->near_start[g + 1]; k++) {
    const int other = a->near[k];
    if (other >= a->n_contact && j->component[other] < 0) {
      j->component[other] = j->component[g];
      j->member[listed++] = other;
    }
  }
  return listed;
}

#ifndef NDEBUG
bool form_joints_partitioned(const form_assembly *a, int n) {
  const form_joints *j = &a->joints;
  const int begin = a->full.n_contact;
  int next = 0;
  bool good = true;
  for (int c = 0; c < j->n_part && good; c++) {
    good = j->part[c].first == next;
    for (int k = 0; k < j->part[c].count && good && next < n; k++) {
      const int g = j->member[next++];
      good = g >= begin && g < begin + n && j->component[g] == c;
      j->mark[g] = good ? -1 - next : 0; /* a second place overwrites the first */
    }
  }
  for (int k = 0; k < next && good; k++) {
    good = j->mark[j->member[k]] == -2 - k;
  }
  return good && next == n;
}
#endif

/* Labels joints that are coupled with the same number; lists them component by component. */
static void find_components(form_assembly *a) {
  form_joints *j = &a->joints;
  const int p = a->n_contact;
  int listed = 0;
  j->n_part = 0;
  for (int g = p; g < a->n_group; g++) {
    j->component[g] = -1;
  }
  for (int seed = p; seed < a->n_group; seed++) {
    if (j->component[seed] >= 0) {
      continue;
    }
    form_component *c = &j->part[j->n_part];
    *c = (form_component){.first = listed};
    j->component[seed] = j->n_part;
    j->member[listed++] = seed;
    for (int head = c->first; head < listed; head++) {
      const int g = j->member[head];
      j->offset[g] = c->rows;
      c->rows += form_rows_of(a, g);
      listed = spread(a, g, listed);
    }
    c->count = listed - c->first;
    j->n_part++;
  }
  assert(form_joints_partitioned(a, a->n_group - p));
}

static int ascending(const void *x, const void *y) {
  const int a = *(const int *)x;
  const int b = *(const int *)y;
  return (a > b) - (a < b);
}

/* Lists the contacts that meet joint g and are not listed for component c yet. */
static int list_touching(form_assembly *a, int g, int c, int listed) {
  form_joints *j = &a->joints;
  for (int k = a->near_start[g]; k < a->near_start[g + 1]; k++) {
    const int i = a->near[k];
    if (i < a->n_contact && j->mark[i] != c) {
      j->mark[i] = c;
      j->touch[listed++] = i;
    }
  }
  return listed;
}

/* Contacts that touch each component, ascending, with their first column in Y. A body belongs to
 * one component, so a contact touches at most two. */
static void find_touching(form_assembly *a) {
  form_joints *j = &a->joints;
  int listed = 0;
  for (int i = 0; i < a->n_contact; i++) {
    j->mark[i] = -1;
  }
  for (int c = 0; c < j->n_part; c++) {
    form_component *part = &j->part[c];
    part->touch = listed;
    for (int m = part->first; m < part->first + part->count; m++) {
      listed = list_touching(a, j->member[m], c, listed);
    }
    part->n_touch = listed - part->touch;
    qsort(j->touch + part->touch, (size_t)part->n_touch, sizeof *j->touch, ascending);
    part->columns = 0;
    for (int k = part->touch; k < listed; k++) {
      j->column[k] = part->columns;
      part->columns += form_rows_of(a, j->touch[k]);
    }
  }
}

/* Ascending union of contact i's contact neighbours and everything in its components. */
static int widened(const form_assembly *a, int i, int *out) {
  const form_joints *j = &a->joints;
  const int *list[3] = {a->near + a->near_start[i], NULL, NULL};
  int left[3] = {0, 0, 0};
  while (a->near_start[i] + left[0] < a->near_start[i + 1] && list[0][left[0]] < a->n_contact) {
    left[0]++;
  }
  int n_list = 1;
  int last = -1;
  for (int k = a->near_start[i] + left[0]; k < a->near_start[i + 1]; k++) {
    const int c = j->component[a->near[k]];
    if (c != last && (n_list < 2 || list[1] != j->touch + j->part[c].touch)) {
      list[n_list] = j->touch + j->part[c].touch;
      left[n_list++] = j->part[c].n_touch;
    }
    last = c;
  }
  int n = 0;
  for (;;) {
    int least = a->n_contact;
    for (int l = 0; l < n_list; l++) {
      least = (left[l] > 0 && *list[l] < least) ? *list[l] : least;
    }
    if (least == a->n_contact) {
      return n;
    }
    for (int l = 0; l < n_list; l++) {
      if (left[l] > 0 && *list[l] == least) {
        list[l]++;
        left[l]--;
      }
    }
    if (out != NULL) {
      out[n] = least;
    }
    n++;
  }
}

static base_status reserve(form_assembly *a, base_error *err) {
  form_joints *j = &a->joints;
  size_t dense = 0;
  for (int c = 0; c < j->n_part; c++) {
    form_component *part = &j->part[c];
    part->at = dense;
    dense += (size_t)part->rows * (size_t)(part->rows + part->columns);
  }
  size_t near = 0;
  for (int i = 0; i < a->n_contact; i++) {
    near += (size_t)widened(a, i, NULL);
  }
  if (near > (size_t)INT32_MAX / 2) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "joints couple %zu pairs of contacts", near);
  }
  if (j->dense_mem == NULL || dense > j->cap_dense || (int)near > j->cap_near) {
    j->cap_dense = base_room_of(dense) + 1;
    j->cap_near = (int)(base_room_of(near)) + 1;
    BASE_TRY(form_memory(&j->dense_mem, layout_dense, a, err));
  }
  return BASE_OK;
}

/* Copies C_cc into the widened pattern. */
static base_status widen(form_assembly *a, base_error *err) {
  form_joints *j = &a->joints;
  j->left.near_start[0] = 0;
  j->left.block_at[0] = 0;
  for (int i = 0; i < a->n_contact; i++) {
    const int at = j->left.near_start[i];
    j->left.near_start[i + 1] = at + widened(a, i, j->left.near + at);
    for (int k = at; k < j->left.near_start[i + 1]; k++) {
      j->left.block_at[k + 1] = j->left.block_at[k] + (size_t)form_rows_of(a, i) *
                                                          (size_t)form_rows_of(a, j->left.near[k]);
    }
  }
  const size_t size = j->left.block_at[j->left.near_start[a->n_contact]];
  if (j->block_mem == NULL || size > j->cap_block) {
    j->cap_block = base_room_of(size) + 1;
    BASE_TRY(form_memory(&j->block_mem, layout_blocks, a, err));
  }
  memset(j->left.block, 0, size * sizeof *j->left.block);
  for (int i = 0; i < a->n_contact; i++) {
    int old = a->near_start[i];
    for (int k = j->left.near_start[i]; k < j->left.near_start[i + 1]; k++) {
      if (j->left.near[k] == i) {
        a->self[i] = k;
      }
      if (old < a->near_start[i + 1] && a->near[old] == j->left.near[k]) {
        memcpy(j->left.block + j->left.block_at[k], a->block + a->block_at[old],
               (j->left.block_at[k + 1] - j->left.block_at[k]) * sizeof *j->left.block);
        old++;
      }
    }
  }
  return BASE_OK;
}

base_status form_joints_find(form_assembly *a, base_error *err) {
  form_joints *j = &a->joints;
  if (j->mem == NULL || a->n_group > j->cap_group || a->n_row > j->cap_row) {
    j->cap_group = base_room(a->n_group);
    j->cap_row = base_room(a->n_row);
    BASE_TRY(form_memory(&j->mem, layout_lists, a, err));
  }
  assert(form_assembly_is_linked(a));
  find_components(a);
  find_touching(a);
  return BASE_OK;
}

base_status form_joints_widen(form_assembly *a, base_error *err) {
  BASE_TRY(reserve(a, err));
  return widen(a, err);
}

void form_joints_close(form_joints *j) {
  free(j->mem);
  free(j->dense_mem);
  free(j->block_mem);
}
