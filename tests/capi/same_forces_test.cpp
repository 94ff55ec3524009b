// The C API gives the forces of the rooms behind it, to the bit: same frames, goals and times.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "capi/api_common.hpp"
#include "capi/touchable.hpp"
#include "engine/content/scenes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/capi/hill.hpp"
#include "tests/frame/allocations.hpp"

namespace touchable::test {
namespace {

constexpr int fingers = 3;
constexpr std::int64_t ticks = 400;

/// Frames of a moving scene with all planes, and a path over it.
class Globe {
public:
    Globe() {
        SceneOptions options;
        options.width = 96;
        options.height = 64;
        options.properties = true;
        auto made = make_scene("globe", options);
        EXPECT_TRUE(made);
        analytic_ = std::move(*made);
        for (std::int64_t n = 0; n * 33 < ticks + 40; ++n) frames_.push_back(analytic_->frame(n));
    }
    const Scene& scene() const { return analytic_->scene(); }
    std::int64_t frames() const { return static_cast<std::int64_t>(frames_.size()); }
    const RawFrame& frame(std::int64_t n) const { return frames_[static_cast<std::size_t>(n)]; }
    double hand_scale() const { return *scene().device_metres_per_unit; }
    glm::dvec3 goal(std::int64_t tick, int finger) const {
        const double phase = static_cast<double>(tick) / 130 + finger;
        const double deep = scene().depth.far * 0.45 + scene().depth.near * 0.55;
        return {0.1 * deep * std::sin(phase), 0.1 * deep * std::cos(phase),
                -deep * (1 + 0.1 * std::sin(2 * phase))};
    }

private:
    std::unique_ptr<AnalyticScene> analytic_;
    std::vector<RawFrame> frames_;
};

std::uint64_t forces_of_the_rooms(const Globe& globe) {
    const Scene& scene = globe.scene();
    auto builder = make_reference_builder(scene);
    SurfaceTimeline timeline(4);
    TouchSettings settings;
    settings.metres_per_scene_unit = globe.hand_scale();
    const auto solver = TouchSolver::create(scene, settings);
    EXPECT_TRUE(solver);
    TouchStep step(*solver, GuardSettings{}, fingers);
    ForceHash hash;
    FramePair pair;
    std::int64_t next = 0;
    for (std::int64_t tick = 0; tick < ticks; ++tick) {
        while (next < globe.frames() && timeline.newest_time() <= tick * 1'000'000) {
            const RawFrame raw = globe.frame(next++);
            EXPECT_TRUE(builder->build(raw, *timeline.acquire()));
            EXPECT_TRUE(timeline.publish(raw.number, raw.time_ns));
        }
        timeline.pair_at(tick * 1'000'000, pair);
        for (int k = 0; k < fingers; ++k) step.goals()[static_cast<std::size_t>(k)] = globe.goal(tick, k);
        for (const GuardedForce& force : step.run(tick, tick * 1'000'000, scene, pair).forces)
            hash.add(force.force);
    }
    return hash.value();
}

struct Touched {
    std::uint64_t hash = 0;
    double most = 0;
    std::size_t allocations = 0;  ///< in ticks
};

Touched forces_of_the_api(const Globe& globe, int threads) {
    const std::string text = scene_to_json(globe.scene());
    touch_error error{sizeof error, 0, {}};
    touch_scene scene{};
    EXPECT_EQ(touch_scene_from_text(text.data(), text.size(), &scene, &error), TOUCH_OK) << error.line;
    touch_surface_settings shape;
    touch_surface_settings_defaults(&shape, sizeof shape);
    shape.threads = threads;
    touch_surface surface{};
    EXPECT_EQ(touch_surface_create(scene, &shape, &surface, &error), TOUCH_OK) << error.line;
    touch_solver_settings settings;
    touch_solver_settings_defaults(&settings, sizeof settings);
    settings.fingers = fingers;
    settings.metres_per_scene_unit = globe.hand_scale();
    touch_solver solver{};
    EXPECT_EQ(touch_solver_create(surface, &settings, &solver, &error), TOUCH_OK) << error.line;
    Touched touched;
    std::int64_t next = 0;
    for (std::int64_t tick = 0; tick < ticks; ++tick) {
        std::int64_t newest = 0;
        while (touch_surface_newest_ns(surface, &newest),
               next < globe.frames() && newest <= tick * 1'000'000) {
            const RawFrame raw = globe.frame(next++);
            touch_frame frame;
            touch_frame_defaults(&frame, sizeof frame);
            frame.number = raw.number;
            frame.time_ns = raw.time_ns;
            frame.depth = capi::plane_for_program(raw.depth);
            frame.haptic = capi::plane_for_program(raw.haptic);
            frame.height = capi::plane_for_program(raw.height);
            EXPECT_EQ(touch_surface_push(surface, &frame, &error), TOUCH_OK) << error.line;
        }
        touch_vec3 goals[fingers];
        for (int k = 0; k < fingers; ++k) {
            const glm::dvec3 goal = globe.goal(tick, k);
            goals[k] = {goal.x, goal.y, goal.z};
        }
        touch_contact contacts[fingers];
        const touch_tick at = tick_at(tick);
        const std::size_t before = allocations();
        EXPECT_EQ(touch_solver_tick(solver, &at, goals, contacts, sizeof contacts[0]), TOUCH_OK);
        touched.allocations += allocations() - before;
        for (const touch_contact& contact : contacts)
            touched.most = std::max(touched.most, std::abs(contact.force_n.z));
    }
    EXPECT_EQ(touch_solver_force_hash(solver, &touched.hash), TOUCH_OK);
    EXPECT_EQ(touch_solver_destroy(solver), TOUCH_OK);
    EXPECT_EQ(touch_surface_destroy(surface), TOUCH_OK);
    EXPECT_EQ(touch_scene_destroy(scene), TOUCH_OK);
    return touched;
}

TEST(SameForces, AsTheRoomsBehindToTheBit) {
    const Globe globe;
    const std::uint64_t expected = forces_of_the_rooms(globe);
    for (const int threads : {1, 3}) {
        const Touched touched = forces_of_the_api(globe, threads);
        EXPECT_EQ(touched.hash, expected) << "with threads: " << threads;
        EXPECT_GT(touched.most, 0.5) << "hardly anything was touched";
        EXPECT_EQ(touched.allocations, 0U);
    }
}

TEST(SameForces, BatchesAreTicks) {
    TouchedHill one, many;
    std::vector<touch_vec3> goals;
    std::vector<touch_contact> singly(500), together(500);
    for (std::int64_t tick = 0; tick < 500; ++tick) {
        goals.push_back(goal_at(tick));
        const touch_tick at = tick_at(tick);
        ASSERT_EQ(touch_solver_tick(one.solver, &at, &goals.back(), &singly[static_cast<std::size_t>(tick)],
                                    sizeof(touch_contact)),
                  TOUCH_OK);
    }
    const touch_tick first = tick_at(0);
    const std::size_t before = allocations();
    ASSERT_EQ(
        touch_solver_run(many.solver, &first, 500, goals.data(), together.data(), sizeof(touch_contact)),
        TOUCH_OK);
    std::uint64_t hash = 0, same = 1;
    std::int64_t newest = 0;
    touch_scene_facts facts;
    facts.struct_size = sizeof facts;
    touch_solver_force_hash(one.solver, &hash);
    touch_solver_force_hash(many.solver, &same);
    touch_solver_come_back(many.solver);
    touch_surface_newest_ns(many.surface, &newest);
    touch_scene_describe(many.scene, &facts);
    EXPECT_EQ(allocations(), before) << "what is said to be real-time";
    EXPECT_EQ(hash, same);
    double most = 0;
    for (std::size_t k = 0; k < singly.size(); ++k) {
        EXPECT_EQ(singly[k].force_n.z, together[k].force_n.z);
        most = std::max(most, singly[k].force_n.z);
    }
    EXPECT_GT(most, 0.5);
}

/// Floats of metres are the codes that they round to; rows from below, and at odd places, are the same
/// picture.
TEST(SameForces, WhateverMemoryDepthLiesIn) {
    const Hill hill;
    std::vector<float> metres;
    for (const std::uint16_t code : hill.codes()) metres.push_back(static_cast<float>(code) * 0.001F);
    constexpr std::size_t row = 2 * Hill::width, rows = Hill::height;
    std::vector<std::uint8_t> upside_down(row * rows), odd(row * rows + 1);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(hill.codes().data());
    for (std::size_t y = 0; y < rows; ++y)
        std::copy_n(bytes + row * y, row, upside_down.data() + row * (rows - 1 - y));
    std::copy_n(bytes, row * rows, odd.data() + 1);
    const touch_plane planes[] = {
        hill.frame().depth,
        {metres.data(), 4 * Hill::width, Hill::width, Hill::height, TOUCH_F32, 1},
        {upside_down.data() + row * (rows - 1), -static_cast<std::int64_t>(row), Hill::width, Hill::height,
         TOUCH_U16, 1},
        {odd.data() + 1, row, Hill::width, Hill::height, TOUCH_U16, 1},
    };
    std::vector<std::uint64_t> hashes;
    for (const touch_plane& plane : planes) {
        TouchedHill touched;
        touch_frame frame = hill.frame(1);
        frame.depth = plane;
        touch_error error{sizeof error, 0, {}};
        ASSERT_EQ(touch_surface_push(touched.surface, &frame, &error), TOUCH_OK) << error.line;
        for (std::int64_t tick = 40; tick < 300; ++tick) {
            const touch_tick at = tick_at(tick);
            const touch_vec3 goal = goal_at(tick);
            touch_contact contact;
            ASSERT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
        }
        hashes.emplace_back();
        touch_solver_force_hash(touched.solver, &hashes.back());
    }
    for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes.front());
}

/// A plane in the world, exactly: codes of 1/depth that grow evenly over the picture.
class TiltedPlane {
public:
    static constexpr int width = 65, height = 49, across = 120, down = -75, first = 9000;
    static constexpr double near = 0.4, far = 2, stiffness = 400, scale = 0.5;

