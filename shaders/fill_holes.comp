#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// One pass of hole filling: an invalid code with at least three valid neighbours becomes their lower median,
// which is that of its 3x3 window, because it does not count itself. All other codes stay as stored.

#include "shaders/median3.h"
#include "shaders/surface_codes.h"

const int strip_rows = 4, strip_centre = 1, strip_reach = 1;
const bool outside_repeats = false;

#include "shaders/columns3.h"
#include "shaders/strip.h"

layout(set = 0, binding = 2, std430) buffer Passes { FillPass passes[]; };

const uint most_invalid = 9u - 3u;
bool any_filled = false;  // by this lane

Pixels filtered(Column columns[8 + 2 * strip_reach]) {
    Pixels pixels;
    [[unroll]] for (int k = 0; k < 8; ++k) {
        const Column left = columns[k], centre = columns[k + 1], right = columns[k + 2];
        const uint upper_invalid = left.upper_invalid + centre.upper_invalid + right.upper_invalid;
        const uint lower_invalid = left.lower_invalid + centre.lower_invalid + right.lower_invalid;
        const uint upper = median_of(paired3(left.upper, centre.upper), right.upper);
        const uint lower = median_of(paired3(left.lower, centre.lower), right.lower);
        const bool keeps_upper = centre.upper_valid || upper_invalid > most_invalid;
        const bool keeps_lower = centre.lower_valid || lower_invalid > most_invalid;
        pixels.upper[k] = keeps_upper ? centre.upper_code : upper;
        pixels.lower[k] = keeps_lower ? centre.lower_code : lower;
        pixels.upper_valid[k] = !keeps_upper;  // here: filled
        pixels.lower_valid[k] = !keeps_lower;
    }
    return pixels;
}

Written take(Task task, uint texel, Pixels pixels) {
    const uint inside = inside_bits(texel);
    const bool two_rows = 2u * task.strip + 1u < push.height;
    [[unroll]] for (int k = 0; k < 8; ++k) {
        const bool filled = pixels.upper_valid[k] || (two_rows && pixels.lower_valid[k]);
        // Pixels beyond the task are another lane's, too, and before the picture there are none.
        any_filled = any_filled || (filled && (inside >> k & 1u) != 0u && (texel > 0u || k >= strip_reach));
    }
    return Written(Eight(pixels.upper), Eight(pixels.lower));
}
void finish_word(Task task, uint word) {}
void start_word() {}

void main() {
    const Task task = task_of(gl_GlobalInvocationID.x);
    if (task.there) march(task);
    if (!any_filled) return;
    // The holes that this pass filled may give the next one work.
    atomicMax(passes[push.pass + 1u].groups_x, push.groups);
    atomicMax(passes[push.pass + 1u].groups_y, 1u);
    atomicMax(passes[push.pass + 1u].groups_z, 1u);
}
