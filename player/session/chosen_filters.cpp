#include "player/session/chosen_filters.hpp"

#include <cstddef>
#include <cstdlib>
#include <utility>
#include <vector>

#include "engine/surface/filter_choice.hpp"
#include "player/session/frames_in_hand.hpp"
#include "player/session/interrupt.hpp"

namespace touchable {
namespace {

/// Frames that were looked at are kept to be played, up to so many bytes: 25 of 1920x1080 with all planes.
constexpr std::size_t most_bytes_in_hand = std::size_t{512} << 20;

std::size_t bytes_of(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += static_cast<std::size_t>(std::abs(plane->stride)) * static_cast<std::size_t>(plane->height);
    return bytes;
}

}  // namespace

Result<MeasuredFrames> measure_depth(std::unique_ptr<ClipReader>& reader, const Scene& scene,
                                     const std::stop_token& given_up) {
    DepthSurvey survey(scene);
    std::vector<RawFrame> seen;
    std::size_t bytes = 0;
    std::string damage;
    while (!survey.enough()) {
        if (interrupted() || given_up.stop_requested()) return interrupted_error();
        const auto frame = reader->next();
        if (!frame.ok() && (bytes == 0 || frame.error().kind == ErrorKind::interrupted)) return frame.error();
        if (!frame.ok()) damage = frame.error().message;
        if (!frame.ok() || !*frame) break;
        survey.add(**frame);
        bytes += bytes_of(**frame);
        if (bytes <= most_bytes_in_hand) seen.push_back(**frame);
    }
    if (damage.empty() && bytes <= most_bytes_in_hand) {
        reader = with_frames_in_hand(std::move(reader), std::move(seen));
        return MeasuredFrames{survey.measured(), damage};
    }
    seen.clear();
    if (auto back = reader->rewind(); !back.ok()) return back.error();
    return MeasuredFrames{survey.measured(), damage};
}

Result<std::optional<ChosenFilters>> settle_filters(std::unique_ptr<ClipReader>& reader, Scene& scene,
                                                    const std::optional<MeasuredFrames>& known,
                                                    const std::stop_token& given_up) {
    const bool needs_levels =
        scene.filter.terraces != TerraceRemoval::off && scene.filter.levels == DepthLength{};
    const bool needs_noise = scene.filter.temporal && scene.filter.temporal_noise == DepthLength{};
    const bool automatic = scene.filter.terraces == TerraceRemoval::automatic;
    ChosenFilters chosen{scene.unstated, {}};
    chosen.chosen.terraces = chosen.chosen.terraces || automatic;
    if (!chosen.chosen.any() && !needs_levels && !needs_noise) return std::optional<ChosenFilters>();
    auto measured = known ? Result<MeasuredFrames>(*known) : measure_depth(reader, scene, given_up);
    if (!measured.ok()) return measured.error();
    choose_filters(measured->depth, scene);
    if (scene.filter.temporal && scene.filter.temporal_noise == DepthLength{})
        return usage_error(
            "the temporal filter is to be on, but the scene does not say how noisy its depth is, and its "
            "first frames show no "
            "noise; right would be that noise in scene units, such as --temporal 1.5");
    if (auto valid = validate(scene); !valid.ok()) return usage_error(valid.error().message);
    chosen.measured = measured->depth;
    chosen.damage = measured->damage;
    return std::optional(chosen);
}

}  // namespace touchable
