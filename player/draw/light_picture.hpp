#pragma once

// A picture while it is put together in light: the painted surface on its background, the shapes that fingers
// are drawn as, and the dents that they make. make_picture and CpuDrawing draw them plainly; the GPU draws
// the same shapes (gpu_painting.hpp).

#include <cstddef>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <vector>

#include "engine/picture/image.hpp"
#include "player/draw/drawn_surface.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/view.hpp"
#include "shaders/dents.h"

namespace touchable {

/// A picture while it is put together: light, 0 to 1 a channel, not yet brightness as eyes see it (sRGB), so
/// that mixing and averaging are right; and z as painters have it.
struct LightPicture {
    int width = 0, height = 0;
    std::vector<float> z;
    std::vector<glm::vec3> light;

    std::size_t index(int x, int y) const { return pixel_place(x, y, width); }
};

/// Light of a colour of three bytes.
glm::vec3 light_of(PackedColour colour);
/// Light of brightness as eyes see it, 0 to 1 a channel, beyond which it is cut off; and the other way round.
glm::vec3 light_of_brightness(const glm::vec3& brightness);
glm::vec3 brightness_of(const glm::vec3& light);

/// What a picture of a height has where nothing is drawn: a quiet dark grey, a little lighter below.
PackedColour background_colour(int row, int height);

/// The drawn surface before the background.
LightPicture on_background(PicturePlanes planes);

/// Averages blocks of samples x samples; `picture`'s sides are multiples of that. RGB of 8 bits.
Image developed(const LightPicture& picture, int samples);

/// (x, y, z, 1) of the screen -> clip space.
glm::dmat4 clip_from_pixel(const ViewCamera& camera);

/// Pixels, x and y: from there to before there.
struct PixelBounds {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// The pixels that a ball (world, scene units) may cover; nothing where its middle is not in sight.
std::optional<PixelBounds> bounds_of_ball(const ViewCamera& camera, const glm::dvec3& centre, double radius);
/// Their corners in clip space: least x and y, greatest x and y; all 0 for nothing.
glm::vec4 clip_bounds(const std::optional<PixelBounds>& bounds, const ViewCamera& camera);

/// A ring of a solid of revolution: its height along the axis, its radius, and the outline's normal there
/// (along the axis, away from it).
struct Ring {
    double height, radius;
    double normal_along, normal_away;
};

/// What a solid is made of.
struct SolidMaterial {
    glm::vec3 light{1.0F};  ///< colour, as light
    float opacity = 1;  ///< below 1: seen through, and behind other things too, more faintly; leaves z alone
};

/// A ball, or the mantle of a frustum: what an outline of two rings sweeps round its axis. World, scene
/// units.
struct Solid {
    glm::dvec3 foot{0.0};           ///< of a ball: its centre
    glm::dvec3 along{0.0, 1, 0.0};  ///< the axis, a unit vector
    Ring from{}, to{};              ///< of a ball its radius stands in `from`, and no more
    bool is_ball = false;
    SolidMaterial material;
};

/// A point of the thread that a finger leaves. World, scene units.
struct ThreadPoint {
    glm::dvec3 at{0.0};
    double radius = 0;
    glm::vec3 light{1.0F};
    bool is_joined = false;  ///< to the point before
};

/// The soft shadow of a ball on the surface it touches, or is above. World, scene units.
struct BallShadow {
    glm::dvec3 centre{0.0};
    double reach = 0;
    float darkness = 0;  ///< in its middle, 0 to 1
};

/// The shadow of a finger: on the surface under it, away from the light, the farther the higher the finger
/// is, and then the wider and the fainter. It closes in to 1.5 radii and 0.75 where the finger touches; a
/// radius above it is 2.5 radii wide, 0.34 dark, and 1.2 radii aside.
BallShadow shadow_of(const FingerMark& finger, double radius);

/// What fingers are drawn as, by any painter, in this order.
struct FingerShapes {
    std::vector<BallShadow> shadows;
    std::vector<ThreadPoint> threads;  ///< one after the other
    std::vector<Solid> solids;
    std::vector<Solid> veils;  ///< seen through: all rods before all balls
};

/// Every finger: its proxy as a ball in its colour, the goal as a bubble seen through what hides it, a rod
/// between them, the force on the finger as an arrow, and the trail as a thread that thins with age.
/// As seen from `eye`: how thick an arrow is depends on it, but neither its direction nor its length.
/// `shapes` is written anew.
void shape_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const glm::dvec3& eye,
                   FingerShapes& shapes);

/// Draws them, and first the dents that they make (SurfaceDent).
void draw_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const ViewCamera& camera,
                  LightPicture& picture);

/// A place of the surface that a finger takes along (shaders/dents.h): into it, a dent, and along it, which
/// stretches what is around. World, scene units.
struct SurfaceDent {
    glm::dvec3 centre{0.0}, normal{0.0}, moved{0.0};
    double reach = 0;
};

/// The dents of the fingers that touch and whose surface gives way (FingerMark::given_way). What is drawn
/// ends at `most_dented` of a finger's radius. `dents` is written anew.
inline constexpr double dent_reach = 2.6, most_dented = 1.3;  // radii of a finger
void shape_dents(std::span<const FingerMark> fingers, const MarkSizes& sizes,
                 std::vector<SurfaceDent>& dents);

/// What all dents together do to a place of the surface; nothing where none reaches it.
struct DentedPlace {
    glm::vec3 moved{0.0F}, normal_before{0.0F}, normal{0.0F};
};
std::optional<DentedPlace> dented(std::span<const SurfaceDent> dents, const glm::dvec3& place);

/// Draws them into a picture of the surface alone: the plain twin of DentDrawing and DentPatches.
void draw_dents(std::span<const SurfaceDent> dents, const ViewCamera& camera, LightPicture& picture);

}  // namespace touchable
