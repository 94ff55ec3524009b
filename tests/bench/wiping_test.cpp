// SPDX-License-Identifier: Apache-2.0
// A wiping hand's forces beside the solver's: a made-up record whose answer is known, and the real ones.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "bench/real/wiping.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "tests/must.hpp"
#include "tests/real_data.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

using test::must;

constexpr double wiped_friction = 0.2, wiping_tool_kg = 1.1, wiping_radius = 0.06;

/// A tool that comes down to a leaning plane, wipes circles with 18 to 22 N, and rises: 100 rows a second.
/// The surface's normal is `dome` per metre from the middle off the plane's.
struct MadeWiping {
    double dome = 0;
    glm::dvec3 out = glm::normalize(glm::dvec3(0.5, -0.3, 0.8));

    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), out)),
                     ahead = glm::cross(out, right);
    const glm::dvec3 middle{-0.5, 0.2, 0.4};

    static double height(double t) {
        const double s = std::clamp(std::min(2.5 - t, 1.0), 0.0, 1.0) + std::clamp(t - 8, 0.0, 1.0);
        return 0.25 * s * s * s * (10 + s * (6 * s - 15));
    }
    glm::dvec3 from_middle(double t) const {
        return wiping_radius * (std::cos(2.2 * t) * right + std::sin(2.2 * t) * ahead);
    }
    glm::dvec3 place(double t) const { return middle + from_middle(t) + height(t) * out; }
    glm::dquat turn(double t) const {
        return glm::quat_cast(glm::dmat3(right, -ahead, -out)) *
               glm::angleAxis(0.3 * std::sin(1.1 * t), glm::dvec3(1, 0, 0)) *
               glm::angleAxis(0.5 + 0.8 * std::sin(0.7 * t), glm::dvec3(0, 0, 1));
    }
    glm::dvec3 reading(double t) const {
        constexpr double step = 1e-3;
        const glm::dvec3 motion = (place(t + step) - place(t - step)) / (2 * step);
        const glm::dvec3 acceleration = (place(t + step) - 2.0 * place(t) + place(t - step)) / (step * step);
        glm::dvec3 force = wiping_tool_kg * (glm::dvec3(0, 0, -9.81) - acceleration);
        if (height(t) == 0)
            force += (20 + 2 * std::sin(1.7 * t)) *
                     (out + dome * from_middle(t) - wiped_friction * glm::normalize(motion));
        // The sensor was set to zero at the beginning, and is half a turn off the tool.
        const glm::dvec3 zero = glm::inverse(turn(0)) * glm::dvec3(0, 0, 9.81 * wiping_tool_kg);
        return glm::dvec3(-1, -1, 1) * (glm::inverse(turn(t)) * force + zero);
    }

    std::string csv() const {
        std::string text = "t_s,x_m,y_m,z_m,q0,q1,q2,q3,fx_N,fy_N,fz_N\n";
        for (int row = 0; row < 1050; ++row) {
            const double t = 0.01 * row;
            // The sensor begins late, as in one of the real records.
            const glm::dvec3 p = place(t), f = row < 50 ? glm::dvec3(-2.3, -1.1, 0) : reading(t);
            const glm::dquat q = row < 600 ? turn(t) : -turn(t);  // the same turn
            char line[300];
            std::snprintf(line, sizeof line, "%.2f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f\n", t,
                          p.x, p.y, p.z, q.w, q.x, q.y, q.z, f.x, f.y, f.z);
            text += line;
        }
        return text;
    }
};

WipingRecord made_record(const MadeWiping& made) {
    return must(read_wiping(test::TemporaryFile("wiping.csv", made.csv()).path()));
}

double wiping_figure(const Figures& figures, const std::string& metric) {
    for (const Figure& figure : figures)
        if (figure.metric == metric) return figure.value;
    ADD_FAILURE() << "no " << metric;
    return NAN;
}

