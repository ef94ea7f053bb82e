/* problems/geometry/shapes.h - convex pieces of bodies and the exact gap functions between them.
 *
 * A piece is a core (point, segment, planar convex polygon, box, thin disc or cylinder) swept by a
 * sphere of radius r; a compound body is several pieces. Normals point from the second piece
 * towards the first; gaps are signed distances along them, positive when open.
 *
 * Every listed point obeys  d gap/dt = n . (v_a(x) - v_b(x))  with v_a, v_b the material velocities
 * of the two bodies at x, except the crossing points of two box edges inside a face manifold, where
 * it holds up to (tilt of the faces) x (sliding speed). */
#pragma once

#include "problems/spec/spec.h"

#include <stdint.h>

enum { GAP_MAX = 4 * SPEC_VERTICES }; /* most points one pair of pieces can give */

typedef enum piece_kind {
  PIECE_POINT,   /* 1 vertex */
  PIECE_SEGMENT, /* 2 vertices */
  PIECE_POLYGON, /* planar, counter-clockwise */
  PIECE_BOX,     /* spatial */
  PIECE_DISC,    /* spatial, axis = third axis of the piece, half length half[2] */
} piece_kind;

typedef struct piece {
  piece_kind kind;
  int n_vertex;
  double *vertex; /* 3 n_vertex, body frame; owned by the world */
  double r;       /* sweeping radius; PIECE_DISC: radius of the disc */
  double half[3];
  double pos[3], rot[9]; /* of the piece in the body frame */
} piece;

typedef struct pose {
  double x[3];
  double R[9]; /* world = x + R local */
} pose;

typedef struct gap_point {
  double x[3]; /* where the impulse acts, world [m] */
  double n[3];
  double gap;       /* [m] */
  uint32_t feature; /* identifies the point within the pair of pieces; < GAP_FEATURES */
} gap_point;

enum { GAP_FEATURES = 1 << 12 };

/* How many vertices and pieces a shape needs. */
int shape_pieces(const spec_shape *s);
int shape_vertices(const spec_shape *s, int dim);

/* Fills shape_pieces(s) pieces; their vertices are taken from *vertex, which is moved on. */
void shape_split(const spec_shape *s, int dim, piece *out, double **vertex);

/* Radius about the body's origin that contains the piece [m]. */
double piece_bound(const piece *p);

/* Points below `margin`; half-space normal . x >= offset. */
int gap_halfspace(const piece *p, const pose *at, const double *normal, double offset,
                  double margin, gap_point *out);

int gap_planar(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
               gap_point *out);
/* Every kind but the polygon, which is planar (spec_check_all refuses it in space). */
int gap_spatial(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
                gap_point *out);

/* Box against box (spatial), part of gap_spatial. */
int gap_boxes(const piece *pa, const pose *at_a, const piece *pb, const pose *at_b, double margin,
              gap_point *out);

/* Closest points of the segments p0 p1 and q0 q1. */
void segment_closest(const double *p0, const double *p1, const double *q0, const double *q1,
                     double *on_p, double *on_q);
