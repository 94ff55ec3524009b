#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "tests/stress/stress_run.hpp"

namespace touchable::stress {

/// Coverage that a suite needs to be a test at all; share of all finger-ticks, or whether there has to be
/// any.
struct Needs {
    double contact = 0.1;
    bool frame_changes = false, refusals = false, held_goals = false;
};

/// A family of runs that is out to break the solver in one way; docs/paper.md lists them.
struct Suite {
    std::string_view name, what;
    std::unique_ptr<StressRun> (*make)(std::uint64_t seed);
    Needs needs;

    /// The suite's run of a seed; other suites draw other scenes from the same.
    std::unique_ptr<StressRun> run(std::uint64_t seed) const;
};

std::span<const Suite> suites();
/// nullptr for a name that is none.
const Suite* find_suite(std::string_view name);

// The makers, by what they stress.
std::unique_ptr<StressRun> make_uniform_noise(std::uint64_t seed);
std::unique_ptr<StressRun> make_checkerboard(std::uint64_t seed);
std::unique_ptr<StressRun> make_staircase(std::uint64_t seed);
std::unique_ptr<StressRun> make_spike_and_pit(std::uint64_t seed);
std::unique_ptr<StressRun> make_far_million(std::uint64_t seed);
std::unique_ptr<StressRun> make_wide_planes(std::uint64_t seed);
std::unique_ptr<StressRun> make_plateau(std::uint64_t seed);
std::unique_ptr<StressRun> make_tiny_pictures(std::uint64_t seed);

std::unique_ptr<StressRun> make_lattice_lines(std::uint64_t seed);
std::unique_ptr<StressRun> make_camera_axis(std::uint64_t seed);
std::unique_ptr<StressRun> make_far_goals(std::uint64_t seed);
std::unique_ptr<StressRun> make_corner_jumps(std::uint64_t seed);
std::unique_ptr<StressRun> make_five_fingers(std::uint64_t seed);
std::unique_ptr<StressRun> make_camera_plane(std::uint64_t seed);

std::unique_ptr<StressRun> make_height_limit(std::uint64_t seed);
std::unique_ptr<StressRun> make_impossible_planes(std::uint64_t seed);
std::unique_ptr<StressRun> make_not_finite(std::uint64_t seed);

std::unique_ptr<StressRun> make_rising(std::uint64_t seed);
std::unique_ptr<StressRun> make_cut_every_frame(std::uint64_t seed);
std::unique_ptr<StressRun> make_late_frames(std::uint64_t seed);
std::unique_ptr<StressRun> make_stopped_producer(std::uint64_t seed);

std::unique_ptr<StressRun> make_press_slide_retract(std::uint64_t seed);
std::unique_ptr<StressRun> make_stiffness_boundary(std::uint64_t seed);
std::unique_ptr<StressRun> make_encoder_dither(std::uint64_t seed);

}  // namespace touchable::stress
