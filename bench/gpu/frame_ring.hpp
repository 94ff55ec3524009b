// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// A filter measured by the suite `gpu`, with its name in case names.
struct TimedFilter {
    std::string_view name;
    FilterSettings settings;
};
/// "none", "m3", "m5", "terraces", "temporal".
std::span<const TimedFilter> timed_filters();
/// `scene` with that filter, and no other.
Scene with_filter(Scene scene, const TimedFilter& filter);

/// Distinct frames of 16 bits in plane memory, returned in an endless cycle. Every pixel changes from each
/// frame to the next.
class FrameRing {
public:
    /// Frame 0 is `picture`; frame n adds n times `step` to each of its codes. A plane block holds
    /// `frames_per_block` frames, because a builder keeps no more imports than a reader's blocks.
    static Result<FrameRing> make(const Scene& scene, const PlaneView& picture, int count,
                                  int frames_per_block);

    const Scene& scene() const { return scene_; }
    int count() const { return static_cast<int>(planes_.size()); }
    RawFrame frame(std::int64_t number) const;

private:
    static constexpr int step = 37;  // codes; less than the noise averaged by the temporal filter
    explicit FrameRing(Scene scene) : scene_(std::move(scene)) {}

    struct Plane {
        PlaneView view;
        std::shared_ptr<const std::uint8_t> storage;
    };
    Scene scene_;  // without a filter
    std::vector<Plane> planes_;
};

/// Frames of noise on a slope (surface_case.hpp): 16 of 3840x2160, or smaller ones with the same number of
/// pixels in total.
Result<FrameRing> ring_of_noise(int width, int height);

/// 6 frames of the relief `bumps`, to be touched.
Result<FrameRing> ring_of_bumps(int width, int height);
/// The timing stroke over these frames (timing_run.hpp): all fingers of tick 0, of tick 1, ... Leaves out its
/// first finger, which comes down from above.
std::vector<glm::dvec3> goals_over(const FrameRing& bumps, int fingers, int ticks);

}  // namespace touchable
