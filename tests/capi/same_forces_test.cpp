// SPDX-License-Identifier: Apache-2.0
// The C API gives the forces of the rooms behind it, to the bit: same frames, goals and times.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <thread>

#include "capi/api_common.hpp"
#include "capi/touchable.hpp"
#include "engine/content/scenes.hpp"
#include "engine/run/touch_run.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/capi/hill.hpp"
#include "tests/limits.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

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
    std::size_t allocations = 0;     ///< in ticks
    int in_contact = 0, barred = 0;  ///< contacts; those with error bars
};

Touched forces_of_the_api(const Globe& globe, int threads, bool error_bars) {
    const std::string text = scene_to_json(globe.scene());
    touch_error error = no_error();
    touch_scene scene{};
    EXPECT_EQ(touch_scene_from_text(text.data(), text.size(), &scene, &error), TOUCH_OK) << error.line;
    touch_surface_settings shape;
    touch_surface_settings_defaults(&shape, sizeof shape);
    shape.threads = threads;
    shape.error_bars = error_bars;
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
        for (const touch_contact& contact : contacts) {
            touched.most = std::max(touched.most, std::abs(contact.force_n.z));
            touched.in_contact += contact.touching;
            touched.barred += contact.error_degrees > 0 && contact.error_newtons > 0;
            EXPECT_TRUE(contact.touching || std::isnan(contact.error_degrees));
        }
    }
    EXPECT_EQ(touch_solver_force_hash(solver, &touched.hash), TOUCH_OK);
    EXPECT_EQ(touch_solver_destroy(solver), TOUCH_OK);
    EXPECT_EQ(touch_surface_destroy(surface), TOUCH_OK);
    EXPECT_EQ(touch_scene_destroy(scene), TOUCH_OK);
    return touched;
}

TEST(SameForces, MatchEngineToTheBit) {
    const Globe globe;
    const std::uint64_t expected = forces_of_the_rooms(globe);
    for (const int threads : {1, 3}) {
        const bool error_bars = threads == 1;
        const Touched touched = forces_of_the_api(globe, threads, error_bars);
        EXPECT_EQ(touched.hash, expected) << "with threads: " << threads;
        EXPECT_EQ(touched.barred, error_bars ? touched.in_contact : 0);
        EXPECT_GT(touched.most, 0.5) << "hardly anything was touched";
        EXPECT_EQ(touched.allocations, 0U);
    }
}

