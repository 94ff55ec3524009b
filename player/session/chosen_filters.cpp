// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "engine/base/hand_thresholds.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

Result<ChosenFilters> measure_depth(std::unique_ptr<ClipReader>& reader, const Scene& scene) {
    DepthEstimator estimator(scene);
    Prefetch ahead(std::move(reader));
    ChosenFilters measured;
    for (bool is_first = true; !estimator.enough(); is_first = false) {
        if (stop_requested()) return interrupted_error();
        const auto frame = ahead.next();
        if (!frame && (is_first || frame.error().kind == ErrorKind::interrupted)) return frame.error();
        if (!frame) measured.damage = frame.error().message;
        if (!frame || !*frame) break;
        estimator.add(**frame);
    }
    TRY_ASSIGN(reader, ahead.finish());
    measured.measured = estimator.measured();
    if (stop_requested()) return interrupted_error();
    return measured;
}

Result<std::optional<ChosenFilters>> settle_filters(std::unique_ptr<ClipReader>& reader,
                                                    const UnstatedFilters& unstated, Scene& scene,
                                                    const std::optional<ChosenFilters>& known) {
    if (!needs_measuring(unstated, scene)) return std::optional<ChosenFilters>();
    const bool automatic = scene.filter.terraces == TerraceRemoval::automatic;
    TRY_ASSIGN(auto chosen, known ? Result<ChosenFilters>(*known) : measure_depth(reader, scene));
    chosen.chosen = unstated;
    chosen.chosen.terraces = unstated.terraces || automatic;
    TRY(settle_filters(chosen.measured, unstated, scene));
    return std::optional(std::move(chosen));
}

namespace {

std::string number(double value, const char* unit) {
    return formatted("%.3g%s", value, unit);
}

std::string mm(double length, double metres_per_unit) {
    return number(1000 * length * metres_per_unit, " mm");
}

std::string share(double of_pixels, const char* what) {
    return number(100 * of_pixels, " % of the pixels ") + what;
}

std::string where_it_is(const MeasuredDepth& measured, double metres_per_unit) {
    return mm(measured.distance, metres_per_unit) + " apart at " +
           number(measured.median * metres_per_unit, " m");
}

std::string noise_found(const MeasuredDepth& measured, double metres_per_unit) {
    if (measured.frames < 3) return "not known of fewer than 3 frames";
    return measured.noise == DepthLength{} ? "none found" : mm(measured.noise_at_median(), metres_per_unit);
}

/// Reason for the choice of median: roughness (mm, share of a pixel's width), whether filters were tried.
std::string median_reason(const MeasuredDepth& measured, double metres_per_unit) {
    std::string reason = "roughness " + mm(measured.roughness, metres_per_unit);
    if (measured.pixel > 0)
        reason += ", " + number(measured.roughness / measured.pixel, " of a pixel's width");
    return measured.is_searched() ? reason : reason + ", no sign of a camera";
}

std::string contours_found(const Contours& contours) {
    std::string words = "terraces are " + std::to_string(contours.width) + " pixels wide";
    if (contours.height > 1) words += " and " + std::to_string(contours.height) + " codes high";
    return words;
}

/// The level spacing that terrace removal uses, if it differs from the measured one.
std::string removal_reason(const MeasuredDepth& measured, const FilterSettings& filter,
                           double metres_per_unit) {
    if (filter.terraces == TerraceRemoval::on && filter.terrace_reach != least_terrace_reach &&
        measured.contours.are_wide())
        return contours_found(measured.contours) + ", codes " + where_it_is(measured, metres_per_unit);
    const bool is_wider = filter.terraces == TerraceRemoval::on && filter.levels != measured.levels;
    return "levels " + where_it_is(measured, metres_per_unit) +
           (is_wider ? ", noise and all " + mm(filter.levels.at(measured.median), metres_per_unit) : "");
}

/// Effect of these filters on the clip's smooth places.
std::string effect_in_words(const MeasuredDepth& measured, const FilterSettings& filter) {
    const TriedFilters* const with = found_among(measured.tried, filter);
    const TriedFilters* const without = found_among(measured.tried, {});
    if (!with || !without || with == without) return "";
    return "; smooth places lean " + number(with->left_deg, "") + " degrees to and fro (" +
           direction_jnd_words(with->left_deg) + "), " + number(without->left_deg, " as stored");
}

std::string trust_in_words(const MeasuredDepth& measured, const Scene& scene) {
    const auto to = measured.trusted_to(scene.filter);
    if (!to) return "";
    return (*to > 0 ? "; beyond " + number(*to * scene.metres_per_unit, " m ") : "; ") + not_trusted_words;
}

/// `depth`: depth at which the noise is stated, scene units; 0: unknown.
std::string temporal_name(const Scene& scene, double depth) {
    if (!scene.filter.temporal) return "temporal";
    const DepthLength& noise = scene.filter.temporal_noise;
    if (depth > 0 || noise.quadratic == 0)
        return "temporal for " + mm(noise.at(depth), scene.metres_per_unit);
    return "temporal for " + number(noise.constant, " + ") + number(noise.quadratic, " depth^2 units");
}

std::string terraces_name(const FilterSettings& filter) {
    if (filter.terraces != TerraceRemoval::on || filter.terrace_reach == least_terrace_reach)
        return "terraces";
    return "terraces within " + std::to_string(filter.terrace_reach) + " pixels";
}

std::string flying_reason(const MeasuredDepth& measured) {
    const std::string flying = share(measured.flying, "hang between surfaces");
    if (measured.from_a_camera() || measured.clean_edges == 0) return flying;
    return flying + ", " + share(measured.clean_edges, "are beside clean edges");
}

}  // namespace

