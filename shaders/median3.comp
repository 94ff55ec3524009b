#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Stored values -> the lower median of 3x3, validity and parts of tile bounds.

#include "shaders/median3.h"
#include "shaders/surface_codes.h"

const int strip_rows = 4, strip_centre = 1, strip_reach = 1;
const bool outside_repeats = true;

#include "shaders/columns3.h"
#include "shaders/strip.h"
#include "shaders/surface_output.h"

Pixels filtered(Column columns[8 + 2 * strip_reach]) {
    Pixels pixels;
    [[unroll]] for (int k = 0; k < 8; k += 2) {
        const Pair3 upper = paired3(columns[k + 1].upper, columns[k + 2].upper);
        const Pair3 lower = paired3(columns[k + 1].lower, columns[k + 2].lower);
        pixels.upper[k] = median_of(upper, columns[k].upper);
        pixels.upper[k + 1] = median_of(upper, columns[k + 3].upper);
        pixels.lower[k] = median_of(lower, columns[k].lower);
        pixels.lower[k + 1] = median_of(lower, columns[k + 3].lower);
    }
    [[unroll]] for (int k = 0; k < 8; ++k) {
        pixels.upper_valid[k] = columns[k + 1].upper_valid;
        pixels.lower_valid[k] = columns[k + 1].lower_valid;
    }
    return pixels;
}

void main() {
    const Task task = task_of(gl_GlobalInvocationID.x);
    if (task.there) march(task);
}
