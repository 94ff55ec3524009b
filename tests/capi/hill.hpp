#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include "capi/touchable.h"

namespace touchable::test {

/// A hill before a wall, 64x48 pixels, millimetres; frame k is lifted by k millimetres.
class Hill {
public:
    static constexpr int width = 64, height = 48;

    static touch_camera camera() {
        touch_camera camera;
        EXPECT_EQ(touch_camera_defaults(&camera, sizeof camera), TOUCH_OK);
        camera.width = width;
        camera.height = height;
        camera.fx_px = camera.fy_px = 60;
        camera.cx_px = (width - 1) / 2.0;
        camera.cy_px = (height - 1) / 2.0;
        camera.far_m = 1;
        return camera;
    }

    explicit Hill(int lifted = 0) : codes_(static_cast<std::size_t>(width) * height) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                codes_[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] =
                    static_cast<std::uint16_t>(500 - lifted -
                                               std::lround(80 * std::exp(-std::hypot(x - 31, y - 23) / 12)));
    }

    /// It lasts as long as this.
    touch_frame frame(std::int64_t number = 0) const {
        touch_frame frame;
        EXPECT_EQ(touch_frame_defaults(&frame, sizeof frame), TOUCH_OK);
        frame.number = number;
        frame.time_ns = number * 33'000'000;
        frame.depth = {codes_.data(), 2 * width, width, height, TOUCH_U16, 1};
        return frame;
    }
    const std::vector<std::uint16_t>& codes() const { return codes_; }

private:
    std::vector<std::uint16_t> codes_;
};

/// Scene, surface and solver of frames that were pushed; ends them.
class TouchedHill {
public:
    explicit TouchedHill(const touch_solver_settings* settings = nullptr) {
        const touch_camera camera = Hill::camera();
        EXPECT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
        EXPECT_EQ(touch_surface_create(scene, nullptr, &surface, nullptr), TOUCH_OK);
        const Hill hill;
        const touch_frame frame = hill.frame();
        EXPECT_EQ(touch_surface_push(surface, &frame, nullptr), TOUCH_OK);
        touch_error error{sizeof error, 0, {}};
        EXPECT_EQ(touch_solver_create(surface, settings, &solver, &error), TOUCH_OK) << error.line;
    }
    ~TouchedHill() {
        EXPECT_EQ(touch_solver_destroy(solver), TOUCH_OK);
        EXPECT_EQ(touch_surface_destroy(surface), TOUCH_OK);
        EXPECT_EQ(touch_scene_destroy(scene), TOUCH_OK);
    }
    touch_scene scene{};
    touch_surface surface{};
    touch_solver solver{};
};

inline touch_tick tick_at(std::int64_t tick) {
    return {sizeof(touch_tick), 0, tick, tick * 1'000'000, 0, 0};
}

/// A finger that presses on the hill while it goes across.
inline touch_vec3 goal_at(std::int64_t tick) {
    const double phase = static_cast<double>(tick) / 200;
    return {0.05 * std::sin(phase), 0.02 * std::cos(phase), -0.42 - 0.03 * std::sin(3 * phase)};
}

/// What a program passes that does everything wrong, sometimes.
class SpoiledValues {
protected:
    explicit SpoiledValues(unsigned seed) : random_(seed) {}

    std::size_t upto(std::size_t count) { return random_() % count; }
    bool rarely() { return upto(8) == 0; }
    template <class Number>
    Number spoilt(Number number) {
        if (!rarely()) return number;
        using Limits = std::numeric_limits<Number>;
        const Number spoils[] = {Number{},
                                 Limits::max(),
                                 Limits::lowest(),
                                 Number(-1),
                                 Limits::quiet_NaN(),
                                 Limits::infinity(),
                                 Limits::min(),
                                 static_cast<Number>(random_())};
        return spoils[upto(std::size(spoils))];
    }
    template <class T>
    T* or_null(T* pointer) {
        return rarely() ? nullptr : pointer;
    }
    touch_error* error() {
        error_ = {static_cast<std::uint32_t>(upto(sizeof error_ + 1)), 0, {}};
        return or_null(&error_);
    }
    template <class Handle>
    Handle one_of(const std::vector<Handle>& handles) {
        if (handles.empty() || rarely()) return {spoilt(random_())};
        return handles[upto(handles.size())];
    }

    std::mt19937_64 random_;
    touch_error error_{};
};

}  // namespace touchable::test
