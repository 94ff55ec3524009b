// SPDX-License-Identifier: Apache-2.0
// libtouchable-media: clips (any file that the program opens, as framesets) and writers (a program's
// framesets as a clip). Scenes and their handles belong to libtouchable and are used only through its C
// functions.
#include "capi/api_common.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "engine/stream/stream_url.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace fs = std::filesystem;
using namespace touchable;
using namespace touchable::capi;

namespace {

/// The members of touch_clip_settings that state a setting; empty: none.
std::string_view members_of(Setting::Name setting) {
    constexpr std::pair<Setting::Name, std::string_view> all[] = {{Setting::depth_unit, "metres_per_code"},
                                                                  {Setting::field_of_view, "fov_degrees"},
                                                                  {Setting::intrinsics, "fx_px and fy_px"},
                                                                  {Setting::preset, "preset"},
                                                                  {Setting::depth_kind, "depth_kind"},
                                                                  {Setting::near, "near_m"},
                                                                  {Setting::far, "far_m"},
                                                                  {Setting::channel, "channel"},
                                                                  {Setting::dataset, "dataset"},
                                                                  {Setting::scene_file, "scene_file"}};
    for (const auto& [name, members] : all)
        if (name == setting) return members;
    return {};
}

std::string members_of(const Hints& hints) {
    std::vector<std::string> members;
    for (const Hint& hint : hints) {
        const auto member = members_of(hint.setting);
        if (member.empty()) continue;
        const bool is_example = hint.value.empty() || hint.setting == Setting::intrinsics ||
                                (hint.value[0] >= 'A' && hint.value[0] <= 'Z');  // FILE
        std::string words = std::string(member) + (is_example ? "" : "=" + hint.value);
        if (std::ranges::find(members, words) == members.end()) members.push_back(std::move(words));
    }
    return listed(members, {}, " or ");
}

/// Adds the helpful members of touch_clip_settings to an error's line.
Error with_members(Error error) {
    const std::string members = members_of(error.hints);
    if (!members.empty()) error.message += " (" + members + ')';
    return error;
}

/// A remark on a clip, with the members that correct it.
std::string note_with_members(const Remark& remark) {
    const std::string members = members_of(remark.hints);
    if (members.empty()) return remark_in_words(remark);
    Remark with = remark;
    with.otherwise =
        remark.otherwise.empty() ? members + " says otherwise" : remark.otherwise + ": " + members;
    return remark_in_words(with);
}

/// With colour and no facts about the camera.
touch_clip_settings default_clip_settings() {
    touch_clip_settings settings{};
    settings.struct_size = sizeof settings;
    settings.colour = 1;
    settings.cx_px = settings.cy_px = std::nan("");
    settings.depth_kind = -1;
    return settings;
}

Error refuse_member(const char* member, const std::string& right) {
    return usage_error(std::string(member) + " is out of range; must be " + right);
}

/// The program's facts about a clip's camera. Errors name the member.
Result<SourceDescription> known_of(const touch_clip_settings& settings) {
    SourceDescription known;
    constexpr double longest_px = 1e9;
    if (settings.fx_px != 0 || settings.fy_px != 0) {
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
    const auto state = [&known](const char* member, double number, Setting::Name name) -> Result<void> {
        const SourceSetting& setting = *source_setting(name);
        if (number == 0 || setting.state(number, known)) return {};
        return refuse_member(member, formatted("%g to %g", setting.range.least, setting.range.most));
    };
    TRY(state("fov_degrees", settings.fov_degrees, Setting::field_of_view));
    if (known.fov && known.intrinsics)
        return usage_error("fx_px and fov_degrees are both set; use one of them");
    TRY(state("metres_per_code", settings.metres_per_code, Setting::depth_unit));
    TRY(state("near_m", settings.near_m, Setting::near));
    TRY(state("far_m", settings.far_m, Setting::far));
    if (settings.depth_kind < -1 || settings.depth_kind > TOUCH_RANGE)
        return refuse_member("depth_kind", "TOUCH_PLANAR, TOUCH_RANGE or -1");
    if (settings.depth_kind >= 0)
        known.semantics = settings.depth_kind == TOUCH_RANGE ? DepthSemantics::range : DepthSemantics::planar;
    if (settings.preset) known.preset = settings.preset;
    if (known != SourceDescription() && settings.scene_file)
        return usage_error("scene_file is set, and something of the camera beside it; use one of them");
    if (settings.channel) known.channel = settings.channel;
    if (settings.dataset) known.dataset = settings.dataset;
    return known;
}

std::vector<std::string> notes_of(const ClipReader& reader) {
    std::vector<std::string> notes;
    for (const Remark& remark : remarks_of(reader)) notes.push_back(note_with_members(remark));
    return notes;
}

/// Absolute paths stay valid if the program changes its working folder.
std::vector<fs::path> absolute(const std::vector<fs::path>& files) {
    std::vector<fs::path> whole;
    for (const fs::path& file : files) {
        std::error_code failure;
        whole.push_back(fs::absolute(file, failure));
    }
    return whole;
}

/// The object of a touch_clip.
struct ClipObject {
    explicit ClipObject(std::unique_ptr<ClipReader> opened)
        : described(opened->described()),
          tracks(opened->tracks()),
          notes(notes_of(*opened)),
          frames(opened->frame_count()),
          inputs(absolute(opened->inputs())),
          reader(std::move(opened)) {}

    bool has(const char* role) const {
        return std::ranges::any_of(tracks, [&](const TrackInfo& track) { return track.role == role; });
    }

    const SceneDescription described;
    const std::vector<TrackInfo> tracks;
    const std::vector<std::string> notes;  ///< with the members that correct them
    const std::optional<std::int64_t> frames;
    const std::vector<fs::path> inputs;
    std::stop_source stop;

    std::atomic_flag reading = ATOMIC_FLAG_INIT;  ///< guards the members below
    std::unique_ptr<ClipReader> reader;           ///< null: it could not be read on
    std::int64_t next_frame = 0;                  ///< of the reader
    std::shared_ptr<RawFrame> unclaimed;          ///< was read, and there was no room for it; null: none
};

constexpr auto clips = handles<ClipObject, 4, Forked::refused>;

/// Whether an open clip is read from this file, or from a file in this folder, under any name.
bool is_read_by_an_open_clip(const fs::path& path) {
    bool is_read = false;
    clips().for_each([&](const ClipObject& clip) {
        for (const fs::path& input : clip.inputs) {
            std::error_code absent;
            is_read = is_read || fs::equivalent(input, path, absent) ||
                      fs::equivalent(input.parent_path(), path, absent);
        }
    });
    return is_read;
}

/// The object of a touch_frameset: its storage keeps the planes.
using FramesetObject = RawFrame;
constexpr std::size_t most_framesets = 65536;

constexpr auto framesets = handles<FramesetObject, 5, Forked::usable, most_framesets>;

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
    facts.depth_is_lossless = std::ranges::all_of(
        clip.tracks, [](const TrackInfo& track) { return track.role != "depth" || track.lossless; });
    facts.notes = static_cast<std::int32_t>(clip.notes.size());
    facts.has_own_times = scene.rate.own_times != nullptr;
    facts.frames = clip.frames.value_or(-1);
    facts.frames_per_second = scene.rate.per_second();
    return facts;
}

/// Reads the first frames. If a later frame is damaged, the frames before it suffice.
Result<void> look_ahead(Prefetch& ahead, DepthEstimator& estimator) {
    for (bool is_first = true; !estimator.enough(); is_first = false) {
        const auto frame = ahead.next();
        if (!frame && (is_first || frame.error().kind == ErrorKind::interrupted)) return frame.error();
        if (!frame || !*frame) break;
        estimator.add(**frame);
    }
    return {};
}

/// Measures the clip's first frames and returns to the present frame, also after a fault.
Result<std::optional<MeasuredDepth>> measure(ClipObject& clip) {
    if (clip.next_frame != 0) TRY(clip.reader->seek(0));
    DepthEstimator estimator(clip.described.scene);
    Prefetch ahead(std::move(clip.reader));
    const auto looked = look_ahead(ahead, estimator);
    TRY_ASSIGN(clip.reader, ahead.finish());
    if (clip.next_frame != 0) TRY(clip.reader->seek(clip.next_frame));
    TRY(looked);
    return estimator.measured();
}

/// Makes a scene in the other library, through its complete text.
touch_status hand_out_scene(SceneDescription described, touch_scene& scene, touch_error* error) {
    described.scene.rate.own_times.reset();  // not part of the text
    const std::string text = scene_to_json(described);
    return touch_scene_from_text(text.data(), text.size(), &scene, error);
}

Result<touch_status> choose_scene(ClipObject& clip, touch_scene& scene, touch_error* error) {
    SceneDescription chosen = clip.described;
    if (needs_measuring(chosen.unstated.filters, chosen.scene)) {
        const auto measured = measure(clip);
        if (!measured) return with_members(measured.error());
        TRY(settle_filters(*measured, chosen.unstated.filters, chosen.scene));
    }
    chosen.unstated.filters = {};
    return hand_out_scene(chosen, scene, error);
}

/// Runs `read` on a clip that no other thread reads; touch_clip_interrupt ends it.
template <class Function>
Result<touch_status> with_reader(touch_clip handle, touch_error* error, Function&& read) {
    const auto use = clips().find(handle.id);
    if (!use) return fail_without(use, error, "clip");
    const TryLock lock(use->reading);
    if (!lock) return fail(error, TOUCH_BUSY, "another thread is reading this clip");
    if (!use->reader) return fail(error, TOUCH_INPUT, "the clip could not be read on; open it anew");
    if (use->stop.stop_requested()) return fail(error, TOUCH_INTERRUPTED, "the clip was interrupted");
    const StopScope until(use->stop.get_token());
    return read(*use);
}

/// The object of a touch_writer.
struct WriterObject {
    WriterObject(fs::path at, SceneDescription of, const touch_writer_settings& with)
        : place(std::move(at)), given(std::move(of)), settings(with) {}
    /// Begins the clip, anew for depth of another kind.
    Result<void> begin(std::int32_t sample);

