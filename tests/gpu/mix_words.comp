#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "tests/gpu/mix_words.h"

layout(local_size_x = mix_words_group) in;
layout(push_constant, scalar) uniform Push { MixWordsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer In { uint words_in[]; };
layout(set = 0, binding = 1) uniform utextureBuffer texels_in;
layout(set = 0, binding = 2, rgba32ui) uniform writeonly uimageBuffer texels_out;
layout(set = 0, binding = 3, scalar) buffer Out { uint words_out[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Seen { float seen[4]; };

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i == 0u) seen = float[4](push.direction.x, push.direction.y, push.direction.z, push.scale);
    if (i >= push.count) return;
    words_out[i] = mix_word(words_in[i], push.salt);
    if (i % 4u == 0u) imageStore(texels_out, int(i / 4u), texelFetch(texels_in, int(i / 4u)).wzyx);
}
