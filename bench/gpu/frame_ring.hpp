#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// A filter that the suite `gpu` measures, by its name in case names.
struct TimedFilter {
    std::string_view name;
    FilterSettings settings;
};
/// "none", "m3", "m5", "terraces", "temporal".
std::span<const TimedFilter> timed_filters();
/// `scene` with that filter, and no other.
Scene with_filter(Scene scene, const TimedFilter& filter);

/// Distinct frames of 16 bits in plane memory, handed out in turn without end. Between a frame and the next
/// one every pixel changes.
class FrameRing {
public:
    /// Frame 0 is `picture`; frame n adds n times `step` to each of its codes. A plane block holds
    /// `frames_per_block` frames: a builder keeps the import of no more than a reader's blocks.
    static Result<FrameRing> make(const Scene& scene, const PlaneView& picture, int count,
                                  int frames_per_block);

    const Scene& scene() const { return scene_; }
    int count() const { return static_cast<int>(planes_.size()); }
    RawFrame frame(std::int64_t number) const;

private:
    static constexpr int step = 37;  // codes: less than the noise that the temporal filter averages
    explicit FrameRing(Scene scene) : scene_(std::move(scene)) {}

    struct Plane {
        PlaneView view;
        std::shared_ptr<const std::uint8_t> storage;
    };
    Scene scene_;  // without filters
    std::vector<Plane> planes_;
};

/// Frames of noise on a slope (surface_case.hpp): 16 of 3840x2160, or as many smaller ones as have as many
/// pixels.
Result<FrameRing> ring_of_noise(int width, int height);

/// 6 frames of the relief `bumps`, to be touched.
Result<FrameRing> ring_of_bumps(int width, int height);
/// The timing stroke over these frames (timing_run.hpp): tick by tick, in each so many fingers. Its first
/// finger, which comes down from above, is left out.
std::vector<glm::dvec3> goals_over(const FrameRing& bumps, int fingers, int ticks);

}  // namespace touchable
