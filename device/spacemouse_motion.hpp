#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

namespace touchable {

/// How a puck that is pushed moves a finger.
struct SpaceMousePace {
    double speed = 0.1;   ///< m/s, of a puck that is pushed as far as it goes
    double reach = 0.08;  ///< m to each side of the centre, where the finger stops
};

/// Where a finger is that a puck pushes: it has a velocity as long as the puck is deflected. Device metres,
/// axes as HapticDevice has them. Times are nanoseconds, and do not go back.
class SpaceMouseMotion {
public:
    static constexpr double full_deflection = 350;  ///< counts
    static constexpr double dead_zone = 0.05;       ///< of it, in any direction: no hand rests on it evenly
    static constexpr std::int64_t released_ns = 200'000'000;  ///< without a word a puck is at rest

    SpaceMouseMotion(const SpaceMousePace& pace, std::int64_t now_ns) : pace_(pace), now_ns_(now_ns) {}

    /// The puck is deflected so from now on, as its report counts (x right, y towards the person, z down).
    void deflect(const glm::ivec3& counts, std::int64_t now_ns);
    /// Where the finger has come to.
    glm::dvec3 place(std::int64_t now_ns);

private:
    SpaceMousePace pace_;
    glm::dvec3 place_{0.0};
    glm::dvec3 velocity_{0.0};
    std::int64_t now_ns_;       // of `place_`
    std::int64_t told_ns_ = 0;  // of `velocity_`
};

}  // namespace touchable
