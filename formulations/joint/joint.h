/* formulations/joint/joint.h - what the files of the elimination of joints (assembly_joint.c) tell each other; included by
 * these alone. */
#pragma once

#include "formulations/assembly.h"

/* Share of its diagonal that a row must have lost before it is asked whether it is blocked, and is computed from what is left of it. A
 * row that keeps the share s is known to some roundings over the root of s of its terms: 1e-12 at 1e-6, and lcp_share asks for 1e-11. */
#define FORM_MUCH_LOST 1e-6

/* The components of the joints, and the contacts that each touches; room for both. joint_parts.c */
base_status form_joints_find(form_assembly *a, base_error *err);
/* After form_joints_find: C_cc in the pattern of C', with room for S and Y of each component. BASE_EUNSUPPORTED: more pairs of
 * contacts than an int counts. */
base_status form_joints_widen(form_assembly *a, base_error *err);
#ifndef NDEBUG
/* Every one of n joints is a member of one component, the one that it is labelled with. */
bool form_joints_partitioned(const form_assembly *a, int n);
#endif

/* After the elimination: what the joints block of the contacts, into a->known. joint_judge.c */
void form_joints_judge(form_assembly *a);
/* After that: C' and r' of rows that hardly move, to the digits of what is left of them. joint_faint.c */
void form_joints_renew(form_assembly *a);

/* x = S^-1 x over the rows of one component, in their order; 0 where a row says what others have said. assembly_joint.c */
void form_joints_solve(const form_joints *j, const form_component *part, double *x, double *work);
