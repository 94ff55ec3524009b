// SPDX-License-Identifier: Apache-2.0
#include "bench/live/feed_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "bench/clocks.hpp"
#include "bench/live/plain_decoding.hpp"
#include "bench/surface/race.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/tracks.hpp"
#include "player/run/surface_feed.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {
namespace {

using Reader = std::unique_ptr<ClipReader>;

Result<Reader> open_reader(const std::filesystem::path& file, bool colour) {
    auto reader = open_clip(file);
    if (reader && !colour) (*reader)->leave_out_colour();
    return reader;
}

/// Untimed check: every frame exists, and its touch planes equal the source's.
Result<void> check_frames(const LiveClip& clip, const std::filesystem::path& file,
                          const ScenePictures& source) {
    const auto reader = open_reader(file, false);
    if (!reader) return reader.error();
    for (std::int64_t n = 0;; ++n) {
        const auto raw = (*reader)->next();
        if (!raw) return raw.error();
        if (!*raw && n == clip.frames) return {};
        if (!*raw || n == clip.frames || (*raw)->number != n || !same_touch_planes(**raw, source.of(n)))
            return Error{ErrorKind::check,
                         file.string() + ": frame " + std::to_string(n) + " is not what went in"};
    }
}

class Stopwatch {
public:
    FrameTimes per(std::int64_t frames) const {
        const auto each = 1e-6 / static_cast<double>(frames);
        return {static_cast<double>(monotonic_ns() - wall_) * each,
                static_cast<double>(process_cpu_ns() - cpu_) * each};
    }

private:
    std::int64_t wall_ = monotonic_ns(), cpu_ = process_cpu_ns();
};

void keep_least(FrameTimes& least, const FrameTimes& times) {
    least.wall_ms = std::min(least.wall_ms, times.wall_ms);
    least.cpu_ms = std::min(least.cpu_ms, times.cpu_ms);
}

/// Times reading from an open reader to its last frame.
Result<FrameTimes> read_all(const std::filesystem::path& file, bool colour) {
    const auto reader = open_reader(file, colour);
    if (!reader) return reader.error();
    const Stopwatch watch;
    for (std::int64_t frames = 0;; ++frames) {
        if (stop_requested()) return interrupted_error();
        const auto raw = (*reader)->next();
        if (!raw) return raw.error();
        if (!*raw) return watch.per(frames);
    }
}

/// Times reading and building on the threads of a live run; the hand releases each frame at once.
Result<FrameTimes> feed_all(const std::filesystem::path& file, const Scene& scene, bool colour) {
    auto reader = open_reader(file, colour);
    if (!reader) return reader.error();
    SurfaceFeed feed(std::move(*reader), make_cpu_builder(scene), scene);
    FeedThreads threads(
        feed, [](const RawFrame&) { return false; }, PlaybackClock(FrameRate{}),
        [] { return MediaMoment{}; });
    const Stopwatch watch;
    if (auto begun = threads.start(); !begun) return begun.error();
    FramePair pair;
    while (!threads.end() && !threads.error()) {
        if (stop_requested()) return interrupted_error();
        feed.timeline().pair_at(std::numeric_limits<std::int64_t>::max(), pair);
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    const FrameTimes times = watch.per(std::max<std::int64_t>(feed.frames(), 1));
    threads.stop();
    if (const auto error = threads.error()) return *error;
    return times;
}

/// What error bars add to the CPU time of a frame, ms.
Result<double> error_bars_cpu_ms(const Scene& scene, const ScenePictures& source) {
    struct Built {
        std::unique_ptr<SurfaceBuilder> builder;
        std::int64_t next = 0;
        SurfaceFrame frame{};
    } plain{make_cpu_builder(scene)}, barred{with_error_bars(make_cpu_builder(scene), scene)};
    std::vector<Racer> racers;
    for (Built* const built : {&plain, &barred})
        racers.push_back({"", [built, &source] {
                              RawFrame raw = source.of(built->next);
                              raw.number = built->next++;
                              return built->builder->build(raw, built->frame);
                          }});
    TRY(race(racers, 30));
    return racers[1].times.cpu_ms - racers[0].times.cpu_ms;
}

/// Bytes per frame of the same pictures as FFV1, as in clips of format 1.
Result<double> ffv1_bytes_of(const LiveClip& clip, const ScenePictures& source) {
    double bytes = 0;
    for (const PlaneRole role : clip.planes) {
        std::unique_ptr<TrackEncoder> encoder;
        for (const RawFrame& frame : source.frames) {
            const PlaneView plane = plane_of(frame, role);
            if (plane.empty()) continue;
            if (!encoder) {
                TRY_ASSIGN(encoder, TrackEncoder::open(role, TrackCoding::ffv1, plane, source.scene));
            }
            TRY_ASSIGN(const auto packet, encoder->encode(plane, true));
            bytes += packet->size;
        }
    }
    return bytes / static_cast<double>(source.frames.size());
}

Result<void> add_sizes(const LiveClip& clip, const std::filesystem::path& file, const ScenePictures& source,
                       Figures& figures) {
    std::error_code unknown;
    const auto size = std::filesystem::file_size(file, unknown);
    if (unknown) return input_error(file.string() + ": " + unknown.message());
    const auto ffv1 = ffv1_bytes_of(clip, source);
    if (!ffv1) return ffv1.error();
    const double bytes = static_cast<double>(size) / clip.frames;
    figures.push_back({"bytes", bytes, ""});
    figures.push_back({"vs_ffv1", bytes / *ffv1, ""});
    return {};
}

}  // namespace

Result<void> measure_feed(const LiveClip& clip, bool colour, int rounds, LiveClips& clips, Figures& figures) {
    const auto file = clips.file(clip);
    if (!file) return file.error();
    const auto source = clips.pictures(clip);
    if (!source) return source.error();
    if (auto same = check_frames(clip, *file, **source); !same) return same;
    ClipChoice choice;
    choice.file = *file;
    const auto chosen = open_chosen(choice, Colour::left_out);  // with a run's filters
    if (!chosen) return chosen.error();

    FrameTimes reading, feeding;
    for (int round = 0; round < rounds; ++round) {
        const auto read = read_all(*file, colour);
        if (!read) return read.error();
        keep_least(reading, *read);
        const auto fed = feed_all(*file, chosen->scene, colour);
        if (!fed) return fed.error();
        keep_least(feeding, *fed);
    }
    std::vector<PlaneRole> wanted = clip.planes;
    if (!colour) std::erase(wanted, PlaneRole::colour);
    TRY_ASSIGN(const double bars_ms, error_bars_cpu_ms(chosen->scene, **source));
    const auto plain = decode_plainly(*file, wanted, rounds);
    if (!plain) return plain.error();

    if (auto added = add_sizes(clip, *file, **source, figures); !added) return added;
    add_times(figures, "read", reading);
    add_times(figures, "feed", feeding);
    figures.push_back({"frames_per_s", 1000 / feeding.wall_ms, ""});
    const double cores = std::max(std::thread::hardware_concurrency(), 1U);
    const double frames_per_second = 1e9 / static_cast<double>((*source)->scene.rate.time_ns(1));
    figures.push_back({"cores_left_pct", 100 - feeding.cpu_ms * frames_per_second / (10 * cores), "%"});
    figures.push_back({"error_bars_cpu_ms", bars_ms, "ms"});
    figures.push_back({"error_bars_pct", 0.1 * bars_ms * frames_per_second, "%"});
    figures.push_back({"ffmpeg_cpu_ms", plain->cpu_ms / clip.frames, "ms"});
    figures.push_back({"ffmpeg_ms", plain->wall_ms / clip.frames, "ms"});
    figures.push_back({"read_cpu_vs_ffmpeg", reading.cpu_ms * clip.frames / plain->cpu_ms, ""});
    figures.push_back({"feed_cpu_vs_ffmpeg", feeding.cpu_ms * clip.frames / plain->cpu_ms, ""});
    figures.push_back({"read_vs_ffmpeg", reading.wall_ms * clip.frames / plain->wall_ms, ""});
    return {};
}

}  // namespace touchable
