#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/scene/plane_memory.hpp"

// Measures the builders on the device itself: copies over the bus take many times a kernel's time on one
// machine and nothing on another, and the kind of device does not tell which.

namespace touchable {
namespace {

constexpr int race_width = 1920, race_height = 1080;
constexpr std::size_t frame_count = 4;

/// Noise of all codes, in the memory that decoders write to.
Result<std::vector<RawFrame>> noisy_frames() {
    constexpr std::size_t bytes = std::size_t{2} * race_width * race_height;
    std::vector<RawFrame> frames(frame_count);
    std::uint64_t state = 1;
    for (std::size_t n = 0; n < frame_count; ++n) {
        const std::shared_ptr<std::uint8_t> plane = take_plane_memory(bytes);
        if (!plane) return Error{ErrorKind::internal, "no memory for a frame"};
        for (std::size_t k = 0; k < bytes; k += sizeof(state)) {
            state = state * 6364136223846793005U + 1442695040888963407U;
            std::memcpy(plane.get() + k, &state, sizeof(state));
        }
        frames[n].number = static_cast<std::int64_t>(n);
        frames[n].depth = packed_plane(plane.get(), race_width, race_height, 2, 1);
        frames[n].storage = plane;
    }
    return frames;
}

bool same_frames(const SurfaceFrame& a, const SurfaceFrame& b) {
    return a.codes == b.codes && a.validity == b.validity && a.tiles == b.tiles;
}

using Slots = SurfaceFrame[2];

/// The least time of a frame, ms, after building each `warm` times; the slots then hold the last two.
Result<double> least_ms(SurfaceBuilder& builder, const std::vector<RawFrame>& frames, int warm, int timed,
                        Slots& slots) {
    double least = HUGE_VAL;
    for (int n = 0; n < warm + timed; ++n) {
        if (stop_requested()) return interrupted_error();
        for (std::size_t k = 0; k < frames.size(); ++k) {
            const auto begin = std::chrono::steady_clock::now();
            TRY(builder.build(frames[k], slots[k % 2]));
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
            if (n >= warm) least = std::min(least, took.count());
        }
    }
    return least;
}

Result<void> race(const std::shared_ptr<GpuDevice>& device, SurfacePlan plan, GpuFacts::Measured& measured) {
    TRY_ASSIGN(const auto frames, noisy_frames());
    Scene scene;
    scene.width = race_width;
    scene.height = race_height;
    scene.depth_bits = 16;
    scene.camera = {race_width, race_width, race_width / 2.0, race_height / 2.0};
    scene.depth.near = 500;
    scene.depth.far = 1500;
    scene.depth.code_max = 65535;
    scene.depth.valid_max = 65535;
    scene.filter.median = 3;

    Slots right;
    TRY_ASSIGN(measured.cpu_ms, least_ms(*make_cpu_builder(scene), frames, 1, 3, right));
    const auto kernels = std::make_shared<SurfaceKernels>(device);
    measured.over_bus_ms = HUGE_VAL;
    for (const bool over_bus : {false, true}) {
        if (over_bus && !plan.copies) break;
        plan.over_bus = over_bus;
        double& ms = over_bus ? measured.over_bus_ms : measured.vulkan_ms;
        ms = HUGE_VAL;
        TRY_ASSIGN(const auto builder, make_vulkan_builder(scene, kernels, plan));
        Slots made;
        TRY_ASSIGN(const double took, least_ms(*builder, frames, 2, 6, made));
        if (same_frames(made[0], right[0]) && same_frames(made[1], right[1])) ms = took;
    }
    return {};
}

}  // namespace

void measure_builders(const std::shared_ptr<GpuDevice>& device) {
    GpuFacts& facts = device->vulkan()->facts;
    const SurfacePlan plan = plan_for(facts);
    if (facts.kind == GpuKind::software || !plan.blocks || facts.measured.cpu_ms >= 0 ||
        std::getenv("TOUCHABLE_GPU_PLAN") != nullptr)
        return;
    GpuFacts::Measured measured;
    // A device that the race lost is not measured again. After missing memory or a stop it is.
    if (!race(device, plan, measured) && !device->lost()) return;
    facts.measured.cpu_ms = measured.cpu_ms;
    facts.measured.vulkan_ms = measured.vulkan_ms;
    facts.measured.over_bus_ms = measured.over_bus_ms;
}

}  // namespace touchable
