#include "player/session/clip_choice.hpp"

#include <utility>

#include "player/session/measured_filter.hpp"

namespace touchable {

namespace {

Result<void> apply(const TemporalChoice& temporal, FilterSettings& filter) {
    filter.temporal = temporal.on;
    if (temporal.noise) filter.temporal_noise = *temporal.noise;
    if (temporal.on && !temporal.noise && filter.temporal_noise == DepthLength{})
        return usage_error(
            "--temporal on: the scene does not say how noisy its depth is; right would be that noise in "
            "scene units instead of on, such as 1.5");
    return {};
}

Result<Scene> applied(const ClipChoice& choice, Scene scene) {
    if (choice.median) scene.filter.median = *choice.median;
    if (choice.fill_holes) scene.filter.fill_holes = *choice.fill_holes;
    if (choice.terraces) scene.filter.terraces = *choice.terraces;
    if (choice.temporal)
        if (auto done = apply(*choice.temporal, scene.filter); !done.ok()) return done.error();
    if (choice.interpolation) scene.interpolation = *choice.interpolation;
    // Whether there is room for terrace removal depends on levels that are measured yet.
    Scene without = scene;
    without.filter.terraces = TerraceRemoval::off;
    if (auto valid = validate(without); !valid.ok()) return usage_error(valid.error().message);
    return scene;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> ClipChoice::open() const {
    return open_clip(file, scene_file, camera);
}

Result<OpenClip> open_chosen(const ClipChoice& choice) {
    auto reader = choice.open();
    if (!reader.ok()) return reader.error();
    auto scene = applied(choice, (*reader)->scene());
    if (!scene.ok()) return scene.error();
    auto measured = settle_terraces(**reader, *scene);
    if (!measured.ok()) return measured.error();
    return OpenClip{std::move(*reader), std::move(*scene), std::move(*measured)};
}

}  // namespace touchable
