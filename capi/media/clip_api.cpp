// touch_clip_* and touch_frameset_*: whatever the program opens, as framesets.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "capi/frames.hpp"
#include "capi/media/clip_words.hpp"
#include "capi/media/open_clips.hpp"
#include "capi/status.hpp"
#include "engine/clip/prefetch.hpp"
#include "engine/import/open_clip.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/stop_request.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/filter_choice.hpp"

using namespace touchable;
using namespace touchable::capi;

namespace touchable::capi {
namespace {

/// Behind a touch_frameset: its storage keeps the planes.
using FramesetObject = RawFrame;
constexpr std::size_t most_framesets = 65536;

HandleTable<FramesetObject, most_framesets>& framesets() {
    static auto& table = *new HandleTable<FramesetObject, most_framesets>(5);
    return table;
}

constexpr std::int64_t last_with_a_time = std::int64_t{1} << 40;  // FrameRate

/// A number that a program set, or 0 for "not said".
bool is_said(double value) {
    return value != 0;
}

Error refuse_member(const char* member, const char* right) {
    return usage_error(std::string(member) + " is out of range; right would be " + right);
}

bool is_within(double value, double least, double most) {
    return value >= least && value <= most;  // of NaN it is not
}

Result<std::optional<SourceDescription>> known_of(const touch_clip_settings& settings) {
    SourceDescription known;
    constexpr double longest_px = 1e9;
    if (is_said(settings.fx_px) || is_said(settings.fy_px)) {
        if (!(settings.fx_px > 0 && settings.fx_px <= longest_px && settings.fy_px > 0 &&
              settings.fy_px <= longest_px))
            return refuse_member("fx_px or fy_px", "above 0, or both 0");
        known.intrinsics = Intrinsics{.fx = settings.fx_px, .fy = settings.fy_px};
        const auto place = [](double px) { return std::isnan(px) ? std::nullopt : std::optional(px); };
        known.intrinsics->cx = place(settings.cx_px);
        known.intrinsics->cy = place(settings.cy_px);
        if (std::isinf(settings.cx_px) || std::isinf(settings.cy_px))
            return refuse_member("cx_px or cy_px", "pixels, or NaN for the middle");
    }
    if (is_said(settings.fov_degrees)) {
        if (!is_within(settings.fov_degrees, 1, 179)) return refuse_member("fov_degrees", "1 to 179");
        if (known.intrinsics)
            return usage_error("fx_px and fov_degrees are both set; right would be one of them");
        known.fov = settings.fov_degrees;
    }
    if (is_said(settings.metres_per_code)) {
        if (!is_within(settings.metres_per_code, 1e-9, 1e6))
            return refuse_member("metres_per_code", "1e-9 to 1e6");
        known.metres_per_code = settings.metres_per_code;
    }
    if (settings.preset) known.preset = settings.preset;
    if (known == SourceDescription{}) return std::optional<SourceDescription>();
    if (settings.scene_file)
        return usage_error(
            "scene_file is set, and something of the camera beside it; right would be one of them");
    return std::optional(std::move(known));
}

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

/// What the clip's first frames tell; leaves it where it was. Where frames are damaged, those before them
/// count.
Result<std::optional<MeasuredDepth>> measure(ClipObject& clip) {
    if (clip.next_frame != 0)
        if (auto back = clip.reader->seek(0); !back) return back.error();
    DepthEstimator estimator(clip.described.scene);
    Prefetch ahead(std::move(clip.reader));
    for (bool is_first = true; !estimator.enough(); is_first = false) {
        const auto frame = ahead.next();
        if (!frame && (is_first || frame.error().kind == ErrorKind::interrupted)) return frame.error();
        if (!frame || !*frame) break;
        estimator.add(**frame);
    }
    auto whole = ahead.finish();
    if (!whole) return whole.error();
    clip.reader = std::move(*whole);
    if (clip.next_frame != 0)
        if (auto there = clip.reader->seek(clip.next_frame); !there) return there.error();
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
    if (!use) return fail_stale(error, "clip");
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
    if (!settings || struct_size != sizeof *settings) return TOUCH_USAGE;
    *settings = {};
    settings->struct_size = struct_size;
    settings->colour = 1;
    settings->cx_px = settings->cy_px = std::nan("");
    return TOUCH_OK;
}

touch_status touch_clip_open(const char* path, const touch_clip_settings* settings, touch_clip* clip,
                             touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!path || !*path || !clip || (settings && !has_known_size(settings)))
            return fail(
                error, TOUCH_USAGE,
                "path or clip is NULL, path is empty, or struct_size is not sizeof(touch_clip_settings)");
        touch_clip_settings wanted;
        touch_clip_settings_defaults(&wanted, sizeof wanted);
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
    if (!use) return TOUCH_STALE;
    hand_out(facts_of(*use), *facts);
    return TOUCH_OK;
}

touch_status touch_clip_time(touch_clip clip, int64_t frame, int64_t* time_ns) {
    if (!time_ns || frame < 0 || frame > last_with_a_time) return TOUCH_USAGE;
    const auto use = clips().find(clip.id);
    if (!use) return TOUCH_STALE;
    *time_ns = use->described.scene.rate.time_ns(frame);
    return TOUCH_OK;
}

touch_status touch_clip_note(touch_clip clip, int32_t index, char* text, size_t capacity, size_t* length) {
    if (!length || (!text && capacity > 0)) return TOUCH_USAGE;
    const auto use = clips().find(clip.id);
    if (!use) return TOUCH_STALE;
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
        if (!use) return fail_stale(error, "clip");
        return hand_out_scene(use->described, *scene, error);
    });
}

touch_status touch_clip_next(touch_clip clip, touch_frameset* frameset, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!frameset) return fail(error, TOUCH_USAGE, "frameset is NULL");
        return with_reader(clip, error, [&](ClipObject& object) {
            auto frame = object.reader->next();
            if (!frame) return fail(error, with_members(frame.error()));
            if (!*frame) return fail(error, TOUCH_END, "the clip has no more frames");
            object.next_frame = (*frame)->number + 1;
            return give_handle(framesets(), std::make_shared<FramesetObject>(std::move(**frame)), *frameset,
                               error);
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
            return TOUCH_OK;
        });
    });
}

touch_status touch_clip_interrupt(touch_clip clip) {
    return without_exceptions(nullptr, [&]() -> touch_status {
        const auto use = clips().find(clip.id);
        if (!use) return TOUCH_STALE;
        use->stop.request_stop();
        return TOUCH_OK;
    });
}

touch_status touch_clip_close(touch_clip clip) {
    return without_exceptions(nullptr, [&]() -> touch_status { return status_of(clips().remove(clip.id)); });
}

touch_status touch_frameset_frame(touch_frameset frameset, touch_frame* frame) {
    if (!has_known_size(frame)) return TOUCH_USAGE;
    const auto use = framesets().find(frameset.id);
    if (!use) return TOUCH_STALE;
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
    return without_exceptions(nullptr,
                              [&]() -> touch_status { return status_of(framesets().remove(frameset.id)); });
}
