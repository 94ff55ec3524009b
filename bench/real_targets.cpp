// SPDX-License-Identifier: Apache-2.0
#include "bench/targets.hpp"

namespace touchable {
namespace {

std::vector<Target> make_real_targets(const std::string& choice) {
    using Sense = Limit::Sense;
    const auto named = [&](const char* what) { return std::string("real-") + what + "-" + choice; };
    const auto below = [](double value, const char* unit) { return Limit{value, Sense::below, unit}; };
    const auto at_most = [](double value, const char* unit) { return Limit{value, Sense::at_most, unit}; };
    const std::string kinect = named("icl-kinect");
    const std::vector<std::string> edges{named("edges-kinect"), named("edges-d435")};
    std::vector<std::string> drawn, drawn_edges;
    const std::vector<std::string> kinds{"real-models-drawn", "real-models-kinds"};
    for (int number = 1; number <= 8; ++number) {
        drawn.push_back("real-search-drawn" + std::to_string(number));
        drawn_edges.push_back(named(("edges-drawn" + std::to_string(number)).c_str()));
    }
    const std::string lone = named("relief-lone");
    // Demonstration 3 has the forces of another hand, and what 2 wipes is no plane.
    const std::vector<std::string> over_plane{"real-wiping-0", "real-wiping-1"};
    const std::vector<std::string> wiping{"real-wiping-0", "real-wiping-1", "real-wiping-2"};
    const std::vector<std::string> bars{"real-error-bars"};
    const std::vector<std::string> coarse{"real-others-redwood", "real-others-kinect", "real-others-d435"};
    const auto at_least = [](double value, const char* unit) { return Limit{value, Sense::at_least, unit}; };
    return {
        {"direction, cube, RMS", {named("cube")}, "force_angle_deg_rms", below(5, "deg")},
        {"direction, redwood, RMS", {named("redwood")}, "force_angle_deg_rms", below(6, "deg")},
        {"direction, known room, Kinect, RMS", {kinect}, "force_angle_deg_rms", below(6, "deg")},
        {"at rest, 20 to 500 Hz, Kinect", {kinect}, "force_band_mn", at_most(40, "mN")},
        {"behind at 0.3 m/s, Kinect", {kinect}, "lag_mm", at_most(1.5, "mm")},
        {"CPU time of a frame, 640x480", {kinect}, "frame_cpu_ms", at_most(1.5, "ms")},
        {"relief of a pen of 5 pixels", edges, "pen_pct", at_least(90, "%")},
        {"a step of 4 levels, one level off its sides", edges, "step_px", at_most(1, "px")},
        {"between forms of the same depth",
         {"real-forms-cube", "real-forms-redwood"},
         "forms_apart_deg",
         at_most(0.5, "deg")},
        {"relief of a pen of 4 levels, drawn models", drawn_edges, "low_pen_pct", at_least(95, "%")},
        {"a step of 4 levels, drawn models", drawn_edges, "step_px", at_most(1, "px")},
        {"direction, drawn models, RMS", drawn, "force_angle_deg_chosen", at_most(6, "deg")},
        {"direction, over the best of a search", drawn, "times_best", at_most(1.2, "")},
        {"chosen again, over the first choice",
         {"real-again-windows3", "real-again-windows5", "real-again-windows7"},
         "most_times_first",
         at_most(1.2, "")},
        {"models, films within 1.3 of the best",
         {"real-models-drawn"},
         "film_nearly_best_pct",
         at_least(90, "%")},
        {"models, stills within 1.3 of the best",
         {"real-models-drawn"},
         "still_nearly_best_pct",
         at_least(90, "%")},
        {"models, films over none", kinds, "film_most_times_off", at_most(1.02, "")},
        {"models, stills over none", kinds, "still_most_times_off", at_most(1.02, "")},
        {"models, points from detailed to smooth", {"real-models-drawn"}, "least_details", at_least(5, "")},
        {"recordings, points from detailed to smooth",
         {"real-detail-cube", "real-detail-castel", "real-detail-redwood", "real-detail-azure"},
         "points",
         at_least(5, "")},
        {"far room, trusted forces over 20 degrees",
         {named("icl-far")},
         "trusted_over_20deg_pct",
         at_most(0.7, "%")},
        {"far room, models trusted rightly", {"real-models-far"}, "trust_is_right_pct", at_least(80, "%")},
        {"far room, forces not to be trusted", {named("icl-far")}, "untrusted_pct", at_most(25, "%")},
        {"lone pixels, faces over 20 degrees", {lone}, "over_20deg_pct", at_most(0.7, "%")},
        {"lone pixels, direction, RMS", {lone}, "face_angle_deg_rms", at_most(5, "deg")},
        {"low pen of 30 mm, coarse light", {named("relief-coarse")}, "low_pen_pct", at_least(70, "%")},
        {"low pen of 8 mm, time of flight", {named("relief-azure")}, "low_pen_pct", at_least(80, "%")},
        {"direction, half floats, RMS",
         {named("relief-half-0.5m"), named("relief-half-1m"), named("relief-half-2m")},
         "face_angle_deg_rms",
         at_most(1.5, "deg")},
        {"error bars of direction, cameras with 92 to 98 %", bars, "direction_fit_right_pct",
         at_least(90, "%")},
        {"  of direction, the least share", bars, "direction_fit_least_pct", at_least(85, "%")},
        {"  of direction, width over the best constant bar", bars, "direction_width", at_most(0.8, "")},
        {"  of direction, correlation with the errors", bars, "direction_rank", at_least(0.4, "")},
        {"error bars of size, cameras with 92 to 98 %", bars, "size_fit_right_pct", at_least(90, "%")},
        {"  of size, the least share", bars, "size_fit_least_pct", at_least(85, "%")},
        {"hands that wipe a plane, direction, median", over_plane, "force_angle_deg_median",
         at_most(7, "deg")},
        {"hands that wipe a plane, by others' friction", over_plane, "force_angle_others_deg_median",
         at_most(8, "deg")},
        {"hands that wipe, less the surface's shape", wiping, "force_angle_shaped_deg_median",
         at_most(4, "deg")},
        {"hands that wipe, friction behind the motion", wiping, "against_motion_exerted_deg_median",
         at_most(5, "deg")},
        {"hands that wipe, contact lost", wiping, "contact_lost_ticks", at_most(0, "")},
        {"filtered depth, CPU time of a frame, 640x480",
         {"real-others-cube", "real-others-castel", "real-others-redwood", "real-others-kinect",
          "real-others-d435", "real-others-sr300"},
         "ours_cpu_ms",
         at_most(4, "ms")},
        {"librealsense's error over ours, equal relief", coarse, "rs_times", at_least(3, "")},
        {"bilateral filter's error over ours, the same", coarse, "cv_times", at_least(3, "")},
        {"on neither side of a silhouette", edges, "bleed_px", at_most(0, "px")},
        {"generated clips of 16 bits, changed", {named("generated")}, "changed_pct", at_most(0, "%")}};
}

}  // namespace

const std::vector<Target>& real_targets() {
    static const std::vector<Target> targets = make_real_targets("chosen");
    return targets;
}

}  // namespace touchable