TEST(SameForces, BatchesAreTicks) {
    TouchedHill one, many;
    std::vector<touch_vec3> goals;
    std::vector<touch_contact> singly, together(500);
    for (std::int64_t tick = 0; tick < 500; ++tick) {
        goals.push_back(goal_at(tick));
        ASSERT_EQ(one.tick(tick), TOUCH_OK);
        singly.push_back(one.contact);
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
TEST(SameForces, AnyMemoryLayoutWorks) {
    const Hill hill;
    const std::vector<float> metres = hill.metres();
    constexpr std::size_t row = 2 * Hill::width, rows = Hill::height;
    std::vector<std::uint8_t> upside_down(row * rows), odd(row * rows + 1);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(hill.codes().data());
    for (std::size_t y = 0; y < rows; ++y)
        std::copy_n(bytes + row * y, row, upside_down.data() + row * (rows - 1 - y));
    std::copy_n(bytes, row * rows, odd.data() + 1);
    const touch_plane planes[] = {
        hill.frame().depth,
        Hill::plane_of(metres),
        {upside_down.data() + row * (rows - 1), -static_cast<std::int64_t>(row), Hill::width, Hill::height,
         TOUCH_U16, 1},
        {odd.data() + 1, row, Hill::width, Hill::height, TOUCH_U16, 1},
    };
    std::vector<std::uint64_t> hashes;
    for (const touch_plane& plane : planes) {
        TouchedHill touched;
        touch_frame frame = hill.frame(1);
        frame.depth = plane;
        touch_error error = no_error();
        ASSERT_EQ(touched.push(frame, &error), TOUCH_OK) << error.line;
        for (std::int64_t tick = 40; tick < 300; ++tick) ASSERT_EQ(touched.tick(tick), TOUCH_OK);
        hashes.push_back(touched.hash());
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

TEST(ForcesAt, PushAlongNormalAsManyTicks) {
    TiltedPlane plane;
    // Without friction a finger ends where the plane is nearest, however it came.
    const auto points = points_behind(plane);
    const auto contacts = plane.forces_at(points, TOUCH_FRICTION_OFF);
    for (std::size_t k = 0; k < points.size(); ++k) {
        EXPECT_EQ(contacts[k].touching, 1);
        EXPECT_EQ(contacts[k].guard, 0U) << "steady, and the solver's own";
        ASSERT_LT(off(contacts[k].force_n, plane.expected(points[k])), 1e-9) << k;
    }
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

TEST(ForcesAt, PlacesAreIndependent) {
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

/// Where a finger comes out of a soft hole, its force rises by 0.04 N a tick: 20 N in 500.
TEST(ForcesAt, UnsteadyForceIsReported) {
    touch::Surface surface{
        touch::Scene(std::string(R"({"touchable_scene": 1, "width": 64, "height": 48, "metres_per_unit": 1,
              "camera": {"fx": 60, "fy": 60, "cx": 31.5, "cy": 23.5}, "hole_stiffness": 0.05,
              "depth": {"coding": "metric", "scale": 0.001, "near": 0.1, "far": 1, "invalid": [0]}})"))};
    std::mt19937 random(1);
    std::vector<std::uint16_t> codes(Hill().codes().size());
    for (std::uint16_t& code : codes)
        code = static_cast<std::uint16_t>(random() % 5 == 0 ? 0 : 500 + random() % 20);
    touch_frame frame = Hill().frame();
    frame.depth.data = codes.data();
    EXPECT_TRUE(surface.push(frame));
    std::vector<touch_vec3> points;
    for (int k = -20; k < 20; ++k) points.push_back({0.012 * k, 0, -0.8});
    touch_solver_settings settings = touch::solver_settings();
    settings.metres_per_scene_unit = 1;
    settings.max_force_n = 1000;
    std::size_t unsteady = 0;
    for (const touch_contact& contact :
         surface.forces_at(touch::tick_at(0), points, TOUCH_FRICTION_ON, settings)) {
        const bool is_unsteady = (contact.guard & TOUCH_GUARD_UNSTEADY) != 0;
        EXPECT_EQ((contact.guard & TOUCH_GUARD_RISE) != 0, is_unsteady) << "it rises still, or no more";
        unsteady += is_unsteady;
    }
    EXPECT_GT(unsteady, 0U);
    EXPECT_LT(unsteady, points.size());
}

TEST(ForcesAt, ErrorsNameTheProblem) {
    TiltedPlane plane;
    const touch_tick moment = touch::tick_at(0);
    const touch_vec3 point = plane.point(30, 20, 1);
    touch_contact contact{};
    touch_error error = no_error();
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

// Depth whose camera leaves its steps open: floats get fine ones, integers are millimetres.

/// A wall half a metre away that leans by 10 degrees, in pixels of 0.8 mm.
class LeaningWall {
public:
    explicit LeaningWall(double metres_per_code) : metres_(std::size_t{Hill::width} * Hill::height) {
        camera_.fx_px = camera_.fy_px = 600;
        camera_.far_m = 0.6;
        camera_.metres_per_code = metres_per_code;
        for (std::size_t k = 0; k < metres_.size(); ++k)
            metres_[k] = static_cast<float>(
                0.5 * normal[2] / (normal[2] - normal[0] * ray(static_cast<double>(k % Hill::width))));
    }
    /// Degrees between the forces and the normal, on average.
    double error_degrees() {
        touch::Surface surface{touch::Scene(camera_)};
        touch_frame frame = touch::frame();
        frame.depth = Hill::plane_of(metres_);
        frame.lost_degrees = &lost_degrees;
        surface.push(frame);
        std::vector<touch_vec3> points;
        for (double column = 10; column < 54; column += 1.7) {
            const double depth = 0.505 * normal[2] / (normal[2] - normal[0] * ray(column));
            points.push_back({ray(column) * depth, 0, -depth});
        }
        double degrees = 0;
        for (const touch_contact& contact : surface.forces_at(touch::tick_at(0), points)) {
            const touch_vec3& force = contact.force_n;
            const double along = force.x * normal[0] + force.z * normal[2];
            degrees += std::acos(std::min(1.0, along / std::hypot(force.x, force.y, force.z))) * 57.29577951;
        }
        return degrees / static_cast<double>(points.size());
    }

    double lost_degrees = -1;

private:
    static constexpr double normal[] = {0.17364817766693, 0, 0.98480775301221};
    double ray(double column) const { return (column - camera_.cx_px) / camera_.fx_px; }

    touch_camera camera_ = Hill::camera();
    std::vector<float> metres_;
};

TEST(OpenSteps, FloatsKeepTheirDirection) {
    LeaningWall open(0), coarse(0.001);
    EXPECT_LT(open.error_degrees(), 0.3);
    EXPECT_LT(open.lost_degrees, 0.3);
    const double error = coarse.error_degrees();
    EXPECT_GT(error, 5) << "what millimetres make of it";
    EXPECT_NEAR(coarse.lost_degrees, 1.5 * error, 0.3 * error)
        << "of faces, of which a proxy avoids the steep";
}

/// Alone to the bit; after floats within half a step.
TEST(OpenSteps, IntegersAreMillimetres) {
    std::vector<std::uint64_t> hashes;
    for (const double step_m : {0.0, 0.001}) {
        touch_camera camera = Hill::camera();
        camera.metres_per_code = step_m;
        const touch::Scene scene(camera);
        const Hill hill;
        std::vector<float> metres(hill.codes().size());
        scene.metres(hill.frame().depth, metres.data());
        EXPECT_NEAR(metres[0], hill.metres()[0], 1e-7);
        touch::Surface surface(scene);
        surface.push(hill.frame());
        touch::Solver solver(surface);
        touch_contact contact;
        for (std::int64_t tick = 0; tick < 300; ++tick) {
            const touch_vec3 goal = goal_at(tick);
            solver.tick(touch::tick_at(tick), &goal, &contact);
        }
        hashes.push_back(solver.force_hash());
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    const touch::Scene scene(Hill::camera());
    touch::Surface surface(scene);
    touch_frame frame = Hill().frame();
    const std::vector<float> metres = Hill().metres();
    frame.depth = Hill::plane_of(metres);
    surface.push(frame);
    const std::vector<touch_vec3> points{{0, 0, -0.44}, {0.1, 0.05, -0.5}};
    const auto before = surface.forces_at(touch::tick_at(0), points);
    const Hill again;
    surface.push(again.frame(1));
    const auto after = surface.forces_at(touch::tick_at(33), points);
    for (std::size_t k = 0; k < points.size(); ++k)
        EXPECT_NEAR(after[k].force_n.z, before[k].force_n.z, 1e-9) << "rounded alike";
}

// Forces of a hand whose program has ordinary trouble: goals that go missing, frames that come
// meanwhile, settings at their ends.

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr touch_vec3 missing{nan, nan, nan};

/// A wall that may come nearer, and a finger that presses on it.
class PressedWall {
public:
    explicit PressedWall(const touch_solver_settings& settings)
        : scene_(camera()), surface_(scene_), solver_((push(0.5), surface_), settings) {}

    static touch_solver_settings settings() {
        touch_solver_settings settings = touch::solver_settings();
        settings.metres_per_scene_unit = 1;
        return settings;
    }
    /// From the coming tick on, or from `later` milliseconds on.
    void push(double depth_m, std::int64_t later = 0) {
        std::vector<float> metres(static_cast<std::size_t>(Hill::width) * Hill::height,
                                  static_cast<float>(depth_m));
        touch_frame frame = touch::frame();
        frame.number = frames_;
        frame.time_ns = frames_ == 0 ? 0 : (tick_ - 1 + later) * 1'000'000;
        frame.depth = Hill::plane_of(metres);
        ++frames_;
        EXPECT_TRUE(surface_.push(frame));
    }
    /// Newtons towards the eye. `passed`: milliseconds since the tick before.
    double tick(const touch_vec3& goal, std::int64_t passed = 1) {
        tick_ += passed - 1;
        EXPECT_EQ(solver_.tick(touch::tick_at(tick_++), &goal, &contact), TOUCH_OK);
        return contact.force_n.z;
    }
    void come_back() { solver_.come_back(); }

    touch_contact contact{};  ///< of the last tick

private:
    static touch_camera camera() {
        touch_camera camera = Hill::camera();
        camera.metres_per_code = 0.0001;
        camera.far_m = 6;
        return camera;
    }

    std::int64_t tick_ = 1, frames_ = 0;
    touch::Scene scene_;
    touch::Surface surface_;
    touch::Solver solver_;
};

class MissingGoals : public testing::TestWithParam<int> {};

/// A tracker loses the finger for some milliseconds, and a nearer surface comes meanwhile.
TEST_P(MissingGoals, ReturnWithoutStep) {
    for (const bool has_frame : {false, true}) {
        PressedWall wall(PressedWall::settings());
        const touch_vec3 goal{0, 0, -0.503};
        for (int k = 0; k < 300; ++k) wall.tick(goal);
        double before = wall.tick(goal), most = 0;
        EXPECT_GT(before, 1.5) << "it presses";
        for (int k = 0; k < GetParam(); ++k) {
            if (has_frame && k == 0) wall.push(0.4865);
            before = wall.tick(missing);
        }
        for (int k = 0; k < 300; ++k) {
            const double now = wall.tick(goal);
            most = std::max(most, now - before);
            before = now;
        }
        // By a fade of what the device can give, over 100 ms (1.5 times its mean at its steepest), and the
        // ramp.
        EXPECT_LE(most, (1.5 + 1) * 10 / 100) << (has_frame ? "with a frame" : "without one");
        EXPECT_NEAR(before, 600 * (has_frame ? 0.0165 : 0.003), 0.2)
            << "in the end the surface is felt whole";
    }
}

INSTANTIATE_TEST_SUITE_P(ForceSafety, MissingGoals, testing::Values(1, 5, 20, 40, 50, 60, 80, 99, 100, 120));

TEST(ForceSafety, LongestRampIsGradual) {
    touch_solver_settings settings = PressedWall::settings();
    settings.ramp_out_ticks = std::numeric_limits<std::int32_t>::max();
    PressedWall wall(settings);
    const touch_vec3 goal{0, 0, -0.51};
    for (int k = 0; k < 300; ++k) wall.tick(goal);
    wall.come_back();
    wall.tick(missing);
    double before = 0;
    for (int k = 0; k < 100; ++k) {
        const double now = wall.tick(goal);
        EXPECT_LE(now - before, 0.2);
        before = now;
    }
}

/// As of a picture that the program opens: 600 N/m become 100 while the depth goes, which is half a frame's
/// time.
TEST(ForceSafety, VanishingDepthTakesForceByRamp) {
    PressedWall wall(PressedWall::settings());
    const touch_vec3 goal{0, 0, -0.512};
    for (int k = 0; k < 300; ++k) wall.tick(goal);
    wall.push(0.5);
    wall.push(0, 33);
    for (int k = 1; k <= 16; ++k) ASSERT_NEAR(wall.tick(goal), 0.012 * (600 - 500 * k / 16.5), 1e-9) << k;
    EXPECT_EQ(wall.tick(goal), 0) << "there is no surface";
}

// However many ticks were left out, the force rises in a tick that is run by no more than in one, and after
// more than 50 ms it returns only to a finger that was free.

/// 1.4 m in one tick, to 15 mm under the wall: the damper takes the spring's 9 N away.
double damped_away(PressedWall& wall) {
    for (int k = 0; k < 300; ++k) wall.tick({0, 0, -1.915});
    return wall.tick({0, 0, -0.515});
}

TEST(LeftOutTicks, DamperGivesForceBackByRamp) {
    touch_solver_settings settings = PressedWall::settings();
    settings.damping_n_s_per_m = 5;
    for (const std::int64_t passed : {1, 2, 10, 50}) {
        PressedWall wall(settings);
        double before = damped_away(wall);
        EXPECT_LT(before, 0.1);
        for (int k = 0; k < 110; ++k) {
            const double now = wall.tick({0, 0, -0.515}, passed);
            ASSERT_LE(now - before, 0.1 * (1 + 1e-9)) << passed << " ms, tick " << k;
            before = now;
        }
        EXPECT_NEAR(before, 600 * 0.015, 1e-6) << passed;
    }
}

TEST(LeftOutTicks, LongGapWaitsForFreeFinger) {
    touch_solver_settings settings = PressedWall::settings();
    settings.damping_n_s_per_m = 5;
    for (const bool waits : {false, true}) {
        settings.waits_to_be_free = waits;
        for (const std::int64_t passed : {51, 103, 100'000}) {
            PressedWall wall(settings);
            wall.tick({0, 0, -0.4});
            damped_away(wall);
            for (int k = 0; k <= 300; ++k) {
                const double expected = waits ? 0 : 600 * 0.015 * std::min(1.0, k / 100.0);
                ASSERT_NEAR(wall.tick({0, 0, -0.515}, k == 0 ? passed : 1), expected, 1e-9) << k;
                ASSERT_EQ((wall.contact.guard & TOUCH_GUARD_GAP) != 0, k == 0);
            }
            wall.tick({0, 0, -0.4});
            EXPECT_GT(wall.tick({0, 0, -0.505}), 2.9);
        }
    }
}

/// The wall comes nearer by 2.9 mm in 30 ms without a tick: 1.74 N.
TEST(LeftOutTicks, MovedSurfaceIsFeltByFade) {
    PressedWall wall(PressedWall::settings());
    const touch_vec3 goal{0, 0, -0.505};
    for (int k = 0; k < 300; ++k) wall.tick(goal);
    wall.push(0.5);
    wall.push(0.4971, 30);
    double before = 600 * 0.005;
    for (int k = 0; k < 120; ++k) {
        const double now = wall.tick(goal, k == 0 ? 30 : 1);
        ASSERT_LE(now - before, 1.5 * 1.74 / 100 * (1 + 1e-9)) << k;
        before = now;
    }
    EXPECT_NEAR(before, 600 * 0.0079, 1e-6);
}

TEST(LeftOutTicks, StaleSurfaceReturnsByRamp) {
    touch_solver_settings settings = PressedWall::settings();
    settings.stale_after_ns = 100'000'000;
    PressedWall wall(settings);
    const touch_vec3 goal{0, 0, -0.505};
    for (int k = 0; k < 300; ++k) {
        if (k % 50 == 49) wall.push(0.5);
        wall.tick(goal);
    }
    double before = 3;
    while (before > 1.5) before = wall.tick(goal);
    wall.push(0.5);
    EXPECT_NEAR(wall.tick(goal, 40) - before, 3 * 0.01, 1e-9);
}

/// A hill that moves, and a finger that leaps about and gets ticks as they come.
class LeapingFinger {
public:
    static constexpr double most = 10, stiffness = 600;

    LeapingFinger(const touch_solver_settings& settings, std::uint64_t seed)
        : settings_(settings), random_(seed), surface_(touch::Scene(Hill::camera())) {
        for (int lifted = 0; lifted <= 60; ++lifted) hills_.emplace_back(lifted);
        push(0);
        solver_ = touch::Solver(surface_, settings);
    }
    /// A tick, and the checks of what is promised of its force.
    void tick() {
        const std::int64_t passed = tick_ == 0 ? 1 : draw_passed();
        tick_ += passed;
        time_ns_ += (passed + (random_.below(300) == 0 ? random_.below(300) : 0)) * 1'000'000;
        outage_ = settings_.stale_after_ns > 0 && random_.below(200) < (outage_ ? 198 : 1);
        if (surface_.newest_ns() <= time_ns_ && !outage_) push(time_ns_ + 33'000'000);
        const touch_vec3 before = goal_;
        const bool is_missing = random_.below(40) == 0;
        move();
        const touch_tick at{sizeof(touch_tick), 0, tick_, time_ns_, 0, 0};
        const touch_vec3 given = is_missing ? missing : goal_;
        if (is_missing) goal_ = before;
        touch_contact contact;
        ASSERT_EQ(solver_.tick(at, &given, &contact), TOUCH_OK);
        check(contact, passed, off(goal_, before));
        if (waits_ && !is_missing && !contact.touching) waits_ = false;
    }

    int gaps = 0, pressed = 0;

private:
    void check(const touch_contact& contact, std::int64_t passed, double moved) {
        const double force = off(contact.force_n, {}), rise = force - force_;
        force_ = force;
        ASSERT_LE(force, most);
        pressed += force > 1;
        if (passed > 50) {
            ++gaps;
            waits_ = settings_.waits_to_be_free == 1;
            ASSERT_EQ(force, 0);
            ASSERT_NE(contact.guard & TOUCH_GUARD_GAP, 0U);
        }
        ASSERT_TRUE(force == 0 || !waits_ || !contact.touching);
        // By a jump's fade at its steepest, by the ramps of guard and stale surface, by what the damper gives
        // back, and by 0.1 mm of the surface; by the hand's own motion against spring and damper.
        const double ramps = (1.5 + 1 + 1 + 1) / 100 * most + stiffness * 0.0001,
                     damper = (settings_.damping_n_s_per_m + settings_.passivity_n_s_per_m) * 0.395 /
                              (0.001 * static_cast<double>(passed));
        ASSERT_LE(rise, ramps + (stiffness + damper) * moved) << tick_ << " after " << passed;
    }
    std::int64_t draw_passed() {
        const int drawn = random_.below(100);
        return drawn < 80 ? 1 : drawn < 97 ? 2 + random_.below(49) : 51 + random_.below(200);
    }
    void move() {
        const int drawn = random_.below(100);
        const auto by = [&](double far) { return random_.within(-far, far); };
        if (drawn < 60) return;
        if (drawn < 90)
            goal_ = {goal_.x + by(2e-4), goal_.y + by(2e-4), goal_.z + by(2e-4)};
        else
            goal_ = {by(0.2), by(0.15),
                     drawn < 97 ? random_.within(-0.52, -0.38) : random_.within(-1.9, -0.1)};
    }
    /// Mostly at up to 0.1 m/s; sometimes a leap, or none for a while.
    void push(std::int64_t time_ns) {
        lifted_ =
            random_.below(20) == 0 ? random_.below(60) : std::clamp(lifted_ + random_.below(7) - 3, 0, 60);
        touch_frame frame = hills_[static_cast<std::size_t>(lifted_)].frame(frames_++);
        frame.time_ns = time_ns;
        ASSERT_TRUE(surface_.push(frame));
    }

    touch_solver_settings settings_;
    Random random_;
    std::vector<Hill> hills_;
    touch::Surface surface_;
    touch::Solver solver_;
    touch_vec3 goal_{0, 0, -0.3};
    std::int64_t tick_ = 0, time_ns_ = 0, frames_ = 0;
    int lifted_ = 0;
    double force_ = 0;
    bool outage_ = false, waits_ = false;
};

TEST(LeftOutTicks, RandomLeapsNeverBringForceBackAtOnce) {
    const std::int64_t each = 1'000'000 / 16 / static_cast<std::int64_t>(sweep_step());
    for (unsigned options = 0; options < 16; ++options) {
        touch_solver_settings settings = PressedWall::settings();
        settings.damping_n_s_per_m = options & 1 ? 5 : 0;
        settings.passivity_n_s_per_m = options & 2 ? 20 : 0;
        settings.waits_to_be_free = options & 4 ? 1 : 0;
        settings.stale_after_ns = options & 8 ? 40'000'000 : 0;
        settings.stribeck_m_per_s = options & 8 ? 0.1 : 0;
        SCOPED_TRACE(options);
        LeapingFinger finger(settings, options);
        for (std::int64_t k = 0; k < each && !testing::Test::HasFailure(); ++k) finger.tick();
        if (HasFailure()) return;
        EXPECT_GT(finger.gaps, each / 50);
        EXPECT_GT(finger.pressed, each / 50);
    }
}

// Two solvers in two threads, frames that are pushed while a solver ticks, and a process that was forked.

std::uint64_t hash_of_a_run() {
    TouchedHill touched;
    for (std::int64_t tick = 0; tick < 500; ++tick) EXPECT_EQ(touched.tick(tick), TOUCH_OK);
    return touched.hash();
}

TEST(Threads, TwoSolversInTwoThreads) {
    const std::uint64_t expected = hash_of_a_run();
    std::uint64_t one = 0, other = 0;
    std::thread first([&] { one = hash_of_a_run(); }), second([&] { other = hash_of_a_run(); });
    first.join();
    second.join();
    EXPECT_EQ(one, expected);
    EXPECT_EQ(other, expected);
}

TEST(Threads, OnePushesWhileAnotherTicks) {
    TouchedHill touched;
    constexpr std::int64_t frames = 60;
    std::atomic<bool> pushed_all{false};
    std::thread writer([&] {
        for (std::int64_t n = 1; n < frames; ++n) {
            const Hill hill(static_cast<int>(n % 5));
            touch_status status = TOUCH_FULL;
            while ((status = touched.push(hill.frame(n))) == TOUCH_FULL) std::this_thread::yield();
            EXPECT_EQ(status, TOUCH_OK);
        }
        pushed_all = true;
    });
    touch_contact contact;
    std::int64_t newest = 0;
    for (std::int64_t tick = 0; !pushed_all; ++tick) {
        touch_tick at = tick_at(tick);
        EXPECT_EQ(touch_surface_newest_ns(touched.surface, &newest), TOUCH_OK);
        at.time_ns = newest;
        const touch_vec3 goal = goal_at(tick);
        EXPECT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
    }
    writer.join();
    EXPECT_EQ(touch_surface_newest_ns(touched.surface, &newest), TOUCH_OK);
    EXPECT_EQ(newest, (frames - 1) * 33'000'000);
}

/// Destroying what a solver needs gives TOUCH_BUSY, and other threads go on using it.
TEST(Threads, BusySurfaceStaysUsable) {
    const TouchedHill touched;
    std::atomic<bool> over = false;
    std::thread destroyer([&] {
        while (!over)
            if (touch_surface_destroy(touched.surface) != TOUCH_BUSY) break;
    });
    int stale = 0;
    for (int k = 0; k < 100'000; ++k) {
        std::int64_t newest;
        stale += touch_surface_newest_ns(touched.surface, &newest) != TOUCH_OK;
    }
    over = true;
    destroyer.join();
    EXPECT_EQ(stale, 0);
}

/// The result of `work` in a forked child, 0 to 200; 256 and more where the child hangs.
int in_child(const std::function<int()>& work) {
    const pid_t child = fork();
    if (child == 0) {
        alarm(60);
        _exit(work());
    }
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 256 + status;
}

/// One object of each kind, with threads where it may have some.
struct HeldObjects {
    TouchedHill hill;
    touch_surface threaded{};
    touch_writer writer{};
    touch_clip clip{};
    touch_frameset frameset{};

    explicit HeldObjects(const TemporaryFolder& folder) {
        touch_surface_settings settings;
        EXPECT_EQ(touch_surface_settings_defaults(&settings, sizeof settings), TOUCH_OK);
        settings.threads = 3;
        EXPECT_EQ(touch_surface_create(hill.scene, &settings, &threaded, nullptr), TOUCH_OK);
        EXPECT_EQ(push(threaded, 0), TOUCH_OK);
        const std::string file = folder / "hill.mkv";
        EXPECT_EQ(touch_writer_create(file.c_str(), hill.scene, nullptr, &writer, nullptr), TOUCH_OK);
        for (int n = 0; n < 8; ++n) EXPECT_EQ(write(), TOUCH_OK);
        EXPECT_EQ(touch_writer_finish(writer, nullptr), TOUCH_OK);
        EXPECT_EQ(touch_clip_open(file.c_str(), nullptr, &clip, nullptr), TOUCH_OK);
        EXPECT_EQ(touch_clip_next(clip, &frameset, nullptr), TOUCH_OK);
        const std::string other = folder / "other.mkv";
        EXPECT_EQ(touch_writer_create(other.c_str(), hill.scene, nullptr, &writer, nullptr), TOUCH_OK);
        EXPECT_EQ(write(), TOUCH_OK);
    }
    ~HeldObjects() {
        EXPECT_EQ(touch_frameset_release(frameset), TOUCH_OK);
        EXPECT_EQ(touch_clip_close(clip), TOUCH_OK);
        EXPECT_EQ(touch_surface_destroy(threaded), TOUCH_OK);
    }
    static touch_status forces_at(touch_surface surface) {
        const touch_tick at = tick_at(0);
        const touch_vec3 point{0, 0, -1};
        touch_contact contact{};
        return touch_surface_forces_at(surface, nullptr, &at, TOUCH_FRICTION_OFF, &point, 1, &contact,
                                       sizeof contact, nullptr);
    }
    static touch_status push(touch_surface surface, int number, touch_error* error = nullptr) {
        const Hill picture(number);
        const touch_frame frame = picture.frame(number);
        return touch_surface_push(surface, &frame, error);
    }
    touch_status write(touch_error* error = nullptr) const {
        const Hill picture;
        const touch_frame frame = picture.frame();
        return touch_writer_write(writer, &frame, error);
    }
};

TEST(Forks, ChildCannotUseParentsObjects) {
    const TemporaryFolder folder;
    HeldObjects held(folder);
    const int refused = in_child([&] {
        touch_error error = no_error();
        touch_frameset next{};
        touch_clip_facts facts{};
        facts.struct_size = sizeof facts;
        std::int64_t time = 0;
        std::uint64_t hash = 0;
        touch_solver solver{};
        const touch_status statuses[] = {touch_clip_next(held.clip, &next, &error),
                                         touch_clip_seek(held.clip, 0, &error),
                                         touch_clip_describe(held.clip, &facts),
                                         touch_clip_interrupt(held.clip),
                                         HeldObjects::push(held.threaded, 1, &error),
                                         touch_surface_newest_ns(held.threaded, &time),
                                         touch_solver_create(held.threaded, nullptr, &solver, &error),
                                         held.hill.tick(0),
                                         touch_solver_force_hash(held.hill.solver, &hash),
                                         held.write(&error),
                                         HeldObjects::forces_at(held.threaded),
                                         touch_writer_finish(held.writer, &error)};
        int number = 1;
        for (const touch_status status : statuses) {
            if (status != TOUCH_FORKED) return number;
            ++number;
        }
        if (std::string(touch_status_name(TOUCH_FORKED)) != "belongs to the parent process") return 100;
        return std::string(error.line).starts_with("the writer belongs to the parent process; open or make")
                   ? 0
                   : 101;
    });
    EXPECT_EQ(refused, 0) << "the call of that number";
    EXPECT_EQ(held.hill.tick(0), TOUCH_OK);
    EXPECT_EQ(HeldObjects::push(held.threaded, 1), TOUCH_OK);
    touch_frameset next{};
    EXPECT_EQ(touch_clip_next(held.clip, &next, nullptr), TOUCH_OK);
    EXPECT_EQ(touch_frameset_release(next), TOUCH_OK);
    EXPECT_EQ(held.write(), TOUCH_OK);
    EXPECT_EQ(touch_writer_finish(held.writer, nullptr), TOUCH_OK);
}

TEST(Forks, ChildReleasesAndMakesObjects) {
    const TemporaryFolder folder;
    HeldObjects held(folder);
    const int forgotten = in_child([&] {
        touch_frame frame;
        touch_frame_defaults(&frame, sizeof frame);
        if (touch_frameset_frame(held.frameset, &frame) != TOUCH_OK || !frame.depth.data) return 1;
        if (touch_clip_close(held.clip) != TOUCH_OK || touch_clip_close(held.clip) != TOUCH_STALE) return 2;
        if (touch_surface_destroy(held.hill.surface) != TOUCH_OK) return 3;  // though its solver is there
        if (touch_solver_destroy(held.hill.solver) != TOUCH_OK) return 4;
        if (touch_surface_destroy(held.threaded) != TOUCH_OK) return 5;
        if (touch_writer_abandon(held.writer) != TOUCH_OK) return 6;
        if (touch_frameset_release(held.frameset) != TOUCH_OK) return 7;
        std::uint64_t hash = 0;
        touch_surface own{};
        if (touch_surface_create(held.hill.scene, nullptr, &own, nullptr) != TOUCH_OK) return 8;
        touch_solver solver{};
        if (HeldObjects::push(own, 0) != TOUCH_OK) return 9;
        if (touch_solver_create(own, nullptr, &solver, nullptr) != TOUCH_OK) return 10;
        if (touch_solver_force_hash(solver, &hash) != TOUCH_OK) return 11;
        if (touch_solver_destroy(solver) != TOUCH_OK || touch_surface_destroy(own) != TOUCH_OK) return 12;
        return touch_scene_destroy(held.hill.scene) == TOUCH_OK ? 0 : 13;
    });
    EXPECT_EQ(forgotten, 0) << "the step of that number";
    EXPECT_EQ(held.hill.tick(0), TOUCH_OK);
    EXPECT_EQ(touch_writer_abandon(held.writer), TOUCH_OK);
}

/// While other threads make and end objects.
TEST(Forks, ChildFindsTablesFree) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "a fork finds a sanitizer's own allocator locked by a thread that the child has not";
#endif
    const touch_camera camera = Hill::camera();
    std::atomic<bool> over = false;
    std::thread busy([&] {
        touch_scene scene{};
        while (!over)
            if (touch_scene_from_camera(&camera, &scene, nullptr) == TOUCH_OK) touch_scene_destroy(scene);
    });
    int hung = 0;
    for (int k = 0; k < 200 && hung == 0; ++k)
        hung = in_child([&] {
            touch_scene scene{};
            return touch_scene_from_camera(&camera, &scene, nullptr) == TOUCH_OK &&
                           touch_scene_destroy(scene) == TOUCH_OK
                       ? 0
                       : 1;
        });
    over = true;
    busy.join();
    EXPECT_EQ(hung, 0);
}

}  // namespace
}  // namespace touchable::test
