// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include "capi/touchable.h"

namespace touchable::test {

inline touch_error no_error() {
    return {sizeof(touch_error), 0, {}};
}

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
    std::vector<float> metres() const {
        std::vector<float> metres;
        for (const std::uint16_t code : codes_) metres.push_back(static_cast<float>(code) * 0.001F);
        return metres;
    }
    /// Depth of the hill's size; it lasts as long as the floats.
    static touch_plane plane_of(const std::vector<float>& metres) {
        return {metres.data(), 4 * width, width, height, TOUCH_F32, 1};
    }

private:
    std::vector<std::uint16_t> codes_;
};

inline touch_tick tick_at(std::int64_t tick) {
    return {sizeof(touch_tick), 0, tick, tick * 1'000'000, 0, 0};
}

/// A finger that presses on the hill while it goes across.
inline touch_vec3 goal_at(std::int64_t tick) {
    const double phase = static_cast<double>(tick) / 200;
    return {0.05 * std::sin(phase), 0.02 * std::cos(phase), -0.42 - 0.03 * std::sin(3 * phase)};
}

/// Scene, surface and solver of frames that were pushed; ends them.
class TouchedHill {
public:
    explicit TouchedHill(const touch_solver_settings* settings = nullptr) {
        const touch_camera camera = Hill::camera();
        EXPECT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
        EXPECT_EQ(touch_surface_create(scene, nullptr, &surface, nullptr), TOUCH_OK);
        EXPECT_EQ(push(Hill().frame()), TOUCH_OK);
        touch_error error = no_error();
        EXPECT_EQ(touch_solver_create(surface, settings, &solver, &error), TOUCH_OK) << error.line;
    }
    ~TouchedHill() {
        EXPECT_EQ(touch_solver_destroy(solver), TOUCH_OK);
        EXPECT_EQ(touch_surface_destroy(surface), TOUCH_OK);
        EXPECT_EQ(touch_scene_destroy(scene), TOUCH_OK);
    }
    touch_status push(const touch_frame& frame, touch_error* error = nullptr) const {
        return touch_surface_push(surface, &frame, error);
    }
    touch_status tick(std::int64_t number, const touch_vec3& goal) {
        const touch_tick at = tick_at(number);
        return touch_solver_tick(solver, &at, &goal, &contact, sizeof contact);
    }
    touch_status tick(std::int64_t number) { return tick(number, goal_at(number)); }
    std::uint64_t hash() const {
        std::uint64_t hash = 0;
        EXPECT_EQ(touch_solver_force_hash(solver, &hash), TOUCH_OK);
        return hash;
    }

    touch_scene scene{};
    touch_surface surface{};
    touch_solver solver{};
    touch_contact contact{};  ///< of the last tick
};

/// Arguments of a program that sometimes does everything wrong.
class SpoiledValues {
public:
    using Statuses = std::array<int, 256>;
    /// How often each status was given.
    template <class Program>
    static void count_statuses(Program& program, Statuses& seen) {
        for (int k = 0; k < 1000; ++k) {
            const touch_status status = program.call();
            ASSERT_STRNE(touch_status_name(status), "unknown status");
            ASSERT_NE(status, TOUCH_INTERNAL);
            ++seen[static_cast<std::size_t>(status)];
        }
    }
    static void expect_seen(const Statuses& seen, std::initializer_list<touch_status> wanted, int least_ok) {
        for (const touch_status status : wanted)
            EXPECT_GT(seen[static_cast<std::size_t>(status)], 10) << touch_status_name(status);
        EXPECT_GT(seen[TOUCH_OK], least_ok) << "hardly anything was called as it should be";
    }

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
    template <class... Numbers>
    void spoil(Numbers&... numbers) {
        ((numbers = spoilt(numbers)), ...);
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

    /// Keeps what was made.
    template <class Handle>
    static touch_status kept(touch_status status, const Handle& made, std::vector<Handle>& handles) {
        if (status == TOUCH_OK) handles.push_back(made);
        return status;
    }

    std::mt19937_64 random_;
    touch_error error_{};
};

}  // namespace touchable::test
