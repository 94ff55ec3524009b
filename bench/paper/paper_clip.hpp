#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "bench/touch/touch_case.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// What the paper's people touched: frames as stored, and the surface they are pictures of.
struct PaperClip {
    Scene scene;
    /// Depth at a pixel, before noise, rounding and heights; of the scene's semantics, scene units.
    std::function<double(double x, double y)> depth;
    /// Frames in the order of time; behind the last one come these from the first again.
    std::vector<RawFrame> frames;
    double noise_levels = 0;  ///< standard deviation of the stored depth

    /// World point of the true surface under a place of device space: metres right of and above the middle of
    /// the picture, where a metre is as long as in the depth of that middle.
    glm::dvec3 surface_at(const glm::dvec2& place) const;
};

/// The turning planet at 720x480 and 8 bits with camera B: one second of its turn, to and fro.
Result<std::shared_ptr<const PaperClip>> make_globe_clip();
/// The chest with that noise: so many frames, each with noise of its own.
std::shared_ptr<const PaperClip> make_chest_clip(double noise_levels, int frames);

/// How a clip becomes a surface.
struct PaperFilter {
    int median = 0;
    bool terraces = false, temporal = false;  ///< removed; averaged from frame to frame
    bool lazy =
        false;  ///< pixels are filtered when they are touched; each frame anew, also when it is repeated
};

/// A clip that plays: surfaces at any time from 0 on.
class PlayedClip {
public:
    /// Builds all frames, or with a lazy filter those that are in use.
    static Result<std::unique_ptr<PlayedClip>> make(std::shared_ptr<const PaperClip> clip,
                                                    const PaperFilter& filter);

    const PaperClip& clip() const { return *clip_; }
    /// With the filter.
    const Scene& scene() const { return scene_; }
    /// From its beginning; with a lazy filter pixels are filtered anew.
    void restart() { built_ = 0; }
    /// Gets the surfaces ready for `pair_at` of times up to this one, from at most 64 ms before on. Times do
    /// not go back but by `restart`.
    void play_to(std::int64_t time_ns);
    FramePair pair_at(std::int64_t time_ns) const;

private:
    PlayedClip(std::shared_ptr<const PaperClip> clip, const PaperFilter& filter);
    Result<void> build();
    const RawFrame& raw(std::int64_t number) const;
    std::size_t slot(std::int64_t number) const;

    std::shared_ptr<const PaperClip> clip_;
    Scene scene_;
    bool lazy_;
    std::unique_ptr<SurfaceBuilder> builder_;
    std::vector<SurfaceFrame> slots_;  // their vertices refer to them: never resized
    std::int64_t built_ = 0;           // lazily, since the beginning
};

}  // namespace touchable
