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

layout(constant_id = 0) const uint is_pair = 1u;
layout(constant_id = 1) const uint has_heights = 1u;
layout(constant_id = 2) const uint is_ragged = 1u;
layout(constant_id = 3) const uint is_range = 1u;

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

// Where a pixel's bit is; beyond the last pixel there are codes that mean nothing, and room for their q.
uint word_of(uint x, uint y) {
    return min(y * push.validity_words + x / 32u, uint(validity.length()) - 1u);
}

float q_of(float depth, uint x, uint y) {
    return (is_range != 0u ? ray_length(x, y) : 1.0f) / depth;
}

void main() {
    const uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    const uint texel = group * UNPROJECT_LANES + gl_LocalInvocationID.x, first = texel * UNPROJECT_PIXELS;
    if (first >= push.pixels) return;
    const uvec4 code = codes[texel];
    uvec4 next_code = uvec4(0u), height = uvec4(0u), next_height = uvec4(0u);
    if (is_pair != 0u) next_code = next_codes[texel];
    if (has_heights != 0u && push.height_per_code != 0.0f) height = heights[texel];
    if (is_pair != 0u && has_heights != 0u && push.next_height_per_code != 0.0f)
        next_height = next_heights[texel];

    float q[UNPROJECT_PIXELS];
    uint x = first % push.width, y = first / push.width;
    uint word = word_of(x, y), valids = validity[word], next_valids = 0u;
    if (is_pair != 0u) next_valids = next_validity[word];
    [[unroll]] for (uint n = 0u; n < UNPROJECT_PIXELS; ++n) {
        float depth = depth_of(part(code, n));
        if (has_heights != 0u) depth -= push.height_per_code * float(part(height, n));
        bool valid = (valids >> x % 32u & 1u) != 0u;
        if (is_pair != 0u) {
            float next_depth = depth_of(part(next_code, n));
            if (has_heights != 0u) next_depth -= push.next_height_per_code * float(part(next_height, n));
            const bool next_valid = (next_valids >> x % 32u & 1u) != 0u;
            // A pixel valid in one frame alone takes the state of the frame nearer in time.
            const bool is_next = valid != next_valid && push.blend >= 0.5f;
            const float mixed = depth * push.rest + next_depth * push.blend;
            depth = valid && next_valid ? mixed : (is_next ? next_depth : depth);
            valid = is_next ? next_valid : valid;
        }
        q[n] = valid ? q_of(depth, x, y) : 0.0f;
        ++x;
        if (is_ragged != 0u) {  // else the eight lie in one row, and their bits in one word
            y += x == push.width ? 1u : 0u;
            x = x == push.width ? 0u : x;
            word = word_of(x, y);
            valids = validity[word];
            if (is_pair != 0u) next_valids = next_validity[word];
        }
    }
    q_at[2u * texel] = vec4(q[0], q[1], q[2], q[3]);
    q_at[2u * texel + 1u] = vec4(q[4], q[5], q[6], q[7]);
}
