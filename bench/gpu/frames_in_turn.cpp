// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/frames_in_turn.hpp"

#include <algorithm>
#include <string>

#include "bench/clocks.hpp"
#include "bench/surface/codes_race.hpp"
#include "bench/surface/stages.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr int least_rounds = 2, most_rounds = 50;

double ms_between(std::int64_t begin, std::int64_t end) {
    return static_cast<double>(end - begin) * 1e-6;
}

double median_of(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void add_cost(Figures& figures, const std::string& what, const FrameCost& cost) {
    figures.push_back({what + "_ms", cost.ms, "ms"});
    figures.push_back({what + "_median_ms", cost.median_ms, "ms"});
    figures.push_back({what + "_cpu_ms", cost.cpu_ms, "ms"});
    figures.push_back({what + "_latency_ms", cost.latency_ms, "ms"});
}

}  // namespace

Result<void> FramesInTurn::finish() {
    TRY(builder_.finish(slots_[static_cast<std::size_t>(finished_) % slots_.size()]));
    ++finished_;
    if (warm_) latency_ms_.push_back(ms_between(begun_ns_.front(), monotonic_ns()));
    begun_ns_.pop_front();
    if (const auto* vulkan = dynamic_cast<const VulkanSurfaceBuilder*>(&builder_))
        kernels_ms_ = std::min(kernels_ms_, kernels_ms(*vulkan));
    return {};
}

Result<void> FramesInTurn::round() {
    // Every round ends with no frame in flight; two cycles of frames make this cost a small part of a round.
    const int frames = ring_.count() * (in_flight_ > 1 ? 2 : 1);
    const std::int64_t wall = monotonic_ns(), cpu = process_cpu_ns();
    for (int n = 0; n < frames; ++n) {
        if (begun_ - finished_ == in_flight_) TRY(finish());
        begun_ns_.push_back(monotonic_ns());
        TRY(builder_.begin(ring_.frame(begun_)));
        ++begun_;
    }
    while (finished_ < begun_) TRY(finish());
    if (std::exchange(warm_, true)) {
        round_ms_.push_back(ms_between(wall, monotonic_ns()) / frames);
        cpu_ms_ = std::min(cpu_ms_, ms_between(cpu, process_cpu_ns()) / frames);
    }
    return {};
}

FrameCost FramesInTurn::cost() const {
    FrameCost cost;
    for (const double ms : round_ms_) cost.ms = std::min(cost.ms, ms);
    cost.median_ms = median_of(round_ms_);
    cost.cpu_ms = cpu_ms_;
    cost.latency_ms = median_of(latency_ms_);
    cost.kernels_ms = kernels_ms_;
    return cost;
}

Result<void> race_in_turn(std::span<FramesInTurn* const> racers, double seconds) {
    const std::int64_t end = monotonic_ns() + static_cast<std::int64_t>(seconds * 1e9);
    for (int round = 0; round <= most_rounds; ++round) {
        if (round > least_rounds && monotonic_ns() > end) break;
        for (FramesInTurn* const racer : racers) TRY(racer->round());
    }
    return {};
}

Result<void> check_alike(const Scene& scene, const FrameRing& ring, int frames,
                         const std::shared_ptr<SurfaceKernels>& kernels) {
    const auto cpu = make_cpu_builder(scene);
    TRY_ASSIGN(const auto vulkan, make_vulkan_builder(scene, kernels, plan_for(kernels->device()->facts())));
    SurfaceFrame expected, actual;
    for (int begun = 0, finished = 0; finished < frames; ++finished) {
        for (; begun < frames && begun - finished < vulkan->frames_in_flight(); ++begun)
            TRY(vulkan->begin(ring.frame(begun)));
        TRY(vulkan->finish(actual));
        TRY(cpu->build(ring.frame(finished), expected));
        if (const long different = mismatches(expected, actual); different > 0)
            return Error{ErrorKind::check, std::to_string(different) + " codes of frame " +
                                               std::to_string(finished) + " differ from the CPU builder's"};
    }
    return {};
}

Result<void> measure_in_turn(const FrameRing& ring, const TimedFilter& filter, bool quick,
                             const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    const Scene scene = with_filter(ring.scene(), filter);
    const int checked = quick ? 4 : ring.count();
    TRY(check_alike(scene, ring, checked, kernels));
    const auto cpu = make_cpu_builder(scene);
    TRY_ASSIGN(const auto vulkan, make_vulkan_builder(scene, kernels, plan_for(kernels->device()->facts())));
    const int in_flight = vulkan->frames_in_flight();
    FramesInTurn by_cpu(*cpu, ring, 1), alone(*vulkan, ring, 1), together(*vulkan, ring, in_flight);
    std::vector<FramesInTurn*> racers{&by_cpu, &alone};
    if (in_flight > 1) racers.push_back(&together);
    TRY(race_in_turn(racers, quick ? 0.5 : 3));

    const FrameCost best = racers.back()->cost(), of_cpu = by_cpu.cost();
    add_cost(figures, "vulkan", alone.cost());
    if (in_flight > 1) add_cost(figures, "flight", best);
    add_cost(figures, "cpu_builder", of_cpu);
    figures.push_back({"in_flight", static_cast<double>(in_flight), ""});
    figures.push_back({"kernels_ms", alone.cost().kernels_ms, "ms"});
    figures.push_back({"vulkan_vs_cpu", best.ms / of_cpu.ms, ""});
    figures.push_back({"vulkan_cpu_vs_cpu", best.cpu_ms / of_cpu.cpu_ms, ""});
    figures.push_back({"checked_frames", static_cast<double>(checked), ""});
    figures.push_back({"mismatched_codes", 0, ""});  // a difference would have been an error
    return {};
}

}  // namespace touchable
