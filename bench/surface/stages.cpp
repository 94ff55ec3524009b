// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/stages.hpp"

#include <algorithm>
#include <cmath>

#include "bench/clocks.hpp"
#include "bench/surface/opencv_pipeline.hpp"
#include "bench/surface/race.hpp"
#include "engine/base/try.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/view/view.hpp"

namespace touchable {
namespace {

template <class Work>
Result<FrameTimes> least_times(int repeats, Work&& work) {
    FrameTimes times;
    for (int n = 0; n < repeats; ++n) {
        const std::int64_t wall = monotonic_ns(), cpu = process_cpu_ns();
        if (Result<void> done = work(); !done) return done.error();
        times.wall_ms = std::min(times.wall_ms, static_cast<double>(monotonic_ns() - wall) * 1e-6);
        times.cpu_ms = std::min(times.cpu_ms, static_cast<double>(process_cpu_ns() - cpu) * 1e-6);
    }
    return times;
}

Result<FrameTimes> time_frames(SurfaceBuilder& builder, const RawFrame& raw, SurfaceFrame& out, int frames) {
    return least_times(frames, [&] { return builder.build(raw, out); });
}

}  // namespace

long mismatches(const SurfaceFrame& expected, const SurfaceFrame& actual) {
    if (expected.codes.size() != actual.codes.size()) return static_cast<long>(expected.codes.size());
    long different = 0;
    for (std::size_t n = 0; n < expected.codes.size(); ++n) different += expected.codes[n] != actual.codes[n];
    return different + (expected.validity == actual.validity ? 0 : 1) +
           (expected.tiles == actual.tiles ? 0 : 1);
}

Result<void> measure_filling(const SurfaceCase& c, const Picture& picture, int frames,
                             const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    Scene scene = picture.scene;
    scene.filter = {3, 16};
    auto vulkan = make_vulkan_builder(scene, kernels, plan_for(kernels->device()->facts()));
    if (!vulkan) return vulkan.error();
    SurfaceFrame expected, frame;
    if (auto built = make_cpu_builder(scene)->build(picture.raw, expected); !built) return built;
    if (auto built = (*vulkan)->build(picture.raw, frame); !built) return built;
    if (mismatches(expected, frame) > 0) return wrong(c, "filled codes differ from the CPU builder's");
    const auto times = time_frames(**vulkan, picture.raw, frame, frames);
    if (!times) return times.error();
    add_times(figures, "filled3", *times);
    return {};
}

namespace {

/// Names contain larger reaches: "terraces128".
Result<void> measure_terraces_within(int reach, const SurfaceCase& c, const Picture& picture, int frames,
                                     const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    Scene scene = picture.scene;
    scene.filter = {.terraces = TerraceRemoval::on, .terrace_reach = reach};
    const std::string name = "terraces" + (reach > least_terrace_reach ? std::to_string(reach) : "");
    const auto cpu = make_cpu_builder(scene);
    auto vulkan = make_vulkan_builder(scene, kernels, plan_for(kernels->device()->facts()));
    if (!vulkan) return vulkan.error();
    SurfaceFrame expected, frame;
    if (auto built = cpu->build(picture.raw, expected); !built) return built;
    if (auto built = (*vulkan)->build(picture.raw, frame); !built) return built;
    if (mismatches(expected, frame) > 0)
        return wrong(c, "codes without terraces differ from the CPU builder's");
    TRY_ASSIGN(const FrameTimes by_vulkan, time_frames(**vulkan, picture.raw, frame, frames));
    add_times(figures, name, by_vulkan);
    for (const GpuDevice::Time& stage : (*vulkan)->stages())
        if (std::string_view(stage.label) == "terraces")
            figures.push_back({name + "_kernels_ms", stage.ms, "ms"});
    scene.filter.median = 5;
    OpenCvPipeline opencv(scene, picture.raw);
    std::vector<Racer> racers{{"cpu_builder_" + name, [&] { return cpu->build(picture.raw, expected); }},
                              {"opencv_median5", [&]() -> Result<void> {
                                   opencv.median();
                                   return {};
                               }}};
    TRY(race(racers, frames));
    const FrameTimes &by_cpu = racers[0].times, &median = racers[1].times;
    add_times(figures, racers[0].name, by_cpu);
    figures.push_back({name + "_vs_builder", by_vulkan.wall_ms / by_cpu.wall_ms, ""});
    if (has_opencv())
        figures.push_back({racers[0].name + "_cpu_vs_opencv", by_cpu.cpu_ms / median.cpu_ms, ""});
    return {};
}

}  // namespace

Result<void> measure_terraces(const SurfaceCase& c, const Picture& picture, int frames,
                              const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    for (int reach = least_terrace_reach; reach <= most_terrace_reach; reach *= 2)
        if (auto done = measure_terraces_within(reach, c, picture, frames, kernels, figures); !done)
            return done;
    return {};
}

Result<void> measure_drawing(const SurfaceCase& c, const Picture& picture, SurfaceBuilder& builder,
                             int frames, const std::shared_ptr<GpuDevice>& device, Figures& figures) {
    if (!device->facts().int64_atomics) return {};
    const auto painter = make_raster_painter(device);
    if (!painter) return painter.error();
    SurfaceFrame frame;
    if (auto built = builder.build(picture.raw, frame); !built) return built;
    const HeightField field(picture.scene, still(frame));
    const ViewSurface surface = surface_of(field, still(frame), {}, Lighting::full);
    const ViewCamera camera = own_view(picture.scene, c.width, c.height, picture.scene.depth.near / 2);
    const auto twin = make_cpu_painter()->paint(surface, camera);
    if (!twin) return twin.error();
    Result<PicturePlanes> drawn = (*painter)->paint(surface, camera);
    if (!drawn) return drawn.error();
    std::size_t covered = 0, different = 0;
    for (std::size_t k = 0; k < twin->z.size(); ++k) {
        covered += twin->z[k] > 0;
        different += !(std::fabs(twin->z[k] - drawn->z[k]) <= 1e-6F);
    }
    if (different > covered / 1000)
        return wrong(c, std::to_string(different) + " pixels of " + std::to_string(covered) +
                            " are not drawn as by the cpu painter");
    const auto times = least_times(frames, [&]() -> Result<void> {
        drawn = (*painter)->paint(surface, camera);
        if (!drawn) return drawn.error();
        return {};
    });
    if (!times) return times.error();
    add_times(figures, "draw", *times);
    return {};
}

}  // namespace touchable
