// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/view/view.hpp"

// Measures which painter is faster on a device: a graphics card's hardware draws triangles fast, a data
// centre's GPU has little of it and draws ten times as fast by compute.

namespace touchable {
namespace {

constexpr int painted_width = 1920, painted_height = 1080;

/// Hills, and cliffs between them.
std::vector<std::uint16_t> codes_of_hills() {
    std::vector<std::uint16_t> codes;
    codes.reserve(std::size_t{painted_width} * painted_height);
    for (int y = 0; y < painted_height; ++y)
        for (int x = 0; x < painted_width; ++x) {
            const double hill = std::sin(x / 60.0) * std::sin(y / 60.0);
            codes.push_back(static_cast<std::uint16_t>(32000 + 8000 * hill + (hill > 0.5 ? 8000 : 0)));
        }
    return codes;
}

/// Measures the time from a new surface's codes to a picture from the side, ms.
class Race {
public:
    explicit Race(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}

    Result<void> open() {
        scene_.width = painted_width;
        scene_.height = painted_height;
        scene_.depth_bits = 16;
        scene_.camera = {painted_width, painted_width, painted_width / 2.0, painted_height / 2.0};
        scene_.depth.near = 500;
        scene_.depth.far = 1500;
        scene_.depth.code_max = scene_.depth.valid_max = 65535;
        const std::vector<std::uint16_t> codes = codes_of_hills();
        RawFrame raw;
        raw.depth = plane_of_codes(codes.data(), painted_width, painted_height);
        TRY_ASSIGN(builder_, make_vulkan_builder(scene_, device_));
        TRY(builder_->build(raw, frame_));
        return assign(target_, GpuImage::create(*device_, "picture", painted_width, painted_height,
                                                VK_FORMAT_R8G8B8A8_UNORM));
    }

    /// The minimum over several pictures.
    Result<double> least_ms(std::string_view painter) {
        constexpr int warm = 1, timed = 4;
        TRY_ASSIGN(const auto drawing, SurfaceDrawing::create(device_, painter));
        const FramePair pair{{0, 0, &frame_}, {1, 33'333'333, &frame_}, 0.5};
        const HeightField field(scene_, pair);
        const ViewCamera camera = make_view({false, 30, 8, 1, std::nullopt}, scene_, subject_of(field).middle,
                                            painted_width, painted_height);
        double least = HUGE_VAL;
        for (int n = 0; n < warm + timed; ++n) {
            if (stop_requested()) return interrupted_error();
            const auto begin = std::chrono::steady_clock::now();
            TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "painter race", GpuTiming::none));
            TRY(drawing->show(commands, field, pair, {}, Lighting::full, 1));
            TRY(drawing->draw(commands, camera, {}, {}, target_));
            TRY(std::move(commands).run());
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
            if (n >= warm) least = std::min(least, took.count());
        }
        return least;
    }

private:
    std::shared_ptr<GpuDevice> device_;
    Scene scene_;
    SurfaceFrame frame_;
    std::unique_ptr<SurfaceBuilder> builder_;
    GpuImage target_;
};

}  // namespace

std::string_view usual_painter(const GpuFacts& facts) {
    if (facts.kind == GpuKind::software) return "cpu";
    if (!facts.draws_triangles || !facts.int64_atomics) return facts.draws_triangles ? "mesh" : "raster";
    const double mesh_ms = facts.measured.mesh_ms, raster_ms = facts.measured.raster_ms;
    const bool is_measured = mesh_ms >= 0 && raster_ms >= 0;
    return std::isinf(mesh_ms) || (is_measured && raster_ms < mesh_ms) ? "raster" : "mesh";
}

void measure_painters(const std::shared_ptr<GpuDevice>& device) {
    GpuFacts& facts = device->vulkan()->facts;
    GpuFacts::Measured& measured = facts.measured;
    if (facts.kind == GpuKind::software || measured.mesh_ms >= 0 || !facts.draws_triangles ||
        !facts.int64_atomics)
        return;
    Race race(device);
    if (!race.open()) return;
    // If mesh loses the device, it is never chosen there again. Lack of memory or an interruption is no
    // result.
    const auto mesh = race.least_ms("mesh");
    if (!mesh) {
        if (device->lost()) measured.mesh_ms = HUGE_VAL;
        return;
    }
    const auto raster = race.least_ms("raster");
    if (!raster && !device->lost()) return;
    measured.mesh_ms = *mesh;
    measured.raster_ms = raster ? *raster : HUGE_VAL;
}

}  // namespace touchable
