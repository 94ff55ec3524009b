// SPDX-License-Identifier: Apache-2.0
// Interface of view_screen.vert and view_background.frag, which fill the picture, for GLSL and C++.
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
