#include "tests/stress/suites.hpp"

#include <algorithm>
#include <array>

#include "engine/content/seeded_noise.hpp"

namespace touchable::stress {

namespace {

constexpr Needs some_contact{};
constexpr Needs little_contact{0.02};

constexpr std::array<Suite, 24> all_suites{{
    {"uniform-noise", "every pixel for itself over the whole range", make_uniform_noise, some_contact},
    {"checkerboard", "cliffs from near to far, 1 to 3 pixels apart", make_checkerboard, some_contact},
    {"staircase", "ramps of single codes", make_staircase, some_contact},
    {"spike-and-pit", "single pixels out of and into a flat ground, crossed fast", make_spike_and_pit,
     some_contact},
    {"lattice-lines", "goals exactly along each kind of edge and through vertices, and 1 ulp beside",
     make_lattice_lines, little_contact},
    {"camera-axis", "goals on the axis, in the camera and behind it", make_camera_axis, little_contact},
    {"far-goals", "goals a million units away and farther", make_far_goals, little_contact},
    {"corner-jumps", "goals that jump between the corners of the frustum", make_corner_jumps, little_contact},
    {"tiny-pictures", "pictures of 1 and 2 pixels a side", make_tiny_pictures, little_contact},
    {"height-limit", "heights of which a thousandth of the nearest depth is left", make_height_limit,
     some_contact},
    {"impossible-planes",
     "planes that are equal, negative or swapped are refused; all but equal ones touched",
     make_impossible_planes,
     {0.05, false, true}},
    {"not-finite", "depths and goals that are no numbers", make_not_finite, {0.05, false, false, true}},
    {"rising", "a surface that rises past the finger by 1 to 255 levels a tick", make_rising, {0.05, true}},
    {"cut-every-frame", "every frame is another picture", make_cut_every_frame, {0.15, true}},
    {"late-frames",
     "frames that come late, not at all, or of another size",
     make_late_frames,
     {0.15, true, true}},
    {"far-million", "planes at 1 and 1e6", make_far_million, little_contact},
    {"wide-planes", "near down to a millionth of far, in units from tiny to huge", make_wide_planes,
     little_contact},
    {"camera-plane", "near down to a millionth of far, and goals of every length through the camera's plane",
     make_camera_plane, little_contact},
    {"plateau", "flat grounds, pyramids and valleys with goals as far from all sides", make_plateau,
     some_contact},
    {"press-slide-retract", "loops in, along and out, both ways", make_press_slide_retract, some_contact},
    {"stiffness-boundary", "loops over a border between 0.1 and 10 N/mm", make_stiffness_boundary,
     some_contact},
    {"encoder-dither", "a hand at rest whose encoders flicker by one count", make_encoder_dither,
     some_contact},
    {"five-fingers", "five fingers at one point", make_five_fingers, some_contact},
    {"stopped-producer",
     "frames that stop coming under a moving, then a resting hand",
     make_stopped_producer,
     {0.15, true}},
}};

}  // namespace

std::unique_ptr<StressRun> Suite::run(std::uint64_t seed) const {
    std::uint64_t drawn = seed;
    for (const char letter : name) drawn = mix64(drawn ^ static_cast<std::uint64_t>(letter));
    return make(drawn);
}

std::span<const Suite> suites() {
    return all_suites;
}

const Suite* find_suite(std::string_view name) {
    const auto found = std::find_if(all_suites.begin(), all_suites.end(),
                                    [&](const Suite& suite) { return suite.name == name; });
    return found == all_suites.end() ? nullptr : &*found;
}

}  // namespace touchable::stress
