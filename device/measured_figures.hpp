#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace touchable {

/// Of many values; percentiles are values that were there (nearest rank). All 0 where there were none.
struct Percentiles {
    std::int64_t count = 0;
    double median = 0, p99 = 0, greatest = 0;
};
Percentiles percentiles_of(std::vector<double> values);

/// From each moment to the next, s.
std::vector<double> intervals_between(std::span<const std::int64_t> times_ns);

/// From each moment to the first of `others` that is not earlier, s, where that comes before the next moment
/// does; both lists rise.
std::vector<double> until_the_next(std::span<const std::int64_t> times_ns,
                                   std::span<const std::int64_t> others_ns);

/// A handle that is left alone, or is meant to be.
struct RestFigures {
    static constexpr double moved_m = 0.0005;

    std::int64_t places = 0;
    glm::dvec3 deviation_m{0.0};  ///< standard deviation along each axis
    glm::dvec3 step_m{0.0};       ///< smallest change from a place to the next; 0: it never changed
    double farthest_m = 0;        ///< from the mean place
    bool moved() const { return farthest_m > moved_m; }  ///< then deviations tell of the hand
};
/// Of finite places, one after the other.
RestFigures rest_of(std::span<const glm::dvec3> metres);

}  // namespace touchable
