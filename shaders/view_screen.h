// What the shaders that fill the picture (view_screen.vert, view_background.frag) and their caller agree on. Compiled as GLSL and as C++.
#ifndef TOUCHABLE_SHADERS_VIEW_SCREEN_H
#define TOUCHABLE_SHADERS_VIEW_SCREEN_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define SCREEN_BACKGROUND 0  // PackedColour of each row of the picture

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
