#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Stored values -> codes, validity and parts of tile bounds, without a median.

#include "shaders/surface_codes.h"

const int strip_rows = 2, strip_centre = 0, strip_reach = 1;
const bool outside_repeats = true;

struct Column {
    uint codes[2];
    bool valid[2];
};

Column rank_column(uint codes[strip_rows], bool valid[strip_rows]) {
    return Column(codes, valid);
}

#include "shaders/strip.h"
#include "shaders/surface_output.h"

Pixels filtered(Column columns[8 + 2 * strip_reach]) {
    Pixels pixels;
    [[unroll]] for (int k = 0; k < 8; ++k) {
        pixels.upper[k] = columns[k + 1].codes[0];
        pixels.lower[k] = columns[k + 1].codes[1];
        pixels.upper_valid[k] = columns[k + 1].valid[0];
        pixels.lower_valid[k] = columns[k + 1].valid[1];
    }
    return pixels;
}

void main() {
    const Task task = task_of(gl_GlobalInvocationID.x);
    if (task.there) march(task);
}