    const fs::path place;
    const SceneDescription given;
    const touch_writer_settings settings;         ///< their times are in the scene
    std::atomic_flag writing = ATOMIC_FLAG_INIT;  ///< guards the members below
    Scene scene;
    std::unique_ptr<ClipWriter> writer;
    FrameCheck check;
    FrameScratch scratch;
};

constexpr auto writers = handles<WriterObject, 6, Forked::refused>;

/// Reads a scene of the other library, through its complete text.
Result<touch_status> read_scene(touch_scene scene, SceneDescription& described, touch_error* error) {
    std::size_t length = 0;
    if (touch_scene_text(scene, nullptr, 0, &length) != TOUCH_OK) return fail_stale(error, "scene");
    std::string text(length, '\0');
    if (touch_scene_text(scene, text.data(), text.size(), &length) != TOUCH_OK || length != text.size())
        return fail_stale(error, "scene");
    TRY_ASSIGN(described, scene_of_text(text));
    return TOUCH_OK;
}

Result<void> take_times(const touch_writer_settings& settings, Scene& scene) {
    if (!settings.times_ns && settings.times == 0) return {};
    constexpr std::size_t most = std::size_t{1} << 28;
    if (!settings.times_ns || settings.times < 2 || settings.times > most)
        return usage_error("times_ns is NULL, or times is not 2 or more");
    const std::vector<std::int64_t> times(settings.times_ns, settings.times_ns + settings.times);
    auto rate = times.front() == 0 ? rate_of_own_times(times) : std::nullopt;
    if (!rate)
        return usage_error("times_ns must begin with 0, and each be at least 1 ms after the one before");
    scene.rate = std::move(*rate);
    return {};
}

bool is_folder_name(const fs::path& path) {
    return !path.has_filename() || path.extension().empty();
}

bool is_clip_name(const fs::path& path) {
    const std::string ending = small_letters(path.extension().string());
    return ending == ".mkv" || ending == ".mp4";
}

/// Refuses an existing file, unless it may be overwritten and no open clip is read from it.
Result<void> check_place(const fs::path& path, bool overwrite) {
    std::error_code ignored;
    if (!fs::exists(fs::symlink_status(path, ignored))) return {};
    const std::string name = path.string();
    if (is_read_by_an_open_clip(path))
        return usage_error(name + " belongs to a clip that is open; close that first, or give another name");
    const bool is_folder = is_folder_name(path) && fs::is_directory(path, ignored);
    if (is_folder && !is_image_folder(path))
        return usage_error(name + " holds other files than a clip's pictures; give another name");
    if (!overwrite && !(is_folder && fs::is_empty(path, ignored)))
        return Error{ErrorKind::usage,
                     name + " is there already; give another name, or set overwrite",
                     {},
                     Error::Cause::exists};
    return {};
}

Result<std::unique_ptr<ClipWriter>> create_writer(const fs::path& path, const SceneDescription& described,
                                                  const touch_writer_settings& settings) {
    const Existing existing = settings.overwrite != 0 ? Existing::replace : Existing::keep;
    if (is_folder_name(path)) return create_image_folder(path, described, existing);
    ClipStorage storage;
    storage.archive = settings.small != 0 ? Archive::small : Archive::fast;
    storage.exact_colour = settings.exact_colour != 0;
    return create_clip(path, described, storage, existing);
}

Result<void> WriterObject::begin(std::int32_t sample) {
    SceneDescription settled = given;
    scene = settled.scene = scene_of_depth(given.scene, sample);
    scratch.integer_scale = integer_scale_after(given.scene, sample);
    writer.reset();
    return assign(writer, create_writer(place, settled, settings));
}

/// Writes the next frame, numbered by the writer, at the scene's rate.
Result<touch_status> write(WriterObject& object, const touch_frame& given) {
    if (!object.writer) return usage_error("an earlier frame could not be written; abandon this writer");
    touch_frame frame = given;
    frame.number = object.check.frames();
    frame.time_ns = object.scene.rate.time_ns(frame.number);
    if (frame.number == 0 && integer_scale_after(object.given.scene, frame.depth.sample) > 0)
        TRY(object.begin(TOUCH_F32));
    TRY_ASSIGN(const auto raw, raw_frame(frame, object.scene, object.scratch));
    if (auto sound = object.check.check(raw, object.scene); !sound)
        return Error{sound.error().kind == ErrorKind::internal ? ErrorKind::usage : ErrorKind::input,
                     sound.error().message};
    const auto written = object.writer->write(raw);
    if (!written) object.writer.reset();
    TRY(written);
    return TOUCH_OK;
}

Result<void> finish(WriterObject& object) {
    if (!object.writer) return usage_error("an earlier frame could not be written");
    if (object.check.frames() == 0) return usage_error("no frame was written; a clip has one at least");
    const auto& times = object.scene.rate.own_times;
    if (times && static_cast<std::int64_t>(times->size()) != object.check.frames())
        return usage_error("times_ns has " + std::to_string(times->size()) + " times, but " +
                           std::to_string(object.check.frames()) + " frames were written");
    TRY(object.writer->complete());
    return object.writer->finish();
}

}  // namespace

