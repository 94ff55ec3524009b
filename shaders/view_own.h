// What view_own.frag and its caller agree on. Compiled as GLSL and as C++.
//
// From the clip's own place a vertex is seen where it is whatever its depth: columns and rows of the lattice
// are upright and level on the screen. So the cell, the triangle and the place in it that a pixel shows follow
// from its column and its row alone, and the triangles are drawn by one that fills the picture.
#ifndef TOUCHABLE_SHADERS_VIEW_OWN_H
#define TOUCHABLE_SHADERS_VIEW_OWN_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define OWN_Q 0        // words
#define OWN_COLOURS 1  // PackedColour, words
#define OWN_PLACES 2   // OwnPlace of each column of the picture, then of each row

/// Where a column of pixels is among the lattice's columns, or a row among its rows.
struct OwnPlace {
    uint cell;        // OWN_NOWHERE beside the lattice
    float into;       // how far the pixels' centres are into it, 0 to 1
    uint background;  // of a row: PackedColour of what is not drawn
    uint unused;      // a texel is four words
};
#define OWN_NOWHERE 0xffffffffu

struct OwnPush {
    uint pitch;     // words from one row of the lattice to the next
    uint width;     // of the picture
    float z_per_q;
};

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
