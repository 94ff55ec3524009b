// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/codes_race.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>

#include "bench/surface/race.hpp"
#include "bench/surface/surface_case.hpp"

namespace touchable {
namespace {

bool agrees(const PlaneView& filtered, const SurfaceFrame& frame) {
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            if (filtered.sample(x, y) != frame.codes[frame.index(x, y)]) return false;
    return true;
}

bool all_valid(const SurfaceFrame& frame) {
    for (const TileBounds& tile : frame.tiles)
        if (tile.any_invalid) return false;
    return true;
}

/// A builder and its own slot.
struct BuiltFrames {
    explicit BuiltFrames(SurfaceBuilder& its_builder) : builder(its_builder) {}
    SurfaceBuilder& builder;
    SurfaceFrame slot;
};

bool same_frames(const SurfaceFrame& a, const SurfaceFrame& b) {
    return a.codes == b.codes && a.validity == b.validity && a.tiles == b.tiles;
}

void add_ratios(Figures& figures, const std::string& side, const std::vector<Racer>& racers,
                const FrameTimes& opencv) {
    const FrameTimes& vulkan = racers.front().times;
    figures.push_back({"median" + side + "_vs_opencv", vulkan.wall_ms / opencv.wall_ms, ""});
    figures.push_back({"median" + side + "_cpu_vs_opencv", vulkan.cpu_ms / opencv.cpu_ms, ""});
    for (std::size_t n = 1; n + 1 < racers.size(); ++n) {
        figures.push_back({racers[n].name + "_vs_opencv", racers[n].times.wall_ms / opencv.wall_ms, ""});
        figures.push_back({racers[n].name + "_cpu_vs_opencv", racers[n].times.cpu_ms / opencv.cpu_ms, ""});
    }
}

}  // namespace

double kernels_ms(const VulkanSurfaceBuilder& vulkan) {
    double sum = 0;
    for (const GpuDevice::Time& stage : vulkan.stages())
        if (stage.label != "read in" && stage.label != "read back") sum += stage.ms;
    return sum;
}

Result<void> race_for_codes(const Scene& scene, const RawFrame& raw, VulkanSurfaceBuilder& vulkan,
                            OpenCvPipeline& opencv, int rounds, Figures& figures) {
    const std::string side = std::to_string(scene.filter.median), cpu = "cpu_builder" + side;
    const auto by_choice = make_cpu_builder(scene), on_one = make_cpu_builder(scene, {1}),
               on_two = make_cpu_builder(scene, {2});
    std::deque<BuiltFrames> frames;
    std::vector<Racer> racers;
    const auto add = [&](const std::string& name, SurfaceBuilder& builder) {
        BuiltFrames& built = frames.emplace_back(builder);
        racers.push_back({name, [&raw, &built] { return built.builder.build(raw, built.slot); }});
    };
    add("codes" + side, vulkan);
    double least_kernels_ms = HUGE_VAL;  // least over all frames
    racers.front().frame = [&, &built = frames.front()]() -> Result<void> {
        if (auto done = vulkan.build(kept(raw), built.slot); !done) return done;
        least_kernels_ms = std::min(least_kernels_ms, kernels_ms(vulkan));
        return {};
    };
    add(cpu, *by_choice);
    add(cpu + "_1t", *on_one);
    add(cpu + "_2t", *on_two);

    if (auto once = race(racers, 1); !once) return once;
    for (std::size_t n = 0; n < racers.size(); ++n)
        if (!same_frames(frames[n].slot, frames[1].slot))
            return Error{ErrorKind::check, racers[n].name + " differs from the CPU builder's frame"};
    const bool with_opencv = has_opencv() && scene.filter.median > 0 && all_valid(frames[1].slot);
    if (with_opencv) {
        opencv.median();
        if (!agrees(opencv.codes(), frames[1].slot))
            return Error{ErrorKind::check, "OpenCV's median " + side + " differs from the CPU builder's"};
        racers.push_back({"opencv_median" + side, [&opencv]() -> Result<void> {
                              opencv.median();
                              return {};
                          }});
    }
    for (Racer& racer : racers) racer.times = {};  // the first frames are not representative
    if (auto raced = race(racers, rounds); !raced) return raced;
    for (const Racer& racer : racers) add_times(figures, racer.name, racer.times);
    figures.push_back({"codes" + side + "_kernels_ms", least_kernels_ms, "ms"});
    if (with_opencv) add_ratios(figures, side, racers, racers.back().times);
    return {};
}

}  // namespace touchable