touch_status touch_clip_settings_defaults(touch_clip_settings* settings, uint32_t struct_size) {
    return give_defaults(default_clip_settings(), settings, struct_size);
}

touch_status touch_clip_open(const char* path, const touch_clip_settings* settings, touch_clip* clip,
                             touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!path || !*path || !clip || (settings && !has_known_size(settings)))
            return usage_error(
                "path or clip is NULL, path is empty, or struct_size is not sizeof(touch_clip_settings)");
        const touch_clip_settings wanted = over_defaults(settings, default_clip_settings());
        TRY_ASSIGN(const auto known, known_of(wanted));
        std::optional<fs::path> scene_file;
        if (wanted.scene_file) scene_file = wanted.scene_file;
        const Colour colour = wanted.colour != 0 ? Colour::wanted : Colour::left_out;
        auto reader = open_clip(path, scene_file, known, colour);
        if (!reader) return with_members(reader.error());
        if (colour == Colour::left_out) (*reader)->leave_out_colour();
        return give_handle(clips(), std::make_shared<ClipObject>(std::move(*reader)), *clip, error);
    });
}

touch_status touch_clip_describe(touch_clip clip, touch_clip_facts* facts) {
    if (!has_known_size(facts)) return TOUCH_USAGE;
    return with_object(clips(), clip, [&](const auto& object) { hand_out(facts_of(object), *facts); });
}

