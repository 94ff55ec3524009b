#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Stored values -> the lower median of 5x5, validity and parts of tile bounds.

#include "shaders/median5.h"
#include "shaders/surface_codes.h"

const int strip_rows = 6, strip_centre = 2, strip_reach = 2;
const bool outside_repeats = true;

/// A column of the upper row's window (rows 0 to 4) and the lower one's (rows 1 to 5); the rows' validity.
struct Column {
    Ranked5 upper, lower;
    bool upper_valid, lower_valid;
};

Column rank_column(uint codes[6], bool valid[6]) {
    uint v[6], invalid[6];
    [[unroll]] for (int k = 0; k < 6; ++k) {
        v[k] = valid[k] ? codes[k] : 65535u;
        invalid[k] = valid[k] ? 0u : 1u;
    }
    sort4(v[1], v[2], v[3], v[4]);
    uint upper[5] = uint[5](v[0], v[1], v[2], v[3], v[4]), lower[5] = uint[5](v[5], v[1], v[2], v[3], v[4]);
    insert5(upper);
    insert5(lower);
    const uint shared_invalid = invalid[1] + invalid[2] + invalid[3] + invalid[4];
    Column column;
    column.upper = balanced5(upper, shared_invalid + invalid[0]);
    column.lower = balanced5(lower, shared_invalid + invalid[5]);
    column.upper_valid = valid[2];
    column.lower_valid = valid[3];
    return column;
}

#include "shaders/strip.h"
#include "shaders/surface_output.h"

Pixels filtered(Column columns[8 + 2 * strip_reach]) {
    Pixels pixels;
    Pair5 upper = paired5(columns[1].upper, columns[2].upper);
    Pair5 lower = paired5(columns[1].lower, columns[2].lower);
    [[unroll]] for (int k = 0; k < 8; k += 2) {
        const Pair5 upper_next = paired5(columns[k + 3].upper, columns[k + 4].upper);
        const Pair5 lower_next = paired5(columns[k + 3].lower, columns[k + 4].lower);
        const Quad5 upper_quad = joined5(upper, upper_next), lower_quad = joined5(lower, lower_next);
        pixels.upper[k] = median_of(upper_quad, columns[k].upper);
        pixels.upper[k + 1] = median_of(upper_quad, columns[k + 5].upper);
        pixels.lower[k] = median_of(lower_quad, columns[k].lower);
        pixels.lower[k + 1] = median_of(lower_quad, columns[k + 5].lower);
        upper = upper_next;
        lower = lower_next;
    }
    [[unroll]] for (int k = 0; k < 8; ++k) {
        pixels.upper_valid[k] = columns[k + 2].upper_valid;
        pixels.lower_valid[k] = columns[k + 2].lower_valid;
    }
    return pixels;
}

void main() {
    const Task task = task_of(gl_GlobalInvocationID.x);
    if (task.there) march(task);
}
