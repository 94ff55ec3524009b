#include "bench/capi/read_run.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string>

#include "bench/clocks.hpp"
#include "capi/touchable.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {
namespace {
namespace fs = std::filesystem;

/// A temporary clip, removed by the destructor.
class ScratchClip {
public:
    ScratchClip()
        : file_(fs::temp_directory_path() / ("touchable-bench-" + std::to_string(getpid()) + ".mkv")) {}
    ~ScratchClip() {
        std::error_code ignored;
        fs::remove(file_, ignored);
    }
    ScratchClip(const ScratchClip&) = delete;
    ScratchClip& operator=(const ScratchClip&) = delete;
    const fs::path& file() const { return file_; }
    Result<void> write(int width, int height, int frames) const {
        SceneOptions options;
        options.width = width;
        options.height = height;
        options.properties = true;
        auto scene = make_scene("globe", options);
        if (!scene) return scene.error();
        auto writer = create_clip(file_, (*scene)->scene());
        if (!writer) return writer.error();
        for (int n = 0; n < frames; ++n)
            if (auto written = (*writer)->write((*scene)->frame(n)); !written) return written;
        return (*writer)->finish();
    }

private:
    fs::path file_;
};

/// Least time from opening a clip to its last frame, seconds.
struct Reading {
    double seconds = std::numeric_limits<double>::infinity();
    int frames = 0;
    void take(std::int64_t began_ns, int read) {
        seconds = std::min(seconds, static_cast<double>(monotonic_ns() - began_ns) / 1e9);
        frames = read;
    }
    double per_second() const { return frames / seconds; }
};

Result<void> read_by_reader(const fs::path& file, Reading& reading) {
    const std::int64_t began = monotonic_ns();
    auto clip = open_clip(file);
    if (!clip) return clip.error();
    int frames = 0;
    for (;; ++frames) {
        const auto frame = (*clip)->next();
        if (!frame) return frame.error();
        if (!*frame) break;
    }
    reading.take(began, frames);
    return {};
}

void read_by_c(const fs::path& file, Reading& reading) {
    const std::int64_t began = monotonic_ns();
    touch::Clip clip(file.string());
    int frames = 0;
    while (const auto frameset = clip.next()) frames += frameset->frame().depth.data != nullptr;
    reading.take(began, frames);
}

}  // namespace

Result<void> measure_c_reading(int width, int height, int frames, int repeats, Figures& figures) {
    const ScratchClip clip;
    if (auto written = clip.write(width, height, frames); !written) return written;
    Reading reader, c;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        if (auto read = read_by_reader(clip.file(), reader); !read) return read;
        read_by_c(clip.file(), c);
    }
    if (reader.frames != frames || c.frames != frames)
        return Error{ErrorKind::check, "not every frame was read"};
    figures.insert(figures.end(), {{"own_frames_per_s", reader.per_second(), ""},
                                   {"c_frames_per_s", c.per_second(), ""},
                                   {"c_read_ratio", reader.per_second() / c.per_second(), ""}});
    return {};
}

}  // namespace touchable
