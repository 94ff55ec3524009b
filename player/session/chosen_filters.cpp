#include "player/session/chosen_filters.hpp"

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "engine/surface/filter_choice.hpp"
#include "player/session/frames_in_hand.hpp"
#include "player/session/interrupt.hpp"

namespace touchable {
namespace {

std::string number(double value, const char* unit) {
    char words[48];
    std::snprintf(words, sizeof words, "%.3g %s", value, unit);
    return words;
}

std::string mm(double length, double metres_per_unit) {
    return number(1000 * length * metres_per_unit, "mm");
}

std::string joined(const std::vector<std::string>& parts) {
    std::string words;
    for (const std::string& part : parts) words += (words.empty() ? "" : ", ") + part;
    return words;
}

/// Frames that were looked at are kept to be played, up to so many bytes: 25 of 1920x1080 with all planes.
constexpr std::size_t most_bytes_in_hand = std::size_t{512} << 20;

std::size_t bytes_of(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += static_cast<std::size_t>(std::abs(plane->stride)) * static_cast<std::size_t>(plane->height);
    return bytes;
}

std::string pct(double share) {
    return number(100 * share, "% of the pixels");
}

}  // namespace

std::string levels_in_words(const MeasuredDepth& measured, double metres_per_unit) {
    char kappa[32];
    std::snprintf(kappa, sizeof kappa, " (kappa %.3g)", measured.kappa);
    return "levels " + mm(measured.distance, metres_per_unit) + " apart at " +
           number(measured.median * metres_per_unit, "m") + kappa;
}

std::string noise_in_words(const MeasuredDepth& measured, double metres_per_unit) {
    const auto length = [&](double units) { return mm(units, metres_per_unit); };
    std::string words = "none found from frame to frame";
    if (measured.noise != DepthLength{}) {
        words = length(measured.noise_at_median()) + " from frame to frame";
        if (measured.noise_at_edges > 0) words += ", " + length(measured.noise_at_edges) + " at edges";
        if (measured.noise_at_rims > 0) words += ", " + length(measured.noise_at_rims) + " beside holes";
    }
    words += "; " + length(measured.roughness) + " from pixel to pixel";
    if (measured.dropouts > 0) words += "; " + pct(measured.dropouts) + " drop out for a frame";
    if (measured.flying > 0) words += "; " + pct(measured.flying) + " hang in the air";
    if (measured.specks > 0) words += "; " + pct(measured.specks) + " are tiny holes";
    return words;
}

std::string in_words(const ChosenFilters& chosen) {
    if (!chosen.measured) return "none: no pixel of the first frames is valid";
    const MeasuredDepth& measured = *chosen.measured;
    const FilterSettings& filters = chosen.filters;
    const auto length = [&](double units) { return mm(units, chosen.metres_per_unit); };
    const std::string levels = "levels " + length(measured.distance) + " apart at " +
                               number(measured.median * chosen.metres_per_unit, "m");
    std::vector<std::string> on, off;
    const auto say = [&](bool is_on, bool is_chosen, const std::string& name, const std::string& why) {
        if (is_on)
            on.push_back(name + (is_chosen ? " (" + why + ")" : ""));
        else if (is_chosen)
            off.push_back("no " + name);
    };
    const UnstatedFilters& by = chosen.chosen;
    const std::string side = std::to_string(filters.median);
    say(filters.median > 0, by.median, filters.median > 0 ? "median " + side + "x" + side : "median",
        length(measured.roughness) + " from pixel to pixel");
    say(filters.terraces == TerraceRemoval::on, by.terraces, "terraces", levels);
    say(filters.temporal, by.temporal, "temporal", "noise " + length(measured.noise_at_median()));
    say(filters.flying_pixels != DepthLength{}, by.flying_pixels, "flying pixels pulled in",
        pct(measured.flying) + " hang in the air");
    say(filters.fill_holes > 0, by.fill_holes, "hole filling", pct(measured.specks) + " are tiny holes");
    if (on.empty())
        return "none needed (" + levels + ", " +
               (measured.noise == DepthLength{} ? "no noise"
                                                : "noise " + length(measured.noise_at_median())) +
               ")";
    on.insert(on.end(), off.begin(), off.end());
    return joined(on) + "; --filters off for none";
}

Result<std::optional<MeasuredDepth>> measure_depth(std::unique_ptr<ClipReader>& reader, const Scene& scene) {
    DepthSurvey survey(scene);
    std::vector<RawFrame> seen;
    std::size_t bytes = 0;
    bool whole = true;
    while (!survey.enough()) {
        if (interrupted()) return interrupted_error();
        const auto frame = reader->next();
        if (!frame.ok() && bytes == 0) return frame.error();
        whole = frame.ok();
        if (!frame.ok() || !*frame) break;
        survey.add(**frame);
        bytes += bytes_of(**frame);
        if (bytes <= most_bytes_in_hand) seen.push_back(**frame);
    }
    // Whoever plays the clip will meet what is wrong there.
    if (whole && bytes <= most_bytes_in_hand) {
        reader = with_frames_in_hand(std::move(reader), std::move(seen));
        return survey.measured();
    }
    seen.clear();
    if (auto back = reader->rewind(); !back.ok()) return back.error();
    return survey.measured();
}

Result<std::optional<ChosenFilters>> settle_filters(std::unique_ptr<ClipReader>& reader, Scene& scene) {
    const bool needs_levels =
        scene.filter.terraces != TerraceRemoval::off && scene.filter.levels == DepthLength{};
    const bool needs_noise = scene.filter.temporal && scene.filter.temporal_noise == DepthLength{};
    const bool automatic = scene.filter.terraces == TerraceRemoval::automatic;
    ChosenFilters chosen{scene.unstated, {}, scene.metres_per_unit, {}};
    chosen.chosen.terraces = chosen.chosen.terraces || automatic;
    if (!chosen.chosen.any() && !needs_levels && !needs_noise) return std::optional<ChosenFilters>();
    auto measured = measure_depth(reader, scene);
    if (!measured.ok()) return measured.error();
    choose_filters(*measured, scene);
    if (scene.filter.temporal && scene.filter.temporal_noise == DepthLength{})
        return usage_error(
            "--temporal on: the scene does not say how noisy its depth is, and its first frames show no "
            "noise; right would be that noise in scene units instead of on, such as 1.5");
    if (auto valid = validate(scene); !valid.ok()) return usage_error(valid.error().message);
    chosen.measured = *measured;
    chosen.filters = scene.filter;
    return std::optional(chosen);
}

}  // namespace touchable