TEST(Wiping, ToolAndFrictionAreFound) {
    for (const glm::dvec3 out : {MadeWiping().out, -MadeWiping().out}) {
        const WipingRecord record = made_record({.out = out});
        EXPECT_LT(record.plane_mm, 0.1);
        EXPECT_NEAR(record.tool_kg, wiping_tool_kg, 0.01);
        EXPECT_NEAR(record.friction, wiped_friction, 0.002);
        // From 0.1 s after the first contact to 0.1 s before the last.
        for (std::size_t k = 2600; k < 7900; ++k) {
            const WipingRecord::Tick& tick = record.ticks[k];
            ASSERT_TRUE(tick.wiped) << k;
            const glm::dvec3 friction = -wiped_friction * glm::normalize(tick.velocity);
            ASSERT_LT(degrees_between(tick.surface, glm::dvec3(0, 0, 1) + friction), 0.5) << k;
            ASSERT_NEAR(tick.surface.z, 20, 2.1) << k;
        }
        EXPECT_FALSE(record.ticks[2300].pressed || record.ticks[8200].pressed);
    }
}

TEST(Wiping, ForcesAgreeOnPlane) {
    Figures figures;
    must(measure_wiping(made_record({}), 0, figures));
    const auto figure = [&](const char* metric) { return wiping_figure(figures, metric); };
    const double cone = std::atan(wiped_friction) * 180 / pi;
    EXPECT_NEAR(figure("cone_measured_deg_median"), cone, 0.1);
    EXPECT_NEAR(figure("cone_exerted_deg_median"), cone, 0.5);
    EXPECT_LT(figure("against_motion_measured_deg_p90"), 0.5);
    // The proxy follows the goal on a string of friction times depth, which is tangent to its circle.
    const double string = wiped_friction * 20 / 600;
    EXPECT_NEAR(figure("against_motion_exerted_deg_median"), std::asin(string / wiping_radius) * 180 / pi,
                0.7);
    EXPECT_LT(figure("force_angle_deg_p90"), 2);
    EXPECT_LT(figure("force_angle_shaped_deg_p90"), 2);
    EXPECT_NEAR(figure("force_angle_others_deg_median"), cone, 0.5) << "without friction";
    EXPECT_GT(figure("force_angle_reading_deg_median"), 5) << "the tool leans, and its weight with it";
    EXPECT_LT(figure("normal_off_n_median"), 0.1);
    EXPECT_EQ(figure("contact_lost_ticks"), 0);
    EXPECT_NEAR(figure("compared_pct"), 100 * 5.5 / 10.5, 2);
}

TEST(Wiping, DomeIsNoPlane) {
    Figures figures;
    must(measure_wiping(made_record({.dome = 1.5}), 0, figures));
    EXPECT_NEAR(wiping_figure(figures, "dome_per_m"), 1.5, 0.05);
    EXPECT_GT(wiping_figure(figures, "force_angle_deg_median"), 5) << "1.5 x 60 mm is 5.1 degrees";
    EXPECT_LT(wiping_figure(figures, "force_angle_shaped_deg_median"), 2);
}

TEST(Wiping, RefusesRecordWithoutContact) {
    MadeWiping lifted;
    std::string text = lifted.csv();
    text.resize(text.find("\n2.") + 1);
    const test::TemporaryFile file("lifted.csv", text);
    test::expect_error(read_wiping(file.path()), "presses with 10 N or more for 0 ms; must be 500 or more");
}

TEST(Wiping, ForcesOfAnotherHandAreTold) {
    const auto folder = test::real_data("haptics/epfl_wiping");
    TOUCHABLE_NEEDS_DATA(folder);
    for (const int number : {0, 1, 2, 3}) {
        Figures figures;
        must(measure_demonstration(folder, number, figures));
        const bool own = number < 3;
        EXPECT_EQ(wiping_figure(figures, "tool_kg") > 0.4, own) << number;
        EXPECT_EQ(wiping_figure(figures, "force_angle_shaped_deg_median") < 4, own) << number;
    }
}

}  // namespace
}  // namespace touchable
