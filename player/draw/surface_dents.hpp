#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "player/draw/finger_marks.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/view_camera.hpp"
#include "shaders/dents.h"

namespace touchable {

/// How far a surface gives way under a finger, scene units: as a spring of `stiffness` (N/m of the hand) does
/// to the force on the finger, N, in the hand's scale (`metres_per_scene_unit`, S of the Workspace). Zero
/// where there is no such spring.
glm::dvec3 given_way(const glm::dvec3& force, double stiffness, double metres_per_scene_unit);

/// A place of the surface that a finger takes along (shaders/dents.h): into it, a dent, and along it, which
/// stretches what is around. World, scene units.
struct SurfaceDent {
    glm::dvec3 centre{0.0}, normal{0.0}, moved{0.0};
    double reach = 0;
};

/// Of the fingers that touch and whose surface gives way (FingerMark::given_way). What is drawn ends at
/// `most_dented` of a finger's radius. `dents` is written anew.
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
