// SPDX-License-Identifier: Apache-2.0
// Interface of the kernel light.comp and its caller. Compiled as GLSL and as C++.
//
// Turns q of every vertex and its colour into the colour that is drawn, lit by the normal of its
// surroundings: the sum over 5x5 vertices of the normals of the triangles at each, as long as those are
// large. A lane takes eight columns of vertices and marches down them; a row of cells adds its share to the
// sums of the six rows of vertices that it lights, so that no normal is stored.
//
// The plane of a triangle is q = n . ray, so its normal is two differences of q and the plane's q on the
// optical axis; and the cross product of its sides is n / (q0 q1 q2), up to a factor that is the same for
// all.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_LIGHT_H
#define TOUCHABLE_SHADERS_LIGHT_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define LIGHT_LANES 8
#define LIGHT_COLUMNS 8  // of a lane
#define LIGHT_STRIP 16   // rows of a lane, which starts with five rows more than it lights

#define LIGHT_Q 0        // texels of 4
#define LIGHT_RGB 1      // texels: 3 bytes a vertex, rows as long as q's; any buffer if there is no colour
#define LIGHT_COLOURS 2  // PackedColour, rows as long as q's

/// Specialisation constants, in order: 0 or 1.
struct LightConstants {
    uint has_colour;
    uint is_lit;  // 0: colours as they are
};

struct LightPush {
    float fx, fy, cx, cy;   // of the clip's camera, pixels
    float unit;             // scene units: as large as any depth, so that sums stay in the range of floats
    float far_q;            // clay: q of the far end; below, 1 / (q of the near end - that)
    float per_q_range;
    float strength;         // of the light on colours
    uint width, height;     // of the lattice
    uint pitch;             // texels of a row of q
};

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
