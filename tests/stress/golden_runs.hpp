#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "tests/stress/stress_run.hpp"

namespace touchable::stress {

/// Which builder makes the frames of a golden run; the forces are the same.
enum class GoldenBuilder { cpu, lazy };

/// A generated scene and a hand over it whose forces are known to the bit: with every compiler, at every
/// level of optimisation, under sanitizers, on every machine.
struct GoldenRun {
    std::string_view name, force_hash;
    std::string_view scene, hand;  ///< of make_scene; "stroke", "walk" or "skim"
    int bits = 16;
    int fingers = 1;
    TouchMetric metric = TouchMetric::world;
    double friction = 0;      ///< static; dynamic is two thirds of it
    bool properties = false;  ///< heights and a haptic image (globe)
    int median = 0;
    FrameInterpolation interpolation = FrameInterpolation::linear;
    double hole_stiffness = 0;  ///< N/mm; above 0 the middle code of the depth is invalid

    static constexpr std::int64_t ticks = 1500;
    std::unique_ptr<StressRun> make(GoldenBuilder builder) const;
};

std::span<const GoldenRun> golden_runs();
/// A name as GoogleTest takes it.
inline std::string name_of_test(std::string_view name) {
    std::string taken(name);
    std::replace(taken.begin(), taken.end(), '-', '_');
    return taken;
}
const GoldenRun* find_golden_run(std::string_view name);

}  // namespace touchable::stress
