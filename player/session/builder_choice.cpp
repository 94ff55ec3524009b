// SPDX-License-Identifier: Apache-2.0
#include "player/session/builder_choice.hpp"

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/scene/filter_codes.hpp"
#include "player/run/terminal.hpp"

namespace touchable {

namespace {

void warn(const std::string& line) {
    say_on_stderr("warning: " + line);
}

Result<std::unique_ptr<SurfaceBuilder>> make_vulkan(const Scene& scene, RunGpu& gpu) {
    TRY_ASSIGN(auto device, gpu.open_measured(measure_builders));
    TRY_ASSIGN(auto builder, make_vulkan_builder(scene, std::move(device)));
    return make_fallback_builder(std::move(builder), make_cpu_builder(scene), warn);
}

/// CPU time of a whole frame: ns per pixel (terraces: per pixel and pass), plus frame_us, which is constant.
/// Measured on a core of an AMD EPYC (docs/measurements.md).
constexpr double decode_ns = 0.20, median3_ns = 0.38, median5_ns = 0.57, terraces_ns = 0.22,
                 temporal_ns = 0.15, frame_us = 10;

/// Opening a GPU costs about as much CPU time as one second at a fifth of a core: worth it from there on; if
/// it is open to draw, from a hundredth.
constexpr double gpu_from_ms = 200, open_gpu_from_ms = 10;

/// CPU time, all threads, ms per second of the clip, of frames by the CPU builder, without hole filling,
/// which depends on the holes.
double whole_frames_ms_per_second(const BuilderChoice::Load& load) {
    const Scene& scene = load.scene;
    const int median = scene.filter.median;
    const auto terraces = terrace_filter(scene);
    const double ns = (median == 5   ? median5_ns
                       : median == 3 ? median3_ns
                                     : decode_ns) +
                      (terraces ? terraces_ns * terraces->passes() : 0) +
                      (scene.filter.temporal ? temporal_ns : 0);
    const double pixels = static_cast<double>(scene.width) * scene.height;
    return scene.rate.per_second() * (pixels * ns * 1e-6 + frame_us * 1e-3);
}

}  // namespace

Result<std::shared_ptr<GpuDevice>> RunGpu::open() {
    const std::lock_guard lock(mutex_);
    return open_if_needed();
}

Result<std::shared_ptr<GpuDevice>> RunGpu::open_if_needed() {
    if (device_ && !device_->lost()) return device_;
    // Without a home folder there is no shader cache.
    const auto kept = own_folder("XDG_CACHE_HOME", ".cache");
    TRY_ASSIGN(device_, GpuDevice::open({.request = request_,
                                         .window_extensions = window_extensions_,
                                         .cache_folder = kept ? *kept : std::filesystem::path()}));
    if (measured_) device_->vulkan()->facts.measured = *measured_;
    return device_;
}

Result<std::shared_ptr<GpuDevice>> RunGpu::open_measured(
    const std::function<void(const std::shared_ptr<GpuDevice>&)>& measure) {
    const std::lock_guard lock(mutex_);
    TRY_ASSIGN(const auto device, open_if_needed());
    measure(device);
    measured_ = device->facts().measured;
    return open_if_needed();
}

std::optional<VulkanDevice::ProgramsToKeep> RunGpu::take_new_programs() {
    const std::lock_guard lock(mutex_);
    return device_ ? device_->vulkan()->take_new_programs() : std::nullopt;
}

std::string RunGpu::name() const {
    const std::lock_guard lock(mutex_);
    return device_ ? device_->facts().name : std::string();
}

static Result<std::unique_ptr<SurfaceBuilder>> make_plain_builder(const BuilderChoice& choice,
                                                                  const Scene& scene, RunGpu& gpu) {
    if (choice.name == "cpu") return make_cpu_builder(scene);
    if (choice.name == "lazy" && scene.filter.temporal)
        return usage_error(
            "builder lazy cannot filter in time: it knows nothing of pixels that were not touched; use "
            "another builder, or no filter in time",
            {{Setting::builder}, {Setting::temporal, "off"}});
    if (choice.name == "lazy") return make_lazy_builder(scene);
    if (choice.name == "reference") return make_reference_builder(scene);
    if (choice.name != "vulkan")
        return usage_error("builder " + choice.name + " is not known", {{Setting::builder}});
    auto vulkan = make_vulkan(scene, gpu);
    if (vulkan || !choice.gpu_fallback || vulkan.error().kind != ErrorKind::gpu) return vulkan;
    warn(vulkan.error().message + "; the cpu builder does its work");
    return make_cpu_builder(scene);
}

Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu) {
    TRY_ASSIGN(auto builder, make_plain_builder(choice, scene, gpu));
    return choice.error_bars ? with_error_bars(std::move(builder), scene) : std::move(builder);
}

bool is_fast_builder(const GpuFacts& facts) {
    const GpuFacts::Measured& measured = facts.measured;
    if (facts.kind == GpuKind::software) return false;
    return measured.vulkan_ms <= 2 * measured.cpu_ms || measured.cpu_ms < 0;
}

BuilderChoice pick_builder(const BuilderChoice::Load& load, const std::function<bool()>& gpu_is_fast) {
    if (!load.moves) return {"cpu", "the clip is a single frame"};
    const double ms = whole_frames_ms_per_second(load);
    if (ms >= (load.drawn ? open_gpu_from_ms : gpu_from_ms) && gpu_is_fast())
        return {"vulkan", formatted("on the processor it would be about %.0f ms of CPU time a second", ms)};
    return {"cpu", formatted("about %.1f ms of CPU time a second", ms)};
}

}  // namespace touchable