touch_status touch_clip_time(touch_clip clip, int64_t frame, int64_t* time_ns) {
    if (!time_ns || frame < 0 || frame > last_with_a_time) return TOUCH_USAGE;
    return with_object(clips(), clip,
                       [&](const auto& object) { *time_ns = object.described.scene.rate.time_ns(frame); });
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
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!scene || (filters != TOUCH_FILTERS_STATED && filters != TOUCH_FILTERS_CHOSEN))
            return usage_error(
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
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!frameset) return usage_error("frameset is NULL");
        return with_reader(clip, error, [&](ClipObject& object) -> Result<touch_status> {
            if (!object.unclaimed) {
                auto frame = object.reader->next();
                if (!frame) return with_members(frame.error());
                if (!*frame) return fail(error, TOUCH_END, "the clip has no more frames");
                object.unclaimed = std::make_shared<FramesetObject>(std::move(**frame));
                object.next_frame = object.unclaimed->number + 1;
            }
            const touch_status given = give_handle(framesets(), object.unclaimed, *frameset, error);
            if (given != TOUCH_OK) return given;  // returned again by a later call
            object.unclaimed.reset();
            return TOUCH_OK;
        });
    });
}

touch_status touch_clip_seek(touch_clip clip, int64_t frame, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (frame < 0 || frame > last_with_a_time)
            return usage_error("the clip has no frame " + std::to_string(frame));
        return with_reader(clip, error, [&](ClipObject& object) -> Result<touch_status> {
            TRY(object.reader->seek(frame));
            object.next_frame = frame;
            object.unclaimed.reset();
            return TOUCH_OK;
        });
    });
}

