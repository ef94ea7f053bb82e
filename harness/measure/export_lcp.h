/* harness/measure/export_lcp.h - a complementarity problem as files that other codes read, and that
 * lcpbench reads back to the same bits. */
#pragma once

#include "lcp/lcp_problem.h"

/* OUT.M.mtx and OUT.q.mtx (Matrix Market). Orthants only: BASE_EUNSUPPORTED. */
base_status export_lcp_mtx(const lcp_problem *p, const char *out, base_error *err);

/* Orthants and equations as Siconos text: an LCP, or a mixed LCP where some blocks are free; M dense,
 * column by column, 17 digits. Any other set: BASE_EUNSUPPORTED; no memory for n x n: BASE_ENOMEM. */
base_status export_lcp_text(const lcp_problem *p, const char *path, base_error *err);

/* Second-order cones, all of one size, as Siconos friction text. Friction in 2D and 3D, and with
 * rolling (five rows); any other block: BASE_EUNSUPPORTED. */
base_status export_lcp_friction(const lcp_problem *p, const char *path, base_error *err);
