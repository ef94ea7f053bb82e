/* The engine `table`: every nonbasic column is kept, so that a column is read and not solved for. */
#include "lcp/solvers/lemke/engine.h"

static lemke_table *table_of(lemke_engine *e) {
  return (lemke_table *)e;
}

/* The tableau of e, all its columns up to date. */
static lin_tableau *whole(lemke_engine *e) {
  lin_tableau *t = &table_of(e)->tableau;
  lin_tableau_finish(t);
  return t;
}

/* Column j of -M'. */
static void write_column(const lemke_system *s, int j, double *restrict a) {
  const lcp_column c = lemke_system_column(s, j);
  const double unit = s->view ? -lemke_power(s->col_exp[j]) : -1;
  if (c.row == NULL) {
    const double *restrict val = c.val;
    for (int i = 0; i < s->rows; ++i) {
      a[i] = unit * val[i];
    }
    return;
  }
  memset(a, 0, sizeof *a * (size_t)s->rows);
  for (int p = 0; p < c.count; ++p) {
    a[c.row[p]] = unit * c.val[p];
  }
}

static void start(lemke_table *t, int n) {
  lin_tableau_start(&t->tableau, n);
  t->engine.n = n;
  t->engine.x = t->tableau.x;
  t->engine.delta = t->tableau.delta;
}

static bool fill(lemke_engine *e, const lemke_system *s, unsigned char *in_z) {
  lin_tableau *t = &table_of(e)->tableau;
  if (lemke_engine_holds(e, s, in_z)) {
    return true;
  }
  if (s->any_free || s->rows > t->cap || memchr(in_z, 1, (size_t)s->rows) != NULL) {
    return false;
  }
  const double q_unit = s->view ? lemke_power(-s->q_exp) : 1;
  start(table_of(e), s->rows);
  e->system = s;
  e->edition = s->edition;
  for (int j = 0; j < e->n; ++j) {
    write_column(s, j, lin_tableau_entries(t, j));
    e->x[j] = q_unit * s->q[j];
  }
  for (int i = 0; i < e->n && s->view && s->row_exp != NULL; ++i) {
    const double unit = lemke_power(s->row_exp[i]);
    for (int j = 0; j < e->n; ++j) {
      lin_tableau_entries(t, j)[i] *= unit;
    }
    e->x[i] *= unit;
  }
  return true;
}

static void open(lemke_engine *e, const double *d) {
  lin_tableau_cover(whole(e), d);
}

// NOLINTNEXTLINE(readability-non-const-parameter): the signature of lemke_engine.column
static const double *column(lemke_engine *e, int var, double *room) {
  (void)room;
  return lin_tableau_column(whole(e), var);
}

static bool replace(lemke_engine *e, int p, int entering, const double *d) {
  (void)d; /* the column of `entering` */
  lin_tableau *t = whole(e);
  t->generic = e->generic;
  (e->head[p] == 2 * e->n ? lin_tableau_replace_last : lin_tableau_replace)(t, p, entering);
  return true;
}

static void append(lemke_engine *e, const double *column_n, const double *row, double q) {
  lin_tableau_append(whole(e), column_n, row, q);
  e->n++;
}

static void settle(lemke_engine *e, double *r) {
  lin_tableau_correct(whole(e), r);
}

static const lemke_engine_kind table_kind = {.word = "table",
                                             .fill = fill,
                                             .open = open,
                                             .column = column,
                                             .replace = replace,
                                             .append = append,
                                             .settle = settle};

void lemke_table_layout(lemke_table *t, int rows, base_arena *a) {
  lin_tableau_layout(&t->tableau, rows, a);
  t->engine =
      (lemke_engine){.kind = &table_kind, .head = t->tableau.head, .where = t->tableau.where};
}

void lemke_table_clear(lemke_table *t) {
  start(t, 0);
  lemke_engine_forget(&t->engine);
}
