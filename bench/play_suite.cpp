// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "bench/play/window_run.hpp"
#include "bench/suite.hpp"

namespace touchable {

std::vector<BenchCase> play_cases(bool quick) {
    const auto clips = std::make_shared<LiveClips>(quick ? 15 : 45);
    std::vector<BenchCase> cases;
    const auto add = [&](const std::string& name, const WindowRun& run) {
        cases.push_back({name, [=](Figures& figures) -> Result<void> {
                             auto done = measure_window(run, *clips, figures);
                             if (done) return done;
                             return Error{done.error().kind, name + ": " + done.error().message};
                         }});
    };
    for (const auto& [width, height] : {std::pair{720, 480}, std::pair{1920, 1080}})
        for (const int turned : {0, 7, 30, 70}) {
            const LiveClip clip{
                .scene = "globe", .width = width, .height = height, .frames = quick ? 120 : 600};
            const std::string name = "window-globe-" + std::to_string(width) + "x" + std::to_string(height) +
                                     "-16" + (turned == 0 ? "" : "-turned-" + std::to_string(turned));
            const auto degrees = static_cast<double>(turned);
            add(name, {.clip = clip, .turned = degrees});
            if (width == 1920)
                add(name + "-full-size", {clip, WindowRun::Use::touched, degrees, width, height});
            if (turned != 0) continue;
            add(name + "-watched", {clip, WindowRun::Use::watched});
            add(name + "-paused", {clip, WindowRun::Use::paused});
        }
    return cases;
}

}  // namespace touchable
