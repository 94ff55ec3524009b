#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

#include "shaders/self_check.h"

layout(local_size_x = SELF_CHECK_GROUP) in;
layout(push_constant, std430) uniform Push { SelfCheckPush push; };
layout(set = 0, binding = SELF_CHECK_BINDING_IN) uniform utextureBuffer texels;
layout(set = 0, binding = SELF_CHECK_BINDING_OUT, std430) writeonly buffer Out { uvec4 words[]; };

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.texel_count) return;
    const uvec4 texel = texelFetch(texels, int(i));
    words[i] = uvec4(self_check_word(texel.x, push.salt), self_check_word(texel.y, push.salt),
                     self_check_word(texel.z, push.salt), self_check_word(texel.w, push.salt));
}
