// SPDX-License-Identifier: Apache-2.0
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

/// Content as touched by the paper's subjects: stored frames, and the surface that they show.
struct PaperClip {
    Scene scene;
    /// Depth at a pixel, before noise, rounding and heights; in the scene's semantics, scene units.
    std::function<double(double x, double y)> depth;
    /// Frames in order of time, repeated after the last one.
    std::vector<RawFrame> frames;
    double noise_levels = 0;  ///< standard deviation of the stored depth

    /// World point of the true surface under a place of device space: metres right of and above the picture's
    /// middle, at the scale of the middle's depth.
    glm::dvec3 surface_at(const glm::dvec2& place) const;
};

/// The turning planet at 8 bits with camera B: so many frames of its turn, forward and backward, 30 a second.
Result<std::shared_ptr<const PaperClip>> make_globe_clip(int width = 720, int height = 480,
                                                         int turned_frames = 30);
/// `frames` frames of the chest with that noise, independent in each frame; `first` seeds the first one's.
std::shared_ptr<const PaperClip> make_chest_clip(double noise_levels, int frames, std::int64_t first = 0);

/// Filters from a clip to a surface.
struct PaperFilter {
    int median = 0;
    bool terraces = false, temporal = false;  ///< remove terraces; average from frame to frame
    bool lazy = false;  ///< filter pixels when touched, anew in each frame, also in repeated ones
};

/// A playing clip: surfaces at any time from 0 on.
class PlayedClip {
public:
    /// Builds all frames; with a lazy filter those in use.
    static Result<std::unique_ptr<PlayedClip>> make(std::shared_ptr<const PaperClip> clip,
                                                    const PaperFilter& filter);

    const PaperClip& clip() const { return *clip_; }
    /// With the filter.
    const Scene& scene() const { return scene_; }
    /// Builds frame n, below `slots`, anew.
    Result<void> build(std::size_t n);
    std::size_t slots() const { return slots_.size(); }
    /// Restarts the clip; with a lazy filter pixels are filtered anew.
    void restart() { built_ = 0; }
    /// Prepares the surfaces for `pair_at` of times up to this one, from at most 64 ms before. Times must not
    /// decrease except by `restart`.
    void play_to(std::int64_t time_ns);
    FramePair pair_at(std::int64_t time_ns) const;
    Result<TouchSolver> solver(TouchMetric metric) const;

private:
    PlayedClip(std::shared_ptr<const PaperClip> clip, const PaperFilter& filter);
    const RawFrame& raw(std::int64_t number) const;
    std::size_t slot(std::int64_t number) const;

    std::shared_ptr<const PaperClip> clip_;
    Scene scene_;
    bool lazy_;
    std::unique_ptr<SurfaceBuilder> builder_;
    std::vector<SurfaceFrame> slots_;  // their vertices refer to them: never resized
    std::int64_t built_ = 0;           // with a lazy filter: frames built since the beginning
};

}  // namespace touchable
