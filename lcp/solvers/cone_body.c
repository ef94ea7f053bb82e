#include "lcp/solvers/cone_body.h"

#include "lcp/lcp_column.h"

base_status lcp_cone_body_check(const lcp_cone_step *s, const lcp_problem *p,
                                const lcp_cone_scaled *c, base_error *err) {
  const lcp_factored *f = p->M.factored;
  BASE_TRY(lin_body_space_admits(f, err));
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *b = &c->piece[k];
    if (s->sweep.group[b->start] != s->sweep.group[b->start + b->size - 1]) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED,
                       "cone at row %d spans two groups of the factored form", b->start);
    }
  }
  return BASE_OK;
}

/* X and Y of the pieces of group g in the places of the group's rows. */
static void put_pieces(lcp_cone_step *s, const lcp_cone_scaled *c, int g, double *X, double *Y) {
  const int *row;
  const int n = lin_body_space_rows(&s->body, g, &row);
  for (int k = 0; k < n; k += c->piece[s->piece_of[row[k]]].size) {
    const lcp_block *b = &c->piece[s->piece_of[row[k]]];
    const size_t at = lcp_cone_scaled_at(c, b);
    for (int j = 0; j < b->size; j++) {
      for (int i = 0; i < b->size; i++) {
        X[k + i + (k + j) * n] = c->X[at + (size_t)(i + j * b->size)];
        Y[k + i + (k + j) * n] = c->Y[at + (size_t)(i + j * b->size)];
      }
    }
  }
}

/* T = X + Y (s S s + weight) and Y of group g. Returns whether both are symmetric, to the last bit. */
static bool local(lcp_cone_step *s, const lcp_factored *f, const lcp_cone_scaled *c, int g,
                  double weight) {
  const int *row;
  const int n = lin_body_space_rows(&s->body, g, &row);
  double *T = s->body.T + s->body.at[g], *Y = s->body.Y + s->body.at[g];
  bool symmetric = true;
  put_pieces(s, c, g, T, Y);
  for (int k = 0; k < n * n; k++) {
    T[k] += weight * Y[k];
  }
  for (int j = 0, first = 0; j < n && f->shift != NULL; j++) {
    const lcp_column shift = lcp_csc_column(f->shift, row[j]);
    first = 0;
    for (int e = 0; e < shift.count; e++) {
      while (first < n && row[first] < shift.row[e]) {
        first++;
      }
      const double value = (first < n && row[first] == shift.row[e])
                               ? c->s[shift.row[e]] * shift.val[e] * c->s[row[j]]
                               : 0;
      for (int i = 0; i < n && value != 0; i++) {
        T[i + j * n] += Y[i + first * n] * value;
      }
    }
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < j; i++) {
      symmetric = symmetric && T[i + j * n] == T[j + i * n] && Y[i + j * n] == Y[j + i * n];
    }
  }
  return symmetric;
}

bool lcp_cone_body_factor(lcp_cone_step *s, const lcp_factored *f, lcp_cone_scaled *c,
                          double weight, base_status *status) {
  base_error unused;
  bool symmetric = true, regular = false;
  if (!s->weighed) {
    lin_weigh_rows(f, s->sweep.L, s->sweep.G);
    s->weighed = true;
  }
  *status = lin_body_space_begin(&s->body, f, s->sweep.G, false, c->s, s->active, &unused);
  for (int g = 0; *status == BASE_OK && g < f->n_group; g++) {
    symmetric = local(s, f, c, g, weight) && symmetric;
  }
  if (*status == BASE_OK) {
    *status = lin_body_space_factor(&s->body, symmetric, &regular, &unused);
  }
  return *status == BASE_OK && regular;
}
