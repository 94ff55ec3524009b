// touch_clip_* and touch_frameset_*: whatever the program opens, as framesets.
#include <algorithm>
#include <cstring>
#include <utility>

#include "capi/clip_settings.hpp"
#include "capi/clip_words.hpp"
#include "capi/frames.hpp"
#include "capi/open_clips.hpp"
#include "capi/status.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"

using namespace touchable;
using namespace touchable::capi;

namespace touchable::capi {
namespace {

/// Behind a touch_frameset: its storage keeps the planes.
using FramesetObject = RawFrame;
constexpr std::size_t most_framesets = 65536;

HandleTable<FramesetObject, most_framesets>& framesets() {
    static auto& table = *new HandleTable<FramesetObject, most_framesets>(5, Forked::usable);
    return table;
}

constexpr std::int64_t last_with_a_time = std::int64_t{1} << 40;  // FrameRate

touch_clip_facts facts_of(const ClipObject& clip) {
    const Scene& scene = clip.described.scene;
    const bool is_hue = scene.depth.kind == DepthCodingKind::hue;
    touch_clip_facts facts{};
    facts.struct_size = sizeof facts;
    facts.width = scene.width;
    facts.height = scene.height;
    facts.depth_sample = !is_hue && scene.depth_bits > 8 ? TOUCH_U16 : TOUCH_U8;
    facts.depth_channels = is_hue ? 3 : 1;
    facts.has_colour = clip.has("colour");
    facts.has_haptic = clip.has("haptic");
    facts.has_height = clip.has("height");
    facts.depth_is_lossless = std::all_of(clip.tracks.begin(), clip.tracks.end(), [](const TrackInfo& track) {
        return track.role != "depth" || track.lossless;
    });
    facts.notes = static_cast<std::int32_t>(clip.notes.size());
    facts.has_own_times = scene.rate.own_times != nullptr;
    facts.frames = clip.frames.value_or(-1);
    facts.frames_per_second = scene.rate.per_second();
    return facts;
}

/// Looks at first frames. Where a later one is damaged, those before it count.
Result<void> look_ahead(Prefetch& ahead, DepthEstimator& estimator) {
    for (bool is_first = true; !estimator.enough(); is_first = false) {
        const auto frame = ahead.next();
        if (!frame && (is_first || frame.error().kind == ErrorKind::interrupted)) return frame.error();
        if (!frame || !*frame) break;
        estimator.add(**frame);
    }
    return {};
}

/// What the clip's first frames tell; whatever comes of it, the clip is where it was.
Result<std::optional<MeasuredDepth>> measure(ClipObject& clip) {
    if (clip.next_frame != 0) TRY(clip.reader->seek(0));
    DepthEstimator estimator(clip.described.scene);
    Prefetch ahead(std::move(clip.reader));
    const auto looked = look_ahead(ahead, estimator);
    TRY_ASSIGN(auto whole, ahead.finish());
    clip.reader = std::move(whole);
    if (clip.next_frame != 0) TRY(clip.reader->seek(clip.next_frame));
    if (!looked) return looked.error();
    return estimator.measured();
}

/// A scene of the other library, by the text that says all of it.
touch_status hand_out_scene(SceneDescription described, touch_scene& scene, touch_error* error) {
    described.scene.rate.own_times.reset();  // which no text says
    const std::string text = scene_to_json(described);
    return touch_scene_from_text(text.data(), text.size(), &scene, error);
}

touch_status choose_scene(ClipObject& clip, touch_scene& scene, touch_error* error) {
    SceneDescription chosen = clip.described;
    if (needs_measuring(chosen.unstated.filters, chosen.scene)) {
        const auto measured = measure(clip);
        if (!measured) return fail(error, with_members(measured.error()));
        if (auto settled = settle_filters(*measured, chosen.unstated.filters, chosen.scene); !settled)
            return fail(error, settled.error());
    }
    chosen.unstated.filters = {};
    return hand_out_scene(chosen, scene, error);
}

/// Runs `read` on a clip that nobody else reads, for as long as nobody interrupts it.
template <class Function>
touch_status with_reader(touch_clip handle, touch_error* error, Function&& read) {
    const auto use = clips().find(handle.id);
    if (!use) return fail_without(use, error, "clip");
    const TryLock lock(use->reading);
    if (!lock) return fail(error, TOUCH_BUSY, "another thread is reading this clip");
    if (!use->reader)
        return fail(error, TOUCH_INPUT, "the clip could not be read on; right would be to open it anew");
    if (use->stop.stop_requested()) return fail(error, TOUCH_INTERRUPTED, "the clip was interrupted");
    const WorkUntil until(use->stop.get_token());
    return read(*use);
}

}  // namespace
}  // namespace touchable::capi

touch_status touch_clip_settings_defaults(touch_clip_settings* settings, uint32_t struct_size) {
    return give_defaults(default_clip_settings(), settings, struct_size);
}

