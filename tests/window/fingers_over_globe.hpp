#pragma once

#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <optional>

#include "player/run/touch_session.hpp"
#include "player/window/pointer.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {

/// A globe in a window, and the fingers of a pointer over it.
class FingersOverGlobe : public ::testing::Test {
protected:
    using Places = std::array<glm::dvec3, PointerFingers::most>;

    FingersOverGlobe(const glm::ivec2& clip, const glm::ivec2& window)
        : width_(window.x), height_(window.y), shown_(shown_scene("globe", clip.x, clip.y)) {
        EXPECT_TRUE(device_.open());
    }
    HeightField field() const { return shown_->field(); }
    ViewCamera camera() const { return view_.camera(width_, height_); }
    /// Where the fingers are after so many ticks on their way to the goals that they have, device metres.
    Places after(int ticks) {
        Places places{};
        for (int tick = 0; tick < ticks; ++tick) EXPECT_TRUE(device_.read_positions(places));
        return places;
    }
    /// So deep, device metres, in the surface that was met.
    glm::dvec3 place_in(const ViewCamera::Pick& met, double deep_m) const {
        return met.point + met.direction * (deep_m / workspace_.metres_per_scene_unit);
    }
    /// How deep a world place is in the surface that was met on its line of sight, device metres.
    double depth_in(const ViewCamera::Pick& met, const glm::dvec3& place) const {
        return glm::dot(place - met.point, met.direction) * workspace_.metres_per_scene_unit;
    }

    int width_, height_;
    std::unique_ptr<Shown> shown_;
    Workspace workspace_ = clip_workspace(shown_->scene, shown_->prev);
    PointerDevice device_{PointerFingers::most, workspace_.to_device({0, 0, 0})};
    std::optional<PointerFingers> fingers_{std::in_place, device_, workspace_};
    WindowView view_{shown_->scene, glm::dvec3(0, 0, -80)};
};

}  // namespace touchable::test
