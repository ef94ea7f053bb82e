/* formulations/joint/joint.h - what the files of the elimination of joints (assembly_joint.c) tell each other; included by
 * these alone. */
#pragma once

#include "formulations/assembly.h"

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
