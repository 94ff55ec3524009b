#version 460
// SPDX-License-Identifier: Apache-2.0

// Copies a buffer, 16 bytes a lane: measures the largest bandwidth of device memory.

layout(local_size_x = 256) in;
layout(set = 0, binding = 0, std430) readonly buffer From { uvec4 from[]; };
layout(set = 0, binding = 1, std430) writeonly buffer To { uvec4 to[]; };

void main() {
    const uint lane = gl_GlobalInvocationID.x;
    if (lane < from.length()) to[lane] = from[lane];
}
