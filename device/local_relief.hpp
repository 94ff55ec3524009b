#pragma once

#include <array>
#include <glm/vec2.hpp>

#include "device/surface_search.hpp"

namespace touchable {

/// The ground about a finger that glides.
struct LocalRelief {
    enum class Kind {
        smooth,
        rough,  ///< it bends sharply within reach, as at a step: what presses there may be held
        broken  ///< the surface ends within reach, at a cliff up or down or at a hole
    };
    Kind kind;
    double highest;  ///< least planar depth within reach, scene units
};

/// Looks about a finger, as a person does who lifts it over a step they see coming.
class LocalReliefSearch {
public:
    /// Looks `reach` device metres, > 0, to every side, and at pixels of `box` alone: no finger goes
    /// elsewhere.
    LocalReliefSearch(double reach, double metres_per_scene_unit, const PixelBox& box);

    /// At `pixel` of the box, where the finger takes the surface to be at planar depth `depth`.
    LocalRelief about(const glm::dvec2& pixel, double depth, const SurfaceProbe& probe) const;

private:
    static constexpr int directions = 12;  // even: they pair up

    std::array<glm::dvec2, directions> directions_;  // unit length, x right, y down
    double reach_;
    double metres_per_scene_unit_;
    PixelBox box_;
};

/// Device metres that one pixel spans at `depth`, across and down.
glm::dvec2 pixel_size(const SurfaceProbe& probe, const glm::dvec2& pixel, double depth,
                      double metres_per_scene_unit);

}  // namespace touchable
