#pragma once

#include <algorithm>

#include "tests/stress/drawn_scene.hpp"
#include "tests/stress/stress_run.hpp"

namespace touchable::stress {

/// One picture that stands still, and a hand that is up to the suite. All fingers have the same goal.
class StillRun : public StressRun {
public:
    StillRun(const Scene& scene, const DrawnPlanes& planes) : StillRun(scene) { show(planes); }
    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) final {
        pair.prev = pair.next = {0, 0, &frame_};
        pair.blend = 0;
        std::fill(goals.begin(), goals.end(), goal(tick));
    }

protected:
    /// Without a picture yet.
    explicit StillRun(const Scene& scene) : StressRun(scene) {}
    void show(const DrawnPlanes& planes) { FrameMaker(scene_).build(planes, frame_); }
    virtual glm::dvec3 goal(std::int64_t tick) = 0;

    SurfaceFrame frame_;
};

}  // namespace touchable::stress
