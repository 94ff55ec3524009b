#include "player/session/chosen_filters.hpp"

#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/prefetch.hpp"
#include "engine/surface/filter_choice.hpp"
#include "player/run/interrupt.hpp"

namespace touchable {

Result<MeasuredFrames> measure_depth(std::unique_ptr<ClipReader>& reader, const Scene& scene,
                                     const std::stop_token& given_up) {
    DepthEstimator estimator(scene);
    Prefetch ahead(std::move(reader));
    std::string damage;
    for (bool is_first = true; !estimator.enough(); is_first = false) {
        if (interrupted() || given_up.stop_requested()) return interrupted_error();
        const auto frame = ahead.next();
        if (!frame.ok() && (is_first || frame.error().kind == ErrorKind::interrupted)) return frame.error();
        if (!frame.ok()) damage = frame.error().message;
        if (!frame.ok() || !*frame) break;
        estimator.add(**frame);
    }
    TRY_ASSIGN(auto clip, ahead.finish());
    reader = std::move(clip);
    MeasuredFrames measured{estimator.measured(), damage};
    if (interrupted() || given_up.stop_requested()) return interrupted_error();
    return measured;
}

Result<std::optional<ChosenFilters>> settle_filters(std::unique_ptr<ClipReader>& reader,
                                                    const UnstatedFilters& unstated, Scene& scene,
                                                    const std::optional<MeasuredFrames>& known,
                                                    const std::stop_token& given_up) {
    if (!needs_measuring(unstated, scene)) return std::optional<ChosenFilters>();
    const bool automatic = scene.filter.terraces == TerraceRemoval::automatic;
    ChosenFilters chosen{unstated, {}};
    chosen.chosen.terraces = chosen.chosen.terraces || automatic;
    TRY_ASSIGN(auto measured,
               known ? Result<MeasuredFrames>(*known) : measure_depth(reader, scene, given_up));
    TRY(settle_filters(measured.depth, unstated, scene));
    chosen.measured = measured.depth;
    chosen.damage = measured.damage;
    return std::optional(chosen);
}

}  // namespace touchable