touch_status touch_clip_interrupt(touch_clip clip) {
    return without_exceptions(nullptr, [&]() -> touch_status {
        return with_object(clips(), clip, [](ClipObject& object) { object.stop.request_stop(); });
    });
}

touch_status touch_clip_close(touch_clip clip) {
    return end(clips(), clip);
}

touch_status touch_frameset_frame(touch_frameset frameset, touch_frame* frame) {
    if (!has_known_size(frame)) return TOUCH_USAGE;
    return with_object(framesets(), frameset, [frame](const FramesetObject& object) {
        touch_frame out{};
        out.number = object.number;
        out.time_ns = object.time_ns;
        out.depth = plane_for_program(object.depth);
        out.colour = plane_for_program(object.colour);
        out.haptic = plane_for_program(object.haptic);
        out.height = plane_for_program(object.height);
        hand_out(out, *frame);
    });
}

touch_status touch_frameset_release(touch_frameset frameset) {
    return end(framesets(), frameset);
}

touch_status touch_writer_settings_defaults(touch_writer_settings* settings, uint32_t struct_size) {
    return give_defaults(touch_writer_settings{}, settings, struct_size);
}

touch_status touch_writer_create(const char* path, touch_scene scene, const touch_writer_settings* settings,
                                 touch_writer* writer, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!path || !*path || !writer || (settings && !has_known_size(settings)))
            return usage_error(
                "path or writer is NULL, path is empty, or struct_size is not sizeof(touch_writer_settings)");
        const touch_writer_settings wanted = over_defaults(settings, touch_writer_settings{});
        const fs::path place = path;
        if (is_stream_url(path) || (!is_folder_name(place) && !is_clip_name(place)))
            return usage_error(place.string() + ": must be NAME.mkv, NAME.mp4, or the name of a folder");
        TRY(check_place(place, wanted.overwrite != 0));
        SceneDescription described;
        if (const auto read = read_scene(scene, described, error); !read || *read != TOUCH_OK) return read;
        TRY(take_times(wanted, described.scene));
        auto object = std::make_shared<WriterObject>(place, std::move(described), wanted);
        TRY(object->begin(TOUCH_U16));
        return give_handle(writers(), std::move(object), *writer, error);
    });
}

touch_status touch_writer_write(touch_writer writer, const touch_frame* frame, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!has_known_size(frame))
            return usage_error("frame is NULL, or struct_size is not sizeof(touch_frame)");
        const auto use = writers().find(writer.id);
        if (!use) return fail_without(use, error, "writer");
        const TryLock lock(use->writing);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is writing this clip");
        return write(*use, *frame);
    });
}

touch_status touch_writer_finish(touch_writer writer, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        std::shared_ptr<WriterObject> object;
        {
            const auto use = writers().find(writer.id);
            if (!use) return fail_without(use, error, "writer");
            object = use.shared();
        }
        const Removal removal = writers().remove(writer.id);
        if (removal == Removal::busy) return fail(error, TOUCH_BUSY, "another thread is writing this clip");
        // Another thread has removed it meanwhile.
        if (removal == Removal::stale) return fail_stale(error, "writer");
        TRY(finish(*object));
        return TOUCH_OK;
    });
}

touch_status touch_writer_abandon(touch_writer writer) {
    return end(writers(), writer);
}
