// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/frame_ring.hpp"

#include <array>
#include <cstring>

#include "bench/surface/surface_case.hpp"
#include "bench/touch/timing_run.hpp"
#include "engine/base/try.hpp"
#include "engine/content/scenes.hpp"
#include "engine/scene/plane_memory.hpp"

namespace touchable {
namespace {

constexpr int noise_blocks = 16, bumps_frames = 6;

/// `picture` with `shift` added to each code, in the range 1 to 65535.
void write_shifted(const PlaneView& picture, int shift, std::uint8_t* to, std::ptrdiff_t stride) {
    for (int y = 0; y < picture.height; ++y, to += stride)
        for (int x = 0; x < picture.width; ++x) {
            const int code = (picture.sample(x, y) + 65534 + shift) % 65535 + 1;
            const auto stored = static_cast<std::uint16_t>(code);
            std::memcpy(to + std::ptrdiff_t{2} * x, &stored, 2);
        }
}

}  // namespace

std::span<const TimedFilter> timed_filters() {
    // Noise of a close-range depth camera, in millimetres.
    static const std::array<TimedFilter, 5> choices{
        {{"none", {}},
         {"m3", {.median = 3}},
         {"m5", {.median = 5}},
         {"terraces", {.terraces = TerraceRemoval::on}},
         {"temporal", {.temporal = true, .temporal_noise = {0.2, 0}}}}};
    return choices;
}

Scene with_filter(Scene scene, const TimedFilter& filter) {
    scene.filter = filter.settings;
    return scene;
}

Result<FrameRing> FrameRing::make(const Scene& scene, const PlaneView& picture, int count,
                                  int frames_per_block) {
    FrameRing ring(scene);
    ring.scene_.filter = {};
    const std::size_t stride =
        aligned_bytes(std::size_t{2} * static_cast<std::size_t>(picture.width), plane_row_alignment);
    const std::size_t bytes =
        aligned_bytes(stride * static_cast<std::size_t>(picture.height), plane_alignment);
    std::shared_ptr<std::uint8_t> block;
    for (int n = 0; n < count; ++n) {
        const auto in_block = static_cast<std::size_t>(n % frames_per_block);
        if (in_block == 0) block = take_plane_memory(bytes * static_cast<std::size_t>(frames_per_block));
        if (!block) return Error{ErrorKind::internal, "no memory for the frames"};
        std::uint8_t* const data = block.get() + bytes * in_block;
        write_shifted(picture, n * step, data, static_cast<std::ptrdiff_t>(stride));
        ring.planes_.push_back(
            {{data, static_cast<std::ptrdiff_t>(stride), picture.width, picture.height, 2, 1}, block});
    }
    return ring;
}

RawFrame FrameRing::frame(std::int64_t number) const {
    const Plane& plane = planes_[static_cast<std::size_t>(number) % planes_.size()];
    RawFrame raw;
    raw.number = number;
    raw.depth = plane.view;
    raw.storage = plane.storage;
    return raw;
}

Result<FrameRing> ring_of_noise(int width, int height) {
    const Picture picture({width, height, 16});
    const int frames_per_block = std::max(1, 3840 * 2160 / (width * height));
    return FrameRing::make(picture.scene, picture.raw.depth, noise_blocks * frames_per_block,
                           frames_per_block);
}

Result<FrameRing> ring_of_bumps(int width, int height) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    TRY_ASSIGN(const auto content, make_scene("bumps", options));
    Scene scene = content->scene();
    scene.default_properties = timing_grip;
    const RawFrame raw = content->frame(0);
    return FrameRing::make(scene, raw.depth, bumps_frames, 1);
}

std::vector<glm::dvec3> goals_over(const FrameRing& bumps, int fingers, int ticks) {
    TouchCase c;
    c.scene = "bumps";
    c.width = bumps.scene().width;
    c.height = bumps.scene().height;
    c.fingers = fingers + 1;
    const std::vector<glm::dvec3> with_first = timing_goals(c, ticks);
    std::vector<glm::dvec3> goals;
    for (std::size_t k = 0; k < with_first.size(); ++k)
        if (k % static_cast<std::size_t>(c.fingers) > 0) goals.push_back(with_first[k]);
    return goals;
}

}  // namespace touchable
