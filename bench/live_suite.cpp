// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "bench/live/feed_run.hpp"
#include "bench/live/live_clip.hpp"
#include "bench/live/program_memory.hpp"
#include "bench/live/seek_run.hpp"
#include "bench/live/touch_live.hpp"
#include "bench/suite.hpp"
#include "engine/clip/clip_file.hpp"

namespace touchable {
namespace {

using Measure = std::function<Result<void>(LiveClips&, Figures&)>;

std::string size_words(const LiveClip& clip) {
    return std::to_string(clip.width) + "x" + std::to_string(clip.height);
}

}  // namespace

std::vector<BenchCase> live_cases(bool quick) {
    const int rounds = quick ? 1 : 3;
    const auto clips = std::make_shared<LiveClips>(quick ? 15 : 45);
    std::vector<BenchCase> cases;
    const auto add = [&](const std::string& name, const Measure& measure) {
        cases.push_back({name, [=](Figures& figures) -> Result<void> {
                             auto done = measure(*clips, figures);
                             if (done) return done;
                             return Error{done.error().kind, name + ": " + done.error().message};
                         }});
    };
    const auto add_live = [&](const LiveClip& clip) {
        add("live-" + clip.scene + "-" + size_words(clip) + "-16",
            [=](LiveClips& all, Figures& figures) { return measure_live(clip, all, figures); });
    };
    const auto add_feed = [&](const LiveClip& clip, const char* what, bool colour) {
        add("feed-" + clip.scene + "-" + size_words(clip) + "-16" + what,
            [=](LiveClips& all, Figures& figures) {
                return measure_feed(clip, colour, rounds, all, figures);
            });
    };
    const LiveClip demo{.scene = "globe", .width = 720, .height = 480, .frames = quick ? 90 : 300};
    const LiveClip full_hd{.scene = "globe", .frames = quick ? 90 : 300};
    LiveClip small = full_hd, depth = full_hd, moving = full_hd, long_clip = demo;
    small.archive = Archive::small;
    depth.planes = moving.planes = {PlaneRole::depth};
    moving.scene = "moving";
    const int seconds = quick ? 20 : 600;
    long_clip.frames = 30 * seconds;
    add_feed(full_hd, "", false);
    add_feed(demo, "", false);
    add_feed(full_hd, "-colour", true);
    add_feed(small, "-small", false);
    add_feed(depth, "-depth", false);
    add("memory-" + size_words(full_hd),
        [=](LiveClips& all, Figures& figures) { return measure_program_memory(full_hd, all, figures); });
    add_feed(moving, "-depth", false);
    // Last, because from the first live run on this process's memory is locked.
    add_live(demo);
    add_live(full_hd);
    add("seek-" + size_words(demo) + "-" + std::to_string(seconds) + "s",
        [=](LiveClips& all, Figures& figures) {
            return measure_seek(long_clip, quick ? 100 : 1000, all, figures);
        });
    return cases;
}

}  // namespace touchable
