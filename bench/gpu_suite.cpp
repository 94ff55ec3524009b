// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "bench/gpu/frames_in_turn.hpp"
#include "bench/gpu/gpu_cases.hpp"
#include "bench/gpu/live_touch.hpp"
#include "bench/live/live_clip.hpp"
#include "bench/play/window_run.hpp"
#include "bench/suite.hpp"
#include "bench/surface/drawing_race.hpp"
#include "bench/surface/kernel_shelf.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

struct TurnSize {
    int width, height;
};

/// The frames of one size, shared by the cases of all filters; frames of another size are freed before.
class RingShelf {
public:
    Result<const FrameRing*> take(const TurnSize& size) {
        if (!ring_ || ring_->scene().width != size.width) {
            ring_.reset();
            TRY_ASSIGN(auto made, ring_of_noise(size.width, size.height));
            ring_ = std::make_unique<FrameRing>(std::move(made));
        }
        return ring_.get();
    }
    void clear() { ring_.reset(); }

private:
    std::unique_ptr<FrameRing> ring_;
};

/// A window of 1920x1080 over a clip of this size: with the painter and builder chosen by `auto`, and with
/// each pair; a pair that the device cannot run has no figures.
std::vector<BenchCase> window_cases(const LiveClip& clip, bool quick,
                                    const std::shared_ptr<LiveClips>& clips) {
    std::vector<BenchCase> cases;
    const auto add = [&](const std::string& pair, const std::string& painter, const std::string& builder) {
        const WindowRun run{clip, WindowRun::Use::touched, 30, 1920, 1080, painter, builder};
        cases.push_back(
            {"window-" + std::to_string(clip.width) + "x" + std::to_string(clip.height) + "-" + pair,
             [=](Figures& figures) -> Result<void> {
                 const auto done = measure_window(run, *clips, figures);
                 if (done || done.error().kind != ErrorKind::gpu || painter == "auto") return done;
                 std::cerr << "left out: " << done.error().message << std::endl;
                 return {};
             }});
    };
    add("auto", "auto", "auto");
    if (quick) return cases;
    for (const std::string painter : {"raster", "mesh"})
        for (const std::string builder : {"vulkan", "cpu"}) add(painter + "-" + builder, painter, builder);
    return cases;
}

}  // namespace

std::vector<BenchCase> gpu_cases(bool quick) {
    const auto kernels = std::make_shared<KernelShelf>();
    const auto rings = std::make_shared<RingShelf>();
    std::vector<BenchCase> cases;
    cases.push_back({"memory", [kernels](Figures& figures) -> Result<void> {
                         TRY_ASSIGN(const auto taken, kernels->take());
                         return measure_device_memory(taken->device(), figures);
                     }});
    cases.push_back({"bus-3840x2160", [kernels](Figures& figures) -> Result<void> {
                         TRY_ASSIGN(const auto taken, kernels->take());
                         return measure_bus(taken->device(), figures);
                     }});
    for (const TurnSize& size : {TurnSize{1920, 1080}, {3840, 2160}})
        for (const TimedFilter& filter : timed_filters()) {
            if (quick && size.width > 1920 && filter.name != "m3") continue;
            cases.push_back({"turns-" + std::to_string(size.width) + "x" + std::to_string(size.height) + "-" +
                                 std::string(filter.name),
                             [=](Figures& figures) -> Result<void> {
                                 TRY_ASSIGN(const auto taken, kernels->take());
                                 TRY_ASSIGN(const FrameRing* ring, rings->take(size));
                                 return measure_in_turn(*ring, filter, quick, taken, figures);
                             }});
        }
    cases.push_back({"jitter-1920x1080-m3", [=](Figures& figures) -> Result<void> {
                         rings->clear();
                         TRY_ASSIGN(const auto taken, kernels->take());
                         return measure_jitter(1920, 1080, timed_filters()[1], quick ? 2 : 10, taken,
                                               figures);
                     }});
    cases.push_back({"pictures-1920x1080", [=](Figures& figures) -> Result<void> {
                         TRY_ASSIGN(const auto taken, kernels->take());
                         return measure_pictures_by_builder(1920, 1080, quick ? 0.5 : 3, taken, figures);
                     }});
    for (BenchCase& c : ways_cases(quick, [kernels] { return kernels->take(); }))
        cases.push_back(std::move(c));
    // Last, because from the first window on this process's memory is locked.
    const auto clips = std::make_shared<LiveClips>(4);
    for (const TurnSize& size : {TurnSize{1920, 1080}, {3840, 2160}}) {
        if (quick && size.width > 1920) continue;
        const LiveClip clip{.scene = "globe",
                            .width = size.width,
                            .height = size.height,
                            .planes = {PlaneRole::depth, PlaneRole::colour},
                            .frames = quick ? 45 : 90};
        for (BenchCase& c : window_cases(clip, quick, clips)) cases.push_back(std::move(c));
    }
    return cases;
}

}  // namespace touchable
