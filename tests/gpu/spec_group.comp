#version 460
// SPDX-License-Identifier: Apache-2.0

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint step_size = 3u;
layout(set = 0, binding = 0, std430) writeonly buffer Out { uint words_out[]; };

void main() {
    const uint width = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    words_out[gl_GlobalInvocationID.y * width + gl_GlobalInvocationID.x] = step_size * gl_GlobalInvocationID.x;
}
