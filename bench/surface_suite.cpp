// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <vector>

#include "bench/clocks.hpp"
#include "bench/suite.hpp"
#include "bench/surface/bandwidth.hpp"
#include "bench/surface/changed_race.hpp"
#include "bench/surface/codes_race.hpp"
#include "bench/surface/drawing_race.hpp"
#include "bench/surface/eye_race.hpp"
#include "bench/surface/kernel_shelf.hpp"
#include "bench/surface/lazy_run.hpp"
#include "bench/surface/stages.hpp"
#include "bench/surface/start_up.hpp"
#include "bench/surface/surface_case.hpp"
#include "bench/surface/temporal_race.hpp"
#include "engine/base/try.hpp"
#include "engine/scene/filter_codes.hpp"

namespace touchable {
namespace {

using Kernels = std::shared_ptr<SurfaceKernels>;

/// Codes with the scene's median, and the additional data for drawing.
Result<void> measure_median(const SurfaceCase& c, const Picture& picture, int frames, const Kernels& kernels,
                            Figures& figures) {
    const int side = picture.scene.filter.median;
    const std::string what = std::to_string(side);
    TRY_ASSIGN(auto vulkan,
               make_vulkan_builder(picture.scene, kernels, plan_for(kernels->device()->facts())));
    SurfaceFrame frame;
    const std::int64_t begin = monotonic_ns();
    if (auto built = vulkan->build(kept(picture.raw), frame); !built) return built;
    const double first_ms = static_cast<double>(monotonic_ns() - begin) * 1e-6;
    OpenCvPipeline opencv(picture.scene, picture.raw);
    if (auto raced = race_for_codes(picture.scene, picture.raw, *vulkan, opencv, frames, figures); !raced)
        return wrong(c, raced.error().message);
    figures.push_back({"codes" + what + "_first_ms", first_ms, "ms"});
    if (side == 0) return {};
    if (auto raced = race_for_the_eye(c, picture, *vulkan, kernels->device(), opencv, std::max(frames / 2, 8),
                                      figures);
        !raced)
        return raced;
    if (side == 5) return {};
    const auto by_cpu = [&] { return make_cpu_builder(picture.scene); };
    if (auto raced = race_changed(picture.raw, by_cpu, std::max(frames / 6, 8), figures); !raced)
        return wrong(c, raced.error().message);
    return measure_drawing(c, picture, *vulkan, std::max(frames / 10, 1), kernels->device(), figures);
}

/// The most CPU time of a frame by Vulkan over that of the CPU builder, for all that frames are made into.
double most_over_builder(const Figures& figures) {
    double most = 0;
    const auto cpu_ms = [&](const char* what) {
        const auto found = std::ranges::find(figures, std::string(what) + "_cpu_ms", &Figure::metric);
        return found == figures.end() ? 0 : found->value;
    };
    for (const auto& [vulkan, cpu] : {std::pair{"codes3", "cpu_builder3_1t"},
                                      {"codes5", "cpu_builder5_1t"},
                                      {"positions3", "cpu_positions3_1t"},
                                      {"mesh3", "cpu_mesh3_1t"},
                                      {"terraces", "cpu_builder_terraces"}})
        if (const double by_cpu = cpu_ms(cpu); by_cpu > 0) most = std::max(most, cpu_ms(vulkan) / by_cpu);
    return most;
}

/// The kernels of a 3x3 median against a kernel that copies the bytes they need at least.
Result<void> measure_bandwidth(const SurfaceCase& c, const std::shared_ptr<GpuDevice>& device,
                               Figures& figures) {
    const auto kernels = std::ranges::find(figures, "codes3_kernels_ms", &Figure::metric);
    if (kernels == figures.end()) return Error{ErrorKind::internal, "the kernels' time is not known"};
    const double kernels_ms = kernels->value;
    TRY_ASSIGN(const auto copy, copy_bandwidth(device));
    TRY_ASSIGN(const double copy_ms, kernel_copy_ms(device, least_bytes(c)));
    figures.push_back({"codes3_mb", least_bytes(c) * 1e-6, "MB"});
    figures.push_back({"codes3_copy_ms", copy_ms, "ms"});
    figures.push_back({"copy_gb_s", copy.by_command, "GB/s"});
    figures.push_back({"kernel_copy_gb_s", copy.by_kernel, "GB/s"});
    figures.push_back({"bandwidth_pct", 100 * copy_ms / kernels_ms, "%"});
    return {};
}

/// Fewer frames for the largest, slowest cases.
int frames_of(const SurfaceCase& c, bool quick) {
    const bool large = c.width > 1920;
    return quick ? (large ? 4 : 25) : (large ? 100 : 300);
}

Result<void> measure(const SurfaceCase& c, bool quick, const Kernels& kernels, Figures& figures) {
    const int frames = frames_of(c, quick);
    Picture picture(c);
    for (const int side : {3, 5, 0}) {
        picture.scene.filter.median = side;
        if (auto done = measure_median(c, picture, frames, kernels, figures); !done) return done;
    }
    picture.scene.filter = {};
    if (has_working_codes(picture.scene))
        if (auto done = measure_terraces(c, picture, frames, kernels, figures); !done) return done;
    if (c.bits == 8 && c.width == 1920)
        if (auto done = measure_lazy_terraces(c.width, c.height, quick, figures); !done)
            return wrong(c, done.error().message);
    if (c.holes_pct > 0)
        if (auto done = measure_filling(c, picture, frames, kernels, figures); !done) return done;
    if (auto raced = race_with_temporal(c, picture, std::max(frames / 5, 3), kernels, figures); !raced)
        return raced;
    if (c.bits == 16 && c.holes_pct == 0)
        if (auto done = measure_lazy(c.width, c.height, quick, figures); !done)
            return wrong(c, done.error().message);
    if (auto done = measure_bandwidth(c, kernels->device(), figures); !done) return done;
    const bool on_gpu = kernels->device()->facts().kind != GpuKind::software;
    figures.push_back({"vulkan_cpu_vs_builder_most", most_over_builder(figures), ""});
    figures.push_back({"on_gpu", on_gpu ? 1.0 : 0.0, ""});
    figures.push_back({"mismatched_codes", 0, ""});  // a difference would have been an error
    return {};
}

}  // namespace

std::vector<BenchCase> surface_cases(bool quick) {
    const auto shelf = std::make_shared<KernelShelf>();
    std::vector<BenchCase> cases{{"1920x1080-16-start", measure_start_up}};
    for (const SurfaceCase& c : {SurfaceCase{320, 240, 8},
                                 {320, 240, 16},
                                 {720, 480, 8},
                                 {720, 480, 16},
                                 {1920, 1080, 8},
                                 {1920, 1080, 16},
                                 {1920, 1080, 16, 40},
                                 {3840, 2160, 8},
                                 {3840, 2160, 16}}) {
        if (quick && c.width > 1920 && c.bits == 8) continue;
        cases.push_back({name_of(c), [c, quick, shelf](Figures& figures) -> Result<void> {
                             TRY_ASSIGN(auto kernels, shelf->take());
                             return measure(c, quick, kernels, figures);
                         }});
    }
    for (BenchCase& c : drawing_cases(quick, [shelf] { return shelf->take(); }))
        cases.push_back(std::move(c));
    return cases;
}

}  // namespace touchable
