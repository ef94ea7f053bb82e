/* tests/support/shape_list.h - one shape of every kind, in the plane and in space. */
#pragma once

#include "problems/spec/spec.h"

static const spec_shape polygon5 = {
    .kind = SPEC_POLYGON,
    .n_vertex = 5,
    .vertex = (double[5][2]){{-0.4, -0.3}, {0.5, -0.35}, {0.6, 0.1}, {0.1, 0.5}, {-0.5, 0.2}}};
static const spec_shape planar_shapes[] = {
    {.kind = SPEC_POINT},
    {.kind = SPEC_SPHERE, .r = 0.3},
    {.kind = SPEC_ROD, .half = {0.5}},
    {.kind = SPEC_ROD, .r = 0.1, .half = {0.4}},
    {.kind = SPEC_BOX, .half = {0.5, 0.3}},
};

static const spec_shape spatial_shapes[] = {
    {.kind = SPEC_POINT},
    {.kind = SPEC_SPHERE, .r = 0.3},
    {.kind = SPEC_ROD, .r = 0.1, .half = {0.4}},
    {.kind = SPEC_BOX, .half = {0.5, 0.3, 0.2}},
    {.kind = SPEC_DISC3D, .r = 0.4},
    {.kind = SPEC_DISC3D, .r = 0.3, .half = {0, 0, 0.2}},
};