touch_status touch_clip_open(const char* path, const touch_clip_settings* settings, touch_clip* clip,
                             touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!path || !*path || !clip || (settings && !has_known_size(settings)))
            return fail(
                error, TOUCH_USAGE,
                "path or clip is NULL, path is empty, or struct_size is not sizeof(touch_clip_settings)");
        touch_clip_settings wanted = default_clip_settings();
        if (settings) wanted = over_defaults(*settings, wanted);
        const auto known = known_of(wanted);
        if (!known) return fail(error, known.error());
        std::optional<std::filesystem::path> scene_file;
        if (wanted.scene_file) scene_file = wanted.scene_file;
        const Colour colour = wanted.colour != 0 ? Colour::wanted : Colour::left_out;
        auto reader = open_clip(path, scene_file, *known, colour);
        if (!reader) return fail(error, with_members(reader.error()));
        if (colour == Colour::left_out) (*reader)->leave_out_colour();
        return give_handle(clips(), std::make_shared<ClipObject>(std::move(*reader)), *clip, error);
    });
}

touch_status touch_clip_describe(touch_clip clip, touch_clip_facts* facts) {
    if (!has_known_size(facts)) return TOUCH_USAGE;
    const auto use = clips().find(clip.id);
    if (!use) return status_without(use);
    hand_out(facts_of(*use), *facts);
    return TOUCH_OK;
}

touch_status touch_clip_time(touch_clip clip, int64_t frame, int64_t* time_ns) {
    if (!time_ns || frame < 0 || frame > last_with_a_time) return TOUCH_USAGE;
    const auto use = clips().find(clip.id);
    if (!use) return status_without(use);
    *time_ns = use->described.scene.rate.time_ns(frame);
    return TOUCH_OK;
}

touch_status touch_clip_note(touch_clip clip, int32_t index, char* text, size_t capacity, size_t* length) {
    if (!length || (!text && capacity > 0)) return TOUCH_USAGE;
    const auto use = clips().find(clip.id);
    if (!use) return status_without(use);
    if (index < 0) return TOUCH_USAGE;
    if (static_cast<std::size_t>(index) >= use->notes.size()) return TOUCH_END;
    write_text(use->notes[static_cast<std::size_t>(index)], text, capacity, *length);
    return TOUCH_OK;
}

touch_status touch_clip_scene(touch_clip clip, int32_t filters, touch_scene* scene, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!scene || (filters != TOUCH_FILTERS_STATED && filters != TOUCH_FILTERS_CHOSEN))
            return fail(error, TOUCH_USAGE,
                        "scene is NULL, or filters is neither TOUCH_FILTERS_STATED nor TOUCH_FILTERS_CHOSEN");
        if (filters == TOUCH_FILTERS_CHOSEN)
            return with_reader(clip, error,
                               [&](ClipObject& object) { return choose_scene(object, *scene, error); });
        const auto use = clips().find(clip.id);
        if (!use) return fail_without(use, error, "clip");
        return hand_out_scene(use->described, *scene, error);
    });
}

touch_status touch_clip_next(touch_clip clip, touch_frameset* frameset, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!frameset) return fail(error, TOUCH_USAGE, "frameset is NULL");
        return with_reader(clip, error, [&](ClipObject& object) {
            if (!object.unclaimed) {
                auto frame = object.reader->next();
                if (!frame) return fail(error, with_members(frame.error()));
                if (!*frame) return fail(error, TOUCH_END, "the clip has no more frames");
                object.unclaimed = std::make_shared<FramesetObject>(std::move(**frame));
                object.next_frame = object.unclaimed->number + 1;
            }
            const touch_status given = give_handle(framesets(), object.unclaimed, *frameset, error);
            if (given != TOUCH_OK) return given;  // it comes again, once there is room
            object.unclaimed.reset();
            return TOUCH_OK;
        });
    });
}

touch_status touch_clip_seek(touch_clip clip, int64_t frame, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (frame < 0 || frame > last_with_a_time)
            return fail(error, TOUCH_USAGE, "the clip has no frame " + std::to_string(frame));
        return with_reader(clip, error, [&](ClipObject& object) -> touch_status {
            if (auto there = object.reader->seek(frame); !there) return fail(error, there.error());
            object.next_frame = frame;
            object.unclaimed.reset();
            return TOUCH_OK;
        });
    });
}

touch_status touch_clip_interrupt(touch_clip clip) {
    return without_exceptions(nullptr, [&]() -> touch_status {
        const auto use = clips().find(clip.id);
        if (!use) return status_without(use);
        use->stop.request_stop();
        return TOUCH_OK;
    });
}

touch_status touch_clip_close(touch_clip clip) {
    return end(clips(), clip);
}

touch_status touch_frameset_frame(touch_frameset frameset, touch_frame* frame) {
    if (!has_known_size(frame)) return TOUCH_USAGE;
    const auto use = framesets().find(frameset.id);
    if (!use) return status_without(use);
    touch_frame out{};
    out.number = use->number;
    out.time_ns = use->time_ns;
    out.depth = plane_for_program(use->depth);
    out.colour = plane_for_program(use->colour);
    out.haptic = plane_for_program(use->haptic);
    out.height = plane_for_program(use->height);
    hand_out(out, *frame);
    return TOUCH_OK;
}

touch_status touch_frameset_release(touch_frameset frameset) {
    return end(framesets(), frameset);
}
