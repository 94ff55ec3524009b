#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

#include "tests/gpu/mix_words.h"

layout(local_size_x = mix_words_group) in;
layout(push_constant, std430) uniform Push { MixWordsPush push; };
layout(set = 0, binding = 0, std430) readonly buffer In { uint words_in[]; };
layout(set = 0, binding = 1) uniform utextureBuffer texels_in;
layout(set = 0, binding = 2, std430) writeonly buffer TexelsOut { uvec4 texels_out[]; };
layout(set = 0, binding = 3, std430) buffer Out { uint words_out[]; };
layout(set = 0, binding = 4, std430) writeonly buffer Seen { float seen[4]; };

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i == 0u) seen = float[4](push.direction.x, push.direction.y, push.direction.z, push.scale);
    if (i >= push.count) return;
    words_out[i] = mix_word(words_in[i], push.salt);
    if (i % 4u == 0u) texels_out[i / 4u] = texelFetch(texels_in, int(i / 4u)).wzyx;
}