    TiltedPlane()
        : scene_(std::string(R"({"touchable_scene": 1, "width": 65, "height": 49, "metres_per_unit": 1,
              "camera": {"fx": 60, "fy": 55, "cx": 30, "cy": 26},
              "depth": {"coding": "inverse", "bits": 16, "near": 0.4, "far": 2},
              "default_properties": {"stiffness_n_per_m": 400, "static_friction": 0.8, "dynamic_friction": 0.5}})")),
          surface_(scene_) {
        std::vector<std::uint16_t> codes;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                codes.push_back(static_cast<std::uint16_t>(first + across * x + down * y));
        touch_frame frame = touch::frame();
        frame.depth = {codes.data(), 2 * width, width, height, TOUCH_U16, 1};
        EXPECT_TRUE(surface_.push(frame));
    }
    double depth_at(double x, double y) const { return 1 / reciprocal(first + across * x + down * y); }
    touch_vec3 point(double x, double y, double depth) const {
        return {(x - 30) / 60 * depth, (26 - y) / 55 * depth, -depth};
    }
    /// k times the way to the plane, along its normal. The plane: 1 = reciprocal(code at x, y) * depth.
    touch_vec3 expected(const touch_vec3& at) const {
        const double per_code = (1 / near - 1 / far) / 65535;
        const double a = 60 * across * per_code, b = -55 * down * per_code,
                     c = -reciprocal(first + across * 30 + down * 26);
        const double behind = a * at.x + b * at.y + c * at.z - 1, squared = a * a + b * b + c * c;
        const double along = -stiffness * scale * behind / squared;
        return {along * a, along * b, along * c};
    }
    touch_solver_settings settings() const {
        touch_solver_settings settings = touch::solver_settings();
        settings.metres_per_scene_unit = scale;
        settings.max_force_n = 1000;
        return settings;
    }
    std::vector<touch_contact> forces_at(const std::vector<touch_vec3>& points, int friction) const {
        return surface_.forces_at(touch::tick_at(0), points, friction, settings());
    }
    touch::Surface& surface() { return surface_; }

private:
    static double reciprocal(double code) { return 1 / far + (1 / near - 1 / far) * code / 65535; }
    const touch::Scene scene_;
    touch::Surface surface_;
};

double off(const touch_vec3& a, const touch_vec3& b) {
    return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

/// Points 2 mm to 4 cm behind the plane, under all of the picture but its border.
std::vector<touch_vec3> points_behind(const TiltedPlane& plane) {
    std::vector<touch_vec3> points;
    for (int y = 12; y < 37; ++y)
        for (int x = 15; x < 50; ++x)
            points.push_back(
                plane.point(x, y + 0.3, plane.depth_at(x, y + 0.3) + 0.002 * (1 + (x + y) % 20)));
    return points;
}

TEST(ForcesAt, PlanePushesAlongItsNormal) {
    const TiltedPlane plane;
    const auto points = points_behind(plane);
    const auto contacts = plane.forces_at(points, TOUCH_FRICTION_OFF);
    for (std::size_t k = 0; k < points.size(); ++k) {
        EXPECT_EQ(contacts[k].touching, 1);
        EXPECT_EQ(contacts[k].guard, 0U) << "steady, and the solver's own";
        ASSERT_LT(off(contacts[k].force_n, plane.expected(points[k])), 1e-9) << k;
    }
}

/// Each comes along its pixel's ray in 200 ticks, and stays for 300.
void expect_as_ticked(TiltedPlane& plane, const std::vector<touch_vec3>& points, int friction) {
    const auto contacts = plane.forces_at(points, friction);
    touch_solver_settings settings = plane.settings();
    settings.ramp_in_ticks = 0;
    for (std::size_t k = 0; k < points.size(); k += 23) {
        touch::Solver solver(plane.surface(), settings);
        touch_contact last{};
        for (std::int64_t tick = 0; tick < 500; ++tick) {
            const double share = std::min(1.0, 0.5 + 0.5 * static_cast<double>(tick) / 200);
            const touch_vec3 goal{points[k].x * share, points[k].y * share, points[k].z * share};
            ASSERT_EQ(solver.tick(touch::tick_at(tick), &goal, &last), TOUCH_OK);
        }
        ASSERT_LT(off(contacts[k].force_n, last.force_n), 1e-9) << k;
        EXPECT_EQ(contacts[k].guard, 0U);
    }
}

TEST(ForcesAt, AreThoseOfManyTicks) {
    TiltedPlane plane;
    // Without friction a finger ends where the plane is nearest, however it came.
    const auto points = points_behind(plane);
    const auto contacts = plane.forces_at(points, TOUCH_FRICTION_OFF);
    for (std::size_t k = 0; k < points.size(); ++k)
        ASSERT_LT(off(contacts[k].force_n, plane.expected(points[k])), 1e-9);
    expect_as_ticked(plane, points, TOUCH_FRICTION_ON);
}

TEST(ForcesAt, FrictionLeansOnlyWhereAsked) {
    const TiltedPlane plane;
    const std::vector<touch_vec3> points{plane.point(45, 30, plane.depth_at(45, 30) + 0.01)};
    const touch_contact on = plane.forces_at(points, TOUCH_FRICTION_ON)[0],
                        without = plane.forces_at(points, TOUCH_FRICTION_OFF)[0];
    EXPECT_GT(off(on.force_n, without.force_n), 0.1);
    EXPECT_EQ(on.static_friction, 0.8);
    EXPECT_EQ(without.static_friction, 0);
    EXPECT_EQ(without.stiffness_n_per_m, 400);
}

TEST(ForcesAt, PlacesDoNotDependOnEachOther) {
    const TiltedPlane plane;
    auto points = points_behind(plane);
    points[5].x = std::numeric_limits<double>::quiet_NaN();
    points[7].z = -0.1;  // free
    const auto all = plane.forces_at(points, TOUCH_FRICTION_ON);
    for (std::size_t k = 0; k < points.size(); k += 7) {
        const touch_contact alone = plane.forces_at({points[k]}, TOUCH_FRICTION_ON)[0];
        EXPECT_EQ(off(alone.force_n, all[k].force_n), 0) << k;
        EXPECT_EQ(alone.guard, all[k].guard);
    }
    EXPECT_NE(all[5].guard & TOUCH_GUARD_FAULT, 0U);
    EXPECT_EQ(off(all[5].force_n, {}), 0);
    EXPECT_EQ(all[7].touching, 0);
    EXPECT_EQ(all[7].guard, 0U);
}

TEST(ForcesAt, SayWhatIsMissing) {
    TiltedPlane plane;
    const touch_tick moment = touch::tick_at(0);
    const touch_vec3 point = plane.point(30, 20, 1);
    touch_contact contact{};
    touch_error error{sizeof error, 0, {}};
    const auto call = [&](touch_surface surface, int friction) {
        return touch_surface_forces_at(surface, nullptr, &moment, friction, &point, 1, &contact,
                                       sizeof contact, &error);
    };
    {
        const touch::Solver solver(plane.surface());
        EXPECT_EQ(call(plane.surface().get(), 0), TOUCH_BUSY);
    }
    EXPECT_EQ(call(plane.surface().get(), 0), TOUCH_OK);
    EXPECT_EQ(call(plane.surface().get(), 2), TOUCH_USAGE);
    EXPECT_NE(std::string(error.line).find("friction"), std::string::npos) << error.line;
    const touch::Surface empty{touch::Scene(Hill::camera())};
    EXPECT_EQ(call(empty.get(), 0), TOUCH_USAGE);
    EXPECT_NE(std::string(error.line).find("frame"), std::string::npos) << error.line;
    EXPECT_EQ(call({1}, 0), TOUCH_STALE);
}

}  // namespace
}  // namespace touchable::test
