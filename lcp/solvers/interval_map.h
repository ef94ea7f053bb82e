/* interval_map.h - one row lo <= x <= hi, y the velocity that answers it, as one equation F(x, y) = 0:
 *
 *   LCP_MAP_MIN      min(x - lo, y);  box: x - clip(x - y, lo, hi)
 *   LCP_MAP_FISCHER  phi(x - lo, y), phi(a, b) = a + b - sqrt(a^2 + b^2) (De Luca, Facchinei & Kanzow 1996);
 *                    box: phi(x - lo, -phi(hi - x, -y)) (Billups 1995)
 *   a row without bounds: y */
#pragma once

typedef enum lcp_map { LCP_MAP_FISCHER, LCP_MAP_MIN } lcp_map;

/* F, and an element of its generalised gradient: *dx by x, *dy by y. Bounds are -/+HUGE_VAL where absent. */
double lcp_interval_map(lcp_map map, double lo, double hi, double x, double y, double *dx,
                        double *dy);