std::string filters_in_words(const Scene& scene, const std::optional<ChosenFilters>& chosen) {
    const bool known = chosen && chosen->measured, cut = chosen && !chosen->damage.empty();
    const std::string damage = cut ? "; chosen by the frames before damage: " + chosen->damage : "";
    const MeasuredDepth measured = known ? *chosen->measured : MeasuredDepth{};
    const UnstatedFilters by = known ? chosen->chosen : UnstatedFilters{};
    const FilterSettings& filter = scene.filter;
    const double unit = scene.metres_per_unit;
    const std::string side = std::to_string(filter.median);
    std::vector<std::string> on, off;
    const auto add = [&](bool is_on, bool is_chosen, const std::string& name, const std::string& why) {
        const std::string words = name + " (" + (is_chosen ? why : "stated") + ")";
        if (is_on)
            on.push_back(words);
        else if (is_chosen)
            off.push_back("no " + words);
    };
    add(filter.flying_pixels != DepthLength{}, by.flying_pixels, "flying pixels", flying_reason(measured));
    add(filter.fill_holes > 0, by.fill_holes, "hole filling", share(measured.tiny_holes, "are tiny holes"));
    add(filter.median > 0, by.median, filter.median > 0 ? "median " + side + "x" + side : "median",
        median_reason(measured, unit));
    add(filter.temporal, by.temporal, temporal_name(scene, measured.median),
        "noise " + noise_found(measured, unit));
    const bool is_reach_chosen = by.terrace_reach && filter.terrace_reach != least_terrace_reach;
    add(filter.terraces == TerraceRemoval::on, by.terraces || is_reach_chosen, terraces_name(filter),
        removal_reason(measured, filter, unit));
    if (known && by == all_unstated && on.empty())
        return "none needed (levels " + where_it_is(measured, unit) + ", noise " +
               noise_found(measured, unit) + ", " + median_reason(measured, unit) + ")" + damage;
    std::string words = on.empty() && off.empty() ? "none (stated)" : on.empty() ? "none: " : listed(on);
    if (!off.empty()) words += (on.empty() ? "" : "; ") + listed(off);
    return words + effect_in_words(measured, filter) + trust_in_words(measured, scene) +
           (chosen && !known ? "; no pixel of the first frames is valid" : "") + damage;
}

std::string levels_in_words(const MeasuredDepth& measured, double metres_per_unit) {
    return where_it_is(measured, metres_per_unit) + " (kappa " + number(measured.kappa, ")");
}

std::string noise_in_words(const MeasuredDepth& measured, double metres_per_unit) {
    std::string words = noise_found(measured, metres_per_unit);
    if (measured.noise != DepthLength{}) words += " from frame to frame";
    if (measured.noise_at_edges > 0)
        words += ", " + mm(measured.noise_at_edges, metres_per_unit) + " at edges";
    if (measured.noise_at_rims > 0)
        words += ", " + mm(measured.noise_at_rims, metres_per_unit) + " beside holes";
    words += "; roughness from pixel to pixel " + mm(measured.roughness, metres_per_unit);
    if (measured.dropouts > 0) words += "; " + share(measured.dropouts, "drop out for a frame");
    if (measured.flying > 0) words += "; " + share(measured.flying, "hang between surfaces");
    if (measured.tiny_holes > 0) words += "; " + share(measured.tiny_holes, "are tiny holes");
    return words;
}

}  // namespace touchable
