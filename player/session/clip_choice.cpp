#include "player/session/clip_choice.hpp"

#include <utility>

#include "engine/authoring/filled_clip.hpp"
#include "engine/authoring/painted_clip.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"

namespace touchable {

namespace {

void apply(const FiltersChoice& filters, Scene& scene, UnstatedFilters& unstated) {
    scene.filter.median = filters.settings.median;
    scene.filter.fill_holes = filters.settings.fill_holes;
    scene.filter.terraces = filters.settings.terraces;
    scene.filter.temporal = filters.settings.temporal;
    scene.filter.flying_pixels = filters.settings.flying_pixels;
    if (filters.settings.temporal_noise != DepthLength{})
        scene.filter.temporal_noise = filters.settings.temporal_noise;
    unstated = filters.unstated;
    if (unstated.terraces) scene.filter.terrace_reach = least_terrace_reach;  // chosen anew with it
}

void apply(const TemporalChoice& temporal, Scene& scene, UnstatedFilters& unstated) {
    scene.filter.temporal = temporal.on;
    unstated.temporal = false;
    if (temporal.noise) scene.filter.temporal_noise = *temporal.noise;
}

/// What is wanted now, stated or to be measured.
template <class Value>
void apply(const std::optional<Value>& wanted, Value& value, bool& unstated) {
    if (!wanted) return;
    value = *wanted;
    unstated = false;
}

/// What the clip is, and what is wanted of it.
Result<SceneDescription> applied(const ClipChoice& choice, SceneDescription described) {
    Scene& scene = described.scene;
    FilterSettings& filter = scene.filter;
    UnstatedFilters& unstated = described.unstated.filters;
    if (choice.filters) apply(*choice.filters, scene, unstated);
    apply(choice.median, filter.median, unstated.median);
    apply(choice.fill_holes, filter.fill_holes, unstated.fill_holes);
    apply(choice.terraces, filter.terraces, unstated.terraces);
    if (choice.temporal) apply(*choice.temporal, scene, unstated);
    // Who asks for it says nothing of its reach.
    if ((choice.filters || choice.terraces) && filter.terrace_reach == least_terrace_reach)
        unstated.terrace_reach = true;
    if (choice.interpolation) scene.interpolation = *choice.interpolation;
    // Levels, which decide whether there is room for terrace removal, and noise are still to be measured.
    Scene without = scene;
    without.filter.terraces = TerraceRemoval::off;
    without.filter.temporal = false;
    if (auto valid = validate(without); !valid.ok()) return usage_error(valid.error().message);
    return described;
}

}  // namespace

void ClipChoice::take(const LiveCamera& of) {
    plugged = of.plugged;
    if (plugged) {
        file = name_of(*plugged);
        return;
    }
    file = of.recording;
    as_camera = of.delivery;
}

void ClipChoice::share_clip() {
    if (is_camera() || shared_clip) return;
    shared_clip = std::make_shared<SharedClip>();
    relief_memory = std::make_shared<ReliefMemory>();
}

Result<std::unique_ptr<ClipReader>> ClipChoice::open(Colour colour) const {
    auto reader = open_relief(colour);
    return painted && reader.ok() ? with_painted_segments(std::move(*reader), painted) : std::move(reader);
}

/// As it feels by itself.
Result<std::unique_ptr<ClipReader>> ClipChoice::open_relief(Colour colour) const {
    if (!relief) return open_stored(colour);
    auto reader = open_stored(Colour::wanted);
    return reader.ok() ? with_chosen_relief(std::move(*reader), *relief, relief_memory.get())
                       : std::move(reader);
}

/// Without what is made of it.
Result<std::unique_ptr<ClipReader>> ClipChoice::open_stored(Colour colour) const {
    if (!shared_clip) return open_anew(colour);
    return shared_clip->open([this, colour] { return open_anew(colour); });
}

Result<std::unique_ptr<ClipReader>> ClipChoice::open_anew(Colour colour) const {
    if (fill_from_motion && is_camera())
        return usage_error(
            file.string() +
            ": is touched as a camera, of which no later frame can tell what is behind a hole: "
            "leave filling from motion off");
    const Colour read = fill_from_motion ? Colour::wanted : colour;  // which tells what is behind
    auto opened = !plugged        ? open_clip(file, scene_file, camera, read, {}, alignment)
                  : shared_camera ? shared_camera->open(*plugged, camera, scene_file)
                                  : open_plugged_camera(*plugged, camera, scene_file);
    if (fill_from_motion && opened.ok()) opened = with_filled_holes(std::move(*opened));
    auto reader = with_still_maps(std::move(opened), maps);
    if (!reader.ok()) return reader;
    if (colour == Colour::left_out) (*reader)->leave_out_colour();
    if (plugged) return reader;
    if (filmed) return make_filmed_camera(std::move(*reader), *filmed, file);
    if (as_camera) return make_replay_camera(std::move(*reader), *as_camera);
    return reader;
}

Result<OpenClip> open_chosen(const ClipChoice& choice, Colour colour, const std::stop_token& given_up) {
    const WorkUntil until(given_up);
    TRY_ASSIGN(auto reader, choice.open(colour));
    TRY_ASSIGN(auto wanted, applied(choice, reader->described()));
    TRY_ASSIGN(auto chosen,
               settle_filters(reader, wanted.unstated.filters, wanted.scene, choice.measured, given_up));
    return OpenClip{std::move(reader), std::move(wanted.scene), std::move(chosen)};
}

}  // namespace touchable
