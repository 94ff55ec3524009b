// SPDX-License-Identifier: Apache-2.0
#include "bench/targets.hpp"

namespace touchable {
namespace {

using Names = std::vector<std::string>;

const Names up_to_full_hd{"320x240", "720x480", "1280x720", "1920x1080"};

/// <scene>-<size>-<rest> for each size and each of `rests`.
Names cases_of(const std::string& scene, const Names& sizes, const Names& rests) {
    Names names;
    for (const std::string& size : sizes)
        for (const std::string& rest : rests) names.push_back(scene + "-" + size + "-" + rest);
    return names;
}

Names both(Names a, const Names& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

std::vector<Target> make_touch_targets() {
    std::vector<Target> targets;
    const auto add = [&](const char* what, Names cases, const char* metric, Limit limit,
                         std::string relative_to = "") {
        targets.push_back({what, std::move(cases), metric, std::move(limit), std::move(relative_to)});
    };
    using Sense = Limit::Sense;
    const auto below = [](double value, const char* unit) { return Limit{value, Sense::below, unit}; };
    const auto at_most = [](double value, const char* unit) { return Limit{value, Sense::at_most, unit}; };

    const std::string small = "bumps-320x240-16-1f-world", huge = "bumps-3840x2160-16-1f-world";
    const Names bumps = cases_of("bumps", up_to_full_hd, {"16-1f-world"});
    // In dependent square roots: within the run, and as fast as the clock.
    add("tick, bumps, to 1920x1080, mean, in roots", bumps, "tick_roots", below(90, ""));
    add("tick, bumps, to 1920x1080, p99", bumps, "tick_roots_p99", below(220, ""));
    add("a cell, 3840x2160 over 320x240", {huge}, "cell_roots", at_most(1, ""), small);
    add("tick of 5 fingers, 1920x1080, mean", {"bumps-1920x1080-16-5f-world"}, "tick_roots", below(500, ""));
    add("tick of 10 fingers, 1920x1080, mean", {"bumps-1920x1080-16-10f-world"}, "tick_roots",
        below(1000, ""));
    add("new frame, to the solver", cases_of("moving", up_to_full_hd, {"16-1f-world-frames"}),
        "new_frame_roots", below(100, ""));

    const std::string sharp = "globe-1920x1080-16-1f-world", coarse = "globe-720x480-16-1f-world";
    add("force direction, globe, 1920x1080", {sharp}, "force_angle_deg_rms", below(1.2, "deg"));
    add("  less than 45 deg from the axis", {sharp}, "force_angle_deg_rms_0_45", below(0.65, "deg"));
    add("force direction, globe, 720x480", {coarse}, "force_angle_deg_rms", below(2.2, "deg"));

    const Names proven{sharp + "-proven", coarse + "-proven"};
    add("  from long double's, globe, same basin", proven, "reference_angle_deg_max", below(1e-7, "deg"));

    const Names follow{"16-1f-world-follow-0.05", "16-1f-world-follow-0.1", "16-1f-world-follow-0.3"};
    const Names bumps_runs = cases_of("bumps", up_to_full_hd, follow);
    const Names moving_runs = cases_of("moving", up_to_full_hd, follow);
    add("off the surface, bumps, 0.05-0.3 m/s", bumps_runs, "off_surface_pct", at_most(0, "%"));
    add("off the surface, moving, 0.05-0.3 m/s", moving_runs, "off_surface_pct", at_most(0, "%"));
    add("contact lost, bumps and moving", both(bumps_runs, moving_runs), "contact_lost_ticks",
        at_most(0, "ticks"));

    const Names rough =
        cases_of("rough", up_to_full_hd,
                 {"16-1f-world-proven-0.05", "16-1f-world-proven-0.1", "16-1f-world-proven-0.3"});
    add("rough, 0.05-0.3 m/s: no minimum", rough, "non_minima_ticks", at_most(0, "ticks"));
    add("  fallen through", rough, "tunnelled_ticks", at_most(0, "ticks"));
    add("  |P - G| over long double's", rough, "distance_over_reference_max", at_most(1.0001, ""));

    add("energy of a loop over what holding gives", {sharp, coarse}, "energy_held_over_bound",
        at_most(1, ""));
    add("energy of a loop, holding left out", {sharp, coarse}, "energy_created_mj_max", at_most(0, "mJ"));
    return targets;
}

}  // namespace

const std::vector<Target>& touch_targets() {
    static const std::vector<Target> targets = make_touch_targets();
    return targets;
}

}  // namespace touchable
