// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/temporal_race.hpp"

#include <deque>
#include <memory>
#include <string_view>
#include <utility>

#include "bench/surface/race.hpp"
#include "bench/surface/stages.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {
namespace {

/// A builder and its last frame. Frames are numbered consecutively, as in a clip.
struct Contender {
    Contender(std::string its_name, std::unique_ptr<SurfaceBuilder> its_builder, const RawFrame& its_raw)
        : name(std::move(its_name)), builder(std::move(its_builder)), raw(its_raw) {}

    std::string name;
    std::unique_ptr<SurfaceBuilder> builder;
    RawFrame raw;
    SurfaceFrame frame;

    Result<void> next() {
        auto built = builder->build(raw, frame);
        ++raw.number;
        return built;
    }
};

/// Builds two frames with each; those with the filter must be equal.
Result<void> check_alike(const SurfaceCase& c, std::deque<Contender>& all) {
    for (int n = 0; n < 2; ++n) {
        for (Contender& contender : all)
            if (auto built = contender.next(); !built) return built;
        for (std::size_t k = 2; k < all.size(); k += 2)
            if (mismatches(all[0].frame, all[k].frame) > 0)
                return wrong(c, all[k].name + ": codes differ from the CPU builder's");
    }
    return {};
}

}  // namespace

Result<void> race_with_temporal(const SurfaceCase& c, const Picture& picture, int frames,
                                const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    for (const int side : {0, 3, 5}) {
        Scene off = picture.scene;
        off.filter = {.median = side};
        Scene on = off;
        on.filter.temporal = true;
        on.filter.temporal_noise = {1, 2e-6};
        const SurfacePlan plan = plan_for(kernels->device()->facts());
        auto vulkan_on = make_vulkan_builder(on, kernels, plan),
             vulkan_off = make_vulkan_builder(off, kernels, plan);
        if (!vulkan_on) return vulkan_on.error();
        if (!vulkan_off) return vulkan_off.error();
        const VulkanSurfaceBuilder& vulkan = **vulkan_on;
        const std::string what = "temporal" + std::to_string(side);
        std::deque<Contender> all;  // each with the filter, followed by the same without
        for (const int threads : {1, 2}) {
            const std::string name = what + "_cpu_builder_" + std::to_string(threads) + "t";
            all.emplace_back(name, make_cpu_builder(on, {threads}), picture.raw);
            all.emplace_back(name + "_off", make_cpu_builder(off, {threads}), picture.raw);
        }
        all.emplace_back(what, std::move(*vulkan_on), picture.raw);
        all.emplace_back(what + "_off", std::move(*vulkan_off), picture.raw);
        if (auto alike = check_alike(c, all); !alike) return alike;
        std::vector<Racer> racers;
        for (Contender& contender : all)
            racers.push_back({contender.name, [&contender] { return contender.next(); }});
        if (auto raced = race(racers, frames); !raced) return raced;
        for (std::size_t k = 0; k < racers.size(); k += 2) {
            add_times(figures, racers[k].name, racers[k].times);
            figures.push_back({racers[k].name + "_added_cpu_ms",
                               racers[k].times.cpu_ms - racers[k + 1].times.cpu_ms, "ms"});
        }
        for (const GpuDevice::Time& stage : vulkan.stages())
            if (std::string_view(stage.label) == "temporal")
                figures.push_back({what + "_kernel_ms", stage.ms, "ms"});
    }
    return {};
}

}  // namespace touchable
