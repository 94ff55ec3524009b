// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture being composed in linear light: the painted surface on its background, the shapes of fingers, and
// their dents. make_picture and CpuDrawing draw them with plain code; the GPU draws the same shapes
// (gpu_painting.hpp). And text panels in a corner of a finished one: the legend of fingers, and the marks of
// a scale.

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/overlays.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"
#include "shaders/dents.h"

namespace touchable {

/// A picture being composed: linear light, 0 to 1 a channel, not brightness (sRGB), so that mixing and
/// averaging are correct; and the painters' z.
struct LightPicture {
    int width = 0, height = 0;
    std::vector<float> z;
    std::vector<glm::vec3> light;

    std::size_t index(int x, int y) const { return pixel_place(x, y, width); }
};

/// Light of a colour of three bytes.
glm::vec3 light_of(PackedColour colour);
/// Light from brightness (sRGB), clamped to 0 to 1 a channel; and the inverse.
glm::vec3 light_of_brightness(const glm::vec3& brightness);
glm::vec3 brightness_of(const glm::vec3& light);

/// The background of a picture of that height: a quiet dark grey, a little lighter below.
PackedColour background_colour(int row, int height);

/// The drawn surface in front of the background.
LightPicture on_background(PicturePlanes planes);

/// Averages blocks of samples x samples; `picture`'s sides are multiples of `samples`. RGB of 8 bits.
Image developed(const LightPicture& picture, int samples);

/// (x, y, z, 1) of the screen -> clip space.
glm::dmat4 clip_from_pixel(const ViewCamera& camera);

/// A rectangle of pixels, from (x0, y0) up to but not including (x1, y1).
struct PixelBounds {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// The pixels that a ball (world, scene units) may cover; nullopt if its centre is not visible.
std::optional<PixelBounds> bounds_of_ball(const ViewCamera& camera, const glm::dvec3& centre, double radius);
/// The same; nullopt also if there are none.
std::optional<PixelBounds> bounds_in_sight(const ViewCamera& camera, const glm::dvec3& centre, double radius);
/// Least x and y, greatest x and y in clip space; all 0 for nullopt.
glm::vec4 clip_bounds(const std::optional<PixelBounds>& bounds, const ViewCamera& camera);

/// A ring of a solid of revolution: height along the axis, radius, and the outline's normal there (along the
/// axis, away from it).
struct Ring {
    double height, radius;
    double normal_along, normal_away;
};

/// A solid's colour and opacity.
struct SolidMaterial {
    glm::vec3 light{1.0F};  ///< colour, as light
    float opacity = 1;  ///< below 1: translucent, visible more faintly through other objects too; does not
                        ///< write z
};

/// A ball, or the mantle of a frustum: two rings joined round the axis. World, scene units.
struct Solid {
    glm::dvec3 foot{0.0};           ///< of a ball: its centre
    glm::dvec3 along{0.0, 1, 0.0};  ///< the axis, a unit vector
    Ring from{}, to{};              ///< a ball uses only the radius of `from`
    bool is_ball = false;
    SolidMaterial material;
};

/// A point of the thread behind a finger. World, scene units.
struct ThreadPoint {
    glm::dvec3 at{0.0};
    double radius = 0;
    glm::vec3 light{1.0F};
    bool is_joined = false;  ///< to the point before
};

/// The soft shadow of a ball on the surface under it. World, scene units.
struct BallShadow {
    glm::dvec3 centre{0.0};
    double reach = 0;
    float darkness = 0;  ///< in its middle, 0 to 1
};

/// A finger's shadow on the surface under it, away from the light: the higher the finger, the farther, wider
/// and fainter. 1.5 radii wide and 0.75 dark if the finger touches; one radius above, 2.5 radii wide, 0.34
/// dark, and 1.2 radii aside.
BallShadow shadow_of(const FingerMark& finger, double radius);

/// The shapes of fingers for any painter, in drawing order.
struct FingerShapes {
    std::vector<BallShadow> shadows;
    std::vector<ThreadPoint> threads;  ///< one after another
    std::vector<Solid> solids;
    std::vector<Solid> veils;  ///< translucent; all rods before all balls
};

/// Makes the shapes of every finger: its proxy as a ball in its colour, the goal as a bubble visible through
/// what hides it, a rod between them, the force on the finger as an arrow, and the trail as a thread that
/// thins with age. An arrow's thickness depends on `eye`, its direction and length do not. `shapes` is
/// overwritten.
void shape_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const glm::dvec3& eye,
                   FingerShapes& shapes);

/// Draws the fingers' dents (SurfaceDent), then the fingers.
void draw_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const ViewCamera& camera,
                  LightPicture& picture);

/// A place of the surface displaced by a finger (shaders/dents.h): into the surface, as a dent, and along it,
/// stretching the surroundings. World, scene units.
struct SurfaceDent {
    glm::dvec3 centre{0.0}, normal{0.0}, moved{0.0};
    double reach = 0;
};

/// The dents of touching fingers whose surface gives way (FingerMark::given_way), limited to `most_dented` of
/// a finger's radius. `dents` is overwritten.
inline constexpr double dent_reach = 2.6, most_dented = 1.3;  // radii of a finger
void shape_dents(std::span<const FingerMark> fingers, const MarkSizes& sizes,
                 std::vector<SurfaceDent>& dents);

/// The sum of all dents at a place of the surface; nullopt if no dent reaches it.
struct DentedPlace {
    glm::vec3 moved{0.0F}, normal_before{0.0F}, normal{0.0F};
};
std::optional<DentedPlace> dented(std::span<const SurfaceDent> dents, const glm::dvec3& place);

/// Draws dents into a picture of the surface alone: the plain twin of DentDrawing and DentPatches.
void draw_dents(std::span<const SurfaceDent> dents, const ViewCamera& camera, LightPicture& picture);

/// Contents of a legend of fingers.
struct Legend {
    std::size_t fingers = 0;
    double pixels_per_newton = 1;  ///< length of an arrow across the line of sight, at the scene's middle
};

/// The force of the legend's arrow, N: the largest of 1, 2 and 5 times powers of ten whose arrow is at most
/// `pixels` long.
double scale_newtons(double pixels_per_newton, double pixels);

/// Draws a panel into the lower left of `image` (RGB, 8 bits): the meaning of ball, bubble, arrow and thread,
/// an arrow's length for a force, and the fingers' colours by number. Draws nothing below 480x270 pixels,
/// where it would hide the scene.
Result<void> draw_legend(const Legend& legend, Image& image);

/// A labelled value of a scale.
struct ScaleMark {
    double value;
    std::string text;
};

/// Round values within a range (1, 2 or 5 times a power of ten apart), as many as `fits` accepts. Never
/// empty: if not even two fit, the round value nearest to the middle.
std::vector<ScaleMark> scale_marks(const Overlays::Range& range,
                                   const std::function<bool(const std::vector<ScaleMark>&)>& fits);

}  // namespace touchable
