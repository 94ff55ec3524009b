#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require

// Codes of a pair of frames -> q of every pixel, for the eye.

#include "shaders/unproject.h"

layout(local_size_x = UNPROJECT_LANES) in;

layout(push_constant, scalar) uniform Push {
    UnprojectPush push;
};
layout(set = 0, binding = UNPROJECT_CODES, scalar) readonly buffer Codes {
    uvec4 codes[];
};
layout(set = 0, binding = UNPROJECT_VALIDITY, scalar) readonly buffer Validity {
    uint validity[];
};
layout(set = 0, binding = UNPROJECT_HEIGHTS, scalar) readonly buffer Heights {
    uvec4 heights[];
};
layout(set = 0, binding = UNPROJECT_NEXT_CODES, scalar) readonly buffer NextCodes {
    uvec4 next_codes[];
};
layout(set = 0, binding = UNPROJECT_NEXT_VALIDITY, scalar) readonly buffer NextValidity {
    uint next_validity[];
};
layout(set = 0, binding = UNPROJECT_NEXT_HEIGHTS, scalar) readonly buffer NextHeights {
    uvec4 next_heights[];
};
layout(set = 0, binding = UNPROJECT_Q, scalar) writeonly buffer Q {
    vec4 q_at[];
};

// The n-th 16 bits.
uint part(uvec4 texel, uint n) {
    return texel[n / 2u] >> n % 2u * 16u & 0xffffu;
}

float depth_of(uint code) {
    const float m = float(push.top_code == 0u ? code : push.top_code - code);
    const float length_of_code = push.base + push.step * m;
    return push.is_inverse != 0u ? 1.0f / length_of_code : length_of_code;
}

float ray_length(uint x, uint y) {
    const float u = (float(x) - push.cx) * push.per_fx, v = (float(y) - push.cy) * push.per_fy;
    return sqrt(u * u + v * v + 1.0f);
}

void main() {
    const uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    const uint texel = group * UNPROJECT_LANES + gl_LocalInvocationID.x, first = texel * UNPROJECT_PIXELS;
    if (first >= push.pixels) return;
    const bool between = push.blend > 0.0f;
    const uvec4 code = codes[texel], next_code = next_codes[texel];
    const uvec4 height = push.height_per_code != 0.0f ? heights[texel] : uvec4(0u);
    const uvec4 next_height = push.next_height_per_code != 0.0f ? next_heights[texel] : uvec4(0u);
    float q[UNPROJECT_PIXELS];
    uint x = first % push.width, y = first / push.width;
    [[unroll]] for (uint n = 0u; n < UNPROJECT_PIXELS; ++n) {
        // Beyond the last pixel there are codes that mean nothing, and room for their q.
        const uint word = min(y * push.validity_words + x / 32u, uint(validity.length()) - 1u);
        const bool valid = (validity[word] >> x % 32u & 1u) != 0u;
        const bool next_valid = (next_validity[word] >> x % 32u & 1u) != 0u;
        const float depth = depth_of(part(code, n)) - push.height_per_code * float(part(height, n));
        const float next_depth =
            depth_of(part(next_code, n)) - push.next_height_per_code * float(part(next_height, n));
        // A pixel valid in one frame alone takes the state of the frame nearer in time.
        const bool is_next = between && valid != next_valid && push.blend >= 0.5f;
        const bool is_mix = between && valid && next_valid;
        const float here = is_mix ? depth * push.rest + next_depth * push.blend : (is_next ? next_depth : depth);
        const float planar_q = (push.is_range != 0u ? ray_length(x, y) : 1.0f) / here;
        q[n] = (is_next ? next_valid : valid) ? planar_q : 0.0f;
        const bool row_ends = x + 1u == push.width;
        x = row_ends ? 0u : x + 1u;
        y += row_ends ? 1u : 0u;
    }
    q_at[2u * texel] = vec4(q[0], q[1], q[2], q[3]);
    q_at[2u * texel + 1u] = vec4(q[4], q[5], q[6], q[7]);
}
