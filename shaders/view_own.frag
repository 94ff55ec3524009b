#version 460
#extension GL_GOOGLE_include_directive : require

// The triangles of the lattice as the clip's own camera sees them, with the arithmetic of raster.comp.

#include "shaders/cut_rule.h"
#include "shaders/view_own.h"

layout(push_constant, std430) uniform Push {
    OwnPush push;
};
layout(set = 0, binding = OWN_Q) uniform utextureBuffer q_words;
layout(set = 0, binding = OWN_COLOURS) uniform utextureBuffer colour_words;
layout(set = 0, binding = OWN_PLACES) uniform utextureBuffer places;

layout(location = 0) out vec4 drawn;

OwnPlace place_at(uint n) {
    const uvec4 texel = texelFetch(places, int(n));
    return OwnPlace(texel.x, uintBitsToFloat(texel.y), texel.z, texel.w);
}

/// A corner's colour and q.
vec4 corner(uint i, uint j) {
    const int at = int(j * push.pitch + i);
    const uint colour = texelFetch(colour_words, at).x;
    return vec4(colour & 255u, colour >> 8 & 255u, colour >> 16 & 255u,
                uintBitsToFloat(texelFetch(q_words, at).x));
}

void main() {
    const OwnPlace column = place_at(uint(gl_FragCoord.x)), row = place_at(push.width + uint(gl_FragCoord.y));
    const bool is_there = column.cell != OWN_NOWHERE && row.cell != OWN_NOWHERE;
    const uint i = is_there ? column.cell : 0u, j = is_there ? row.cell : 0u;
    const bool is_right = column.into >= row.into;  // of the cell's diagonal, from its upper left
    const vec4 a = corner(i, j), c = corner(i + 1u, j + 1u);
    const vec4 other = corner(is_right ? i + 1u : i, is_right ? j : j + 1u);
    const float of_other = abs(column.into - row.into), of_c = min(column.into, row.into);
    const vec4 here = a + of_other * (other - a) + of_c * (c - a);
    const float z = here.w * push.z_per_q;
    const bool is_drawn = is_there && !triangle_is_cut(a.w, other.w, c.w) && z <= 1.0f;
    drawn = is_drawn ? vec4(here.rgb / 255.0f, 1.0f) : unpackUnorm4x8(row.background);
    gl_FragDepth = is_drawn ? z : 0.0f;
}
