// touch_writer_*: framesets of a program as a clip.
#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "capi/frames.hpp"
#include "capi/open_clips.hpp"
#include "capi/scene_text.hpp"
#include "capi/status.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/stream/stream_url.hpp"

using namespace touchable;
using namespace touchable::capi;

namespace touchable::capi {
namespace {
namespace fs = std::filesystem;

/// Behind a touch_writer.
struct WriterObject {
    WriterObject(Scene scene, std::unique_ptr<ClipWriter> writer)
        : scene(std::move(scene)), writer(std::move(writer)) {}

    const Scene scene;
    std::atomic_flag writing = ATOMIC_FLAG_INIT;  ///< guards what follows
    std::unique_ptr<ClipWriter> writer;
    FrameCheck check;
    FrameScratch scratch;
};

HandleTable<WriterObject>& writers() {
    static auto& table = *new HandleTable<WriterObject>(6, Forked::refused);
    return table;
}

/// A scene of the other library, by the text that says all of it.
touch_status read_scene(touch_scene scene, SceneDescription& described, touch_error* error) {
    std::size_t length = 0;
    if (touch_scene_text(scene, nullptr, 0, &length) != TOUCH_OK) return fail_stale(error, "scene");
    std::string text(length, '\0');
    if (touch_scene_text(scene, text.data(), text.size(), &length) != TOUCH_OK || length != text.size())
        return fail_stale(error, "scene");
    auto whole = scene_of_text(text);
    if (!whole) return fail(error, whole.error());
    described = std::move(*whole);
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
    std::string ending = path.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char letter) {
        return letter >= 'A' && letter <= 'Z' ? letter + 32 : letter;
    });
    return ending == ".mkv" || ending == ".mp4";
}

/// What is there already is replaced only where that was asked for, and where it is not being read.
Result<void> check_place(const fs::path& path, bool overwrite) {
    std::error_code ignored;
    if (!fs::exists(fs::symlink_status(path, ignored))) return {};
    const std::string name = path.string();
    if (is_read_by_an_open_clip(path))
        return usage_error(name + " belongs to a clip that is open; close that first, or give another name");
    if (!is_folder_name(path) || !fs::is_directory(path, ignored))
        return overwrite ? Result<void>()
                         : usage_error(name + " is there already; give another name, or set overwrite");
    if (!is_image_folder(path))
        return usage_error(name + " holds other files than a clip's pictures; give another name");
    if (!overwrite && !fs::is_empty(path, ignored))
        return usage_error(name + " is there already; give another name, or set overwrite");
    return {};
}

Result<std::unique_ptr<ClipWriter>> create_writer(const fs::path& path, const SceneDescription& described,
                                                  const touch_writer_settings& settings) {
    const Existing existing = settings.overwrite != 0 ? Existing::replace : Existing::keep;
    if (is_folder_name(path)) return create_image_folder(path, described, existing);
    ClipStorage storage;
    storage.archive = settings.small != 0 ? Archive::small : Archive::fast;
    storage.exact_colour = settings.exact_colour != 0;
    return create_named_clip(path, described, storage, existing);
}

/// Numbered as it comes, at the scene's rate.
touch_status write(WriterObject& object, const touch_frame& given, touch_error* error) {
    if (!object.writer)
        return fail(error, TOUCH_USAGE, "an earlier frame could not be written; abandon this writer");
    touch_frame frame = given;
    frame.number = object.check.frames();
    frame.time_ns = object.scene.rate.time_ns(frame.number);
    auto raw = raw_frame(frame, object.scene, object.scratch);
    if (!raw) return fail(error, raw.error());
    if (auto sound = object.check.check(*raw, object.scene); !sound)
        return fail(error, sound.error().kind == ErrorKind::internal ? TOUCH_USAGE : TOUCH_INPUT,
                    sound.error().message);
    if (auto written = object.writer->write(*raw); !written) {
        object.writer.reset();
        return fail(error, written.error());
    }
    return TOUCH_OK;
}

Result<void> finish(WriterObject& object) {
    if (!object.writer) return usage_error("an earlier frame could not be written");
    if (object.check.frames() == 0) return usage_error("no frame was written; a clip has one at least");
    if (object.scene.rate.own_times &&
        static_cast<std::int64_t>(object.scene.rate.own_times->size()) != object.check.frames())
        return usage_error("times_ns has " + std::to_string(object.scene.rate.own_times->size()) +
                           " times, but " + std::to_string(object.check.frames()) + " frames were written");
    TRY(object.writer->complete());
    return object.writer->finish();
}

}  // namespace
}  // namespace touchable::capi

touch_status touch_writer_settings_defaults(touch_writer_settings* settings, uint32_t struct_size) {
    return give_defaults(touch_writer_settings{}, settings, struct_size);
}

touch_status touch_writer_create(const char* path, touch_scene scene, const touch_writer_settings* settings,
                                 touch_writer* writer, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!path || !*path || !writer || (settings && !has_known_size(settings)))
            return fail(
                error, TOUCH_USAGE,
                "path or writer is NULL, path is empty, or struct_size is not sizeof(touch_writer_settings)");
        touch_writer_settings wanted;
        touch_writer_settings_defaults(&wanted, sizeof wanted);
        if (settings) wanted = over_defaults(*settings, wanted);
        const fs::path place = path;
        if (is_stream_url(path) || (!is_folder_name(place) && !is_clip_name(place)))
            return fail(error, TOUCH_USAGE,
                        place.string() + ": right would be NAME.mkv, NAME.mp4, or the name of a folder");
        if (auto free = check_place(place, wanted.overwrite != 0); !free) return fail(error, free.error());
        SceneDescription described;
        if (const touch_status read = read_scene(scene, described, error); read != TOUCH_OK) return read;
        if (auto timed = take_times(wanted, described.scene); !timed) return fail(error, timed.error());
        auto made = create_writer(place, described, wanted);
        if (!made) return fail(error, made.error());
        return give_handle(writers(),
                           std::make_shared<WriterObject>(std::move(described.scene), std::move(*made)),
                           *writer, error);
    });
}

touch_status touch_writer_write(touch_writer writer, const touch_frame* frame, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!has_known_size(frame))
            return fail(error, TOUCH_USAGE, "frame is NULL, or struct_size is not sizeof(touch_frame)");
        const auto use = writers().find(writer.id);
        if (!use) return fail_without(use, error, "writer");
        const TryLock lock(use->writing);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is writing this clip");
        return write(*use, *frame, error);
    });
}

touch_status touch_writer_finish(touch_writer writer, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        std::shared_ptr<WriterObject> object;
        {
            const auto use = writers().find(writer.id);
            if (!use) return fail_without(use, error, "writer");
            object = use.shared();
        }
        switch (writers().remove(writer.id)) {
            case Removal::busy:
                return fail(error, TOUCH_BUSY, "another thread is writing this clip");
            case Removal::stale:  // another thread has ended it meanwhile
                return fail_stale(error, "writer");
            case Removal::removed:
                break;
        }
        if (auto finished = finish(*object); !finished) return fail(error, finished.error());
        return TOUCH_OK;
    });
}

touch_status touch_writer_abandon(touch_writer writer) {
    return end(writers(), writer);
}
