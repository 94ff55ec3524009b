// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "bench/touch/touch_case.hpp"
#include "engine/scene/frames.hpp"
#include "tests/content/exact_touch.hpp"

namespace touchable {

/// The built frames of a case's scene: one if it is still; for `moving` 60, the two seconds after which it
/// repeats.
class TouchSurface {
public:
    static Result<std::unique_ptr<const TouchSurface>> make(const TouchCase& c);
    TouchSurface(const TouchSurface&) = delete;
    TouchSurface& operator=(const TouchSurface&) = delete;

    const ExactSurface& exact() const { return exact_; }
    /// With the case's filter.
    const Scene& scene() const { return scene_; }
    bool moves() const { return frames_.size() > 1; }
    /// The frames around a time from 0 on.
    FramePair pair_at(std::int64_t time_ns) const;

private:
    TouchSurface(std::unique_ptr<AnalyticScene> content, const TouchCase& c);
    Result<void> build(const TouchCase& c);

    std::unique_ptr<AnalyticScene> content_;
    ExactSurface exact_;
    Scene scene_;
    std::vector<SurfaceFrame> frames_;  // their vertices refer to them: never resized
};

/// Caches the surface made last, because adjacent cases of a suite often share it.
class SurfaceShelf {
public:
    /// Valid until the next call.
    Result<const TouchSurface*> take(const TouchCase& c);

private:
    TouchCase made_for_;
    std::unique_ptr<const TouchSurface> surface_;
};

}  // namespace touchable
