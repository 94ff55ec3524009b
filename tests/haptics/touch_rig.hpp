#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string_view>
#include <vector>

#include "engine/content/scenes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable::test {

/// A generated scene, frame 0 built either unquantised or from codes, and fingers on it.
class TouchRig {
public:
    enum class Depth { exact, codes };

    TouchRig(std::string_view name, const SceneOptions& options, Depth depth, int fingers = 1)
        : content_(std::move(make_scene(name, options)).value()),
          scene_(content_->scene()),
          fingers_(static_cast<std::size_t>(fingers)),
          contacts_(static_cast<std::size_t>(fingers)) {
        settings.metres_per_scene_unit = scene_.device_metres_per_unit.value_or(0.001);
        load(0, depth, frame_);
        pair.prev = pair.next = {0, 0, &frame_};
    }

    void load(std::int64_t number, Depth depth, SurfaceFrame& frame) {
        if (depth == Depth::exact) return content_->exact_frame(number, frame);
        const auto built = make_cpu_builder(scene_)->build(content_->frame(number), frame);
        ASSERT_TRUE(built);
    }

    /// One tick of one finger (or the same goal for all).
    const Contact& tick(const glm::dvec3& goal) {
        std::vector<glm::dvec3> goals(fingers_.size(), goal);
        const auto solver = TouchSolver::create(scene_, settings);
        solver.value().tick(field(), goals, fingers_, contacts_);
        return contacts_[0];
    }

    HeightField field() const { return {scene_, pair}; }
    AnalyticScene& content() { return *content_; }
    Scene& scene() { return scene_; }
    FingerState& finger(std::size_t k = 0) { return fingers_[k]; }
    void lift_fingers() { fingers_.assign(fingers_.size(), {}); }

    TouchSettings settings;
    FramePair pair;

private:
    std::unique_ptr<AnalyticScene> content_;
    Scene scene_;
    SurfaceFrame frame_;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
};

inline double length(const glm::dvec3& v) {
    return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

}  // namespace touchable::test
