/* problems/read/read_lcp.h - one complementarity problem of the case format (internal). */
#pragma once

#include "problems/read/case_file.h"
#include "problems/read/node.h"

/* *c is zeroed by the caller and freed with lcp_case_free on success and failure. */
base_status read_lcp_case(json_t *v, lcp_case *c, base_error *err);
void lcp_case_free(lcp_case *c);
