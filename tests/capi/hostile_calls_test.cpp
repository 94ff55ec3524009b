// SPDX-License-Identifier: Apache-2.0
// Random calls in random order: sizes that cannot be, NULL, handles of others and of the dead, numbers that
// are none, huge counts. Each gives a status; sanitizers see to the rest.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "capi/api_common.hpp"
#include "tests/capi/hill.hpp"

namespace touchable::test {
namespace {

/// A program that does everything wrong, sometimes.
class Hostile : public SpoiledValues {
public:
    explicit Hostile(unsigned seed) : SpoiledValues(seed) {}
    ~Hostile() {
        for (const touch_solver solver : solvers_) touch_solver_destroy(solver);
        for (const touch_surface surface : surfaces_) touch_surface_destroy(surface);
        for (const touch_scene scene : scenes_) touch_scene_destroy(scene);
    }

    touch_status call() {
        using Call = touch_status (Hostile::*)();
        static constexpr std::array<Call, 17> calls{&Hostile::defaults,
                                                    &Hostile::scene_from_camera,
                                                    &Hostile::scene_from_text,
                                                    &Hostile::scene_text,
                                                    &Hostile::describe,
                                                    &Hostile::with_filters,
                                                    &Hostile::end_something,
                                                    &Hostile::surface,
                                                    &Hostile::push,
                                                    &Hostile::push,
                                                    &Hostile::filtered,
                                                    &Hostile::epochs,
                                                    &Hostile::scale,
                                                    &Hostile::solver,
                                                    &Hostile::forces_at,
                                                    &Hostile::tick,
                                                    &Hostile::tick};
        return (this->*calls[upto(calls.size())])();
    }

private:
    touch_status scene_from_camera() {
        touch_camera camera = Hill::camera();
        spoil(camera.struct_size, camera.width, camera.fx_px, camera.cy_px, camera.metres_per_code,
              camera.far_m, camera.frames_per_second, camera.stiffness_n_per_m);
        touch_scene made{};
        return kept(touch_scene_from_camera(or_null(&camera), or_null(&made), error()), made, scenes_);
    }
    touch_status scene_from_text() {
        std::string text = R"({"touchable_scene": 1, "size": [4, 4], "camera": {"fx": 3, "fy": 3}})";
        text[upto(text.size())] = static_cast<char>(random_());
        touch_scene made{};
        return kept(touch_scene_from_text(or_null(text.data()), text.size(), or_null(&made), error()), made,
                    scenes_);
    }
    touch_status scene_text() {
        std::array<char, 100> text;
        std::size_t length;
        return touch_scene_text(one_of(scenes_), or_null(text.data()), upto(101), or_null(&length));
    }
    touch_status defaults() {
        const auto size = static_cast<std::uint32_t>(spoilt(std::uint32_t{64}));
        touch_camera camera;
        touch_frame frame;
        touch_surface_settings shape;
        touch_solver_settings solver;
        touch_camera_defaults(or_null(&camera), rarely() ? std::uint32_t{sizeof camera} : size);
        touch_frame_defaults(or_null(&frame), rarely() ? std::uint32_t{sizeof frame} : size);
        touch_surface_settings_defaults(or_null(&shape), rarely() ? std::uint32_t{sizeof shape} : size);
        std::int64_t newest;
        touch_surface_newest_ns(one_of(surfaces_), or_null(&newest));
        return touch_solver_settings_defaults(or_null(&solver),
                                              rarely() ? std::uint32_t{sizeof solver} : size);
    }
    touch_status describe() {
        touch_scene_facts facts;
        facts.struct_size = spoilt(std::uint32_t{sizeof facts});
        return touch_scene_describe(one_of(scenes_), or_null(&facts));
    }
    touch_status with_filters() {
        const touch_frame frame = spoilt_frame();
        touch_scene made{};
        return kept(touch_scene_with_filters(one_of(scenes_), or_null(&frame), spoilt(sizeof frame), upto(2),
                                             or_null(&made), error()),
                    made, scenes_);
    }
    /// The handle stays in the list, so that calls come to what has ended.
    touch_status end_something() {
        switch (upto(3)) {
            case 0:
                return touch_scene_destroy(one_of(scenes_));
            case 1:
                return touch_surface_destroy(one_of(surfaces_));
            default:
                return touch_solver_destroy(one_of(solvers_));
        }
    }
    touch_status surface() {
        touch_surface_settings settings;
        touch_surface_settings_defaults(&settings, sizeof settings);
        spoil(settings.struct_size, settings.threads, settings.frames, settings.error_bars);
        touch_surface made{};
        return kept(touch_surface_create(one_of(scenes_), or_null(&settings), or_null(&made), error()), made,
                    surfaces_);
    }
    touch_frame spoilt_frame() {
        touch_frame frame = hill_.frame(++number_);
        spoil(frame.struct_size, frame.number, frame.time_ns);
        touch_plane* const planes[] = {&frame.depth, &frame.colour, &frame.haptic, &frame.height};
        touch_plane& plane = *planes[rarely() ? upto(4) : 0];
        plane = frame.depth;
        if (rarely()) frame.lost_pixels = &lost_;
        if (rarely()) plane.data = nullptr;
        // Larger than the memory that there is only in ways that are seen to be wrong.
        if (rarely()) plane.width = static_cast<std::int32_t>(upto(2) ? -5 : 1 << 20);
        if (rarely()) plane.height = static_cast<std::int32_t>(upto(2) ? 0 : 1 << 30);
        if (rarely()) plane.stride_bytes = upto(2) ? std::numeric_limits<std::int64_t>::min() : 7;
        if (rarely()) plane.sample = static_cast<std::int32_t>(upto(2) ? 3 : 77);
        if (rarely()) plane.channels = static_cast<std::int32_t>(upto(2) ? 2 : -1);
        return frame;
    }
    touch_status push() {
        const touch_frame frame = spoilt_frame();
        return touch_surface_push(one_of(surfaces_), or_null(&frame), error());
    }
    touch_status epochs() {
        if (upto(2)) return touch_surface_end_epoch(one_of(surfaces_));
        return touch_surface_begin_epoch(one_of(surfaces_), spoilt(++epoch_), error());
    }
    touch_status filtered() {
        std::vector<float> floats(std::size_t{3} * Hill::width * Hill::height);
        touch_filtered wanted{sizeof wanted, 0, {}, 0, {}, 0, {}, 0};
        wanted.metres = wanted.error_degrees = or_null(floats.data());
        wanted.normals = or_null(floats.data());
        wanted.metres_stride_bytes = wanted.error_degrees_stride_bytes = 4 * Hill::width;
        wanted.normals_stride_bytes = 12 * Hill::width;
        if (upto(2)) wanted.error_degrees = nullptr;
        wanted.struct_size = spoilt(wanted.struct_size);
        if (rarely()) wanted.metres_stride_bytes = static_cast<std::int64_t>(upto(4 * Hill::width));
        return touch_surface_filtered(one_of(surfaces_), or_null(&wanted), error());
    }
    touch_status scale() {
        double found;
        return touch_surface_hand_scale(one_of(surfaces_), or_null(&found), error());
    }
    touch_status solver() {
        touch_solver_settings settings;
        touch_solver_settings_defaults(&settings, sizeof settings);
        settings.struct_size = spoilt(settings.struct_size);
        settings.fingers =
            rarely() ? spoilt(settings.fingers) : 1 + static_cast<std::int32_t>(upto(most_fingers_));
        settings.metres_per_scene_unit = spoilt(1.0);
        spoil(settings.max_force_n, settings.max_stiffness_n_per_m, settings.damping_n_s_per_m,
              settings.stribeck_m_per_s, settings.stale_after_ns, settings.ramp_in_ticks,
              settings.ramp_out_ticks);
        touch_solver made{};
        return kept(touch_solver_create(one_of(surfaces_), or_null(&settings), or_null(&made), error()), made,
                    solvers_);
    }
    touch_status forces_at() {
        touch_solver_settings settings;
        touch_solver_settings_defaults(&settings, sizeof settings);
        spoil(settings.struct_size, settings.fingers, settings.max_force_n, settings.stribeck_m_per_s);
        touch_tick at = tick_at(number_ * 33);
        spoil(at.struct_size, at.time_ns);
        std::array<touch_vec3, most_fingers_> points;
        for (touch_vec3& point : points) {
            point = goal_at(number_);
            point.y = spoilt(point.y);
        }
        const std::size_t stride = spoilt(sizeof(touch_contact));
        const bool is_wide = stride > sizeof(touch_contact);
        const std::size_t count = rarely() ? SIZE_MAX : upto(points.size() + 1);
        const touch_status status = touch_surface_forces_at(
            one_of(surfaces_), or_null(&settings), or_null(&at), spoilt(1), or_null(points.data()), count,
            or_null(contacts_.data()), is_wide ? SIZE_MAX : stride, error());
        expect_finite();
        return status;
    }
    void expect_finite() const {
        for (const touch_contact& contact : contacts_)
            EXPECT_TRUE(std::isfinite(contact.force_n.x + contact.force_n.y + contact.force_n.z));
    }
    touch_status tick() {
        const touch_solver solver = one_of(solvers_);
        if (rarely()) {
            std::uint64_t hash;
            std::size_t length = 0;
            switch (upto(5)) {
                case 0:
                    return touch_solver_come_back(solver);
                case 1:
                    return touch_solver_state_hash(solver, or_null(&hash));
                case 2:
                    return touch_solver_save(solver, or_null(saved_.data()), saved_.size(), or_null(&length));
                case 3:
                    return touch_solver_load(solver, or_null(saved_.data()), upto(saved_.size() + 1), error());
                default:
                    return touch_solver_force_hash(solver, or_null(&hash));
            }
        }
        touch_tick at = tick_at(++tick_);
        spoil(at.struct_size, at.tick, at.time_ns);
        at.epoch = rarely() ? spoilt(epoch_) : 0;
        at.epoch_start_ns = spoilt(at.epoch_start_ns);
        std::array<touch_vec3, most_fingers_> goals;
        for (touch_vec3& goal : goals) {
            goal = goal_at(tick_);
            spoil(goal.x, goal.z);
        }
        if (rarely()) {  // counts that no array has room for, or that have none
            static constexpr std::size_t counts[] = {0, (std::size_t{1} << 40) + 1, SIZE_MAX};
            return touch_solver_run(solver, or_null(&at), counts[upto(3)], or_null(goals.data()),
                                    or_null(contacts_.data()), sizeof(touch_contact));
        }
        // Room for as many fingers as any solver of this program has.
        const std::size_t stride = spoilt(sizeof(touch_contact));
        const bool is_wide = stride > sizeof(touch_contact);
        const touch_status status = touch_solver_tick(solver, or_null(&at), or_null(goals.data()),
                                                      or_null(contacts_.data()), is_wide ? SIZE_MAX : stride);
        expect_finite();
        return status;
    }

    static constexpr std::size_t most_fingers_ = 4;
    const Hill hill_;
    std::int64_t number_ = 0, tick_ = 0, lost_ = 0;
    std::uint64_t epoch_ = 0;
    std::vector<touch_scene> scenes_;
    std::vector<touch_surface> surfaces_;
    std::vector<touch_solver> solvers_;
    std::array<touch_contact, 256> contacts_{};
    std::array<std::uint8_t, 2000> saved_{};
};

TEST(HostileCalls, EachGivesStatus) {
    Hostile::Statuses seen{};
    for (unsigned seed = 1; seed <= 40; ++seed) {
        Hostile program(seed);
        ASSERT_NO_FATAL_FAILURE(Hostile::count_statuses(program, seen));
    }
    Hostile::expect_seen(seen, {TOUCH_OK, TOUCH_USAGE, TOUCH_INPUT, TOUCH_STALE, TOUCH_BUSY, TOUCH_FULL},
                         4000);
}

// Calls that the C API refuses, and their messages.

TEST(Statuses, HaveNames) {
    EXPECT_EQ(touch_version(), static_cast<std::uint32_t>(TOUCH_VERSION));
    EXPECT_STREQ(touch_status_name(TOUCH_STALE), "stale handle");
    EXPECT_STREQ(touch_status_name(TOUCH_EXISTS), "file exists");
    EXPECT_STREQ(touch_status_name(12345), "unknown status");
}

TEST(Statuses, ForeignHandlesAreStale) {
    touch_scene scene{};
    const touch_camera camera = Hill::camera();
    ASSERT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
    touch_surface surface{};
    ASSERT_EQ(touch_surface_create(scene, nullptr, &surface, nullptr), TOUCH_OK);
    touch_error error = no_error();
    touch_solver solver{};
    EXPECT_EQ(touch_solver_create({scene.id}, nullptr, &solver, &error), TOUCH_STALE);
    EXPECT_NE(std::string(error.line).find("surface"), std::string::npos) << error.line;
    EXPECT_EQ(touch_surface_destroy({scene.id}), TOUCH_STALE);
    EXPECT_EQ(touch_scene_destroy({surface.id}), TOUCH_STALE);
    EXPECT_EQ(touch_scene_destroy(scene), TOUCH_OK);
    EXPECT_EQ(touch_scene_destroy(scene), TOUCH_STALE);
    touch_scene next{};
    ASSERT_EQ(touch_scene_from_camera(&camera, &next, nullptr), TOUCH_OK);
    EXPECT_NE(next.id, scene.id) << "a place that is used again is another object";
    EXPECT_EQ(touch_scene_destroy(next), TOUCH_OK);
    EXPECT_EQ(touch_surface_destroy(surface), TOUCH_OK);
}

TEST(Statuses, SurfaceHasOneSolver) {
    TouchedHill hill;
    touch_solver second{};
    EXPECT_EQ(touch_solver_create(hill.surface, nullptr, &second, nullptr), TOUCH_BUSY);
    EXPECT_EQ(touch_surface_destroy(hill.surface), TOUCH_BUSY);
    EXPECT_EQ(touch_solver_destroy(hill.solver), TOUCH_OK);
    EXPECT_EQ(touch_solver_create(hill.surface, nullptr, &hill.solver, nullptr), TOUCH_OK);
}

/// A surface of one frame gives what its filters leave, never is full, and is not for fingers.
TEST(Statuses, SurfaceOfOneFrameIsForFilters) {
    const Hill hill;
    const touch_camera camera = Hill::camera();
    touch_scene scene{};
    ASSERT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
    touch_surface_settings settings;
    touch_surface_settings_defaults(&settings, sizeof settings);
    settings.frames = 1;
    touch_surface surface{};
    ASSERT_EQ(touch_surface_create(scene, &settings, &surface, nullptr), TOUCH_OK);
    std::vector<float> metres(std::size_t{Hill::width} * Hill::height), stored = metres;
    touch_filtered wanted{sizeof wanted, 0, metres.data(), 4 * Hill::width, nullptr, 0, nullptr, 0};
    const auto refused = [&](const char* words, touch_filtered asked) {
        touch_error error = no_error();
        EXPECT_EQ(touch_surface_filtered(surface, &asked, &error), TOUCH_USAGE);
        EXPECT_NE(std::string(error.line).find(words), std::string::npos) << error.line;
    };
    refused("no frame was pushed", wanted);
    for (std::int64_t number = 0; number < 9; ++number) {
        const touch_frame frame = hill.frame(number);
        ASSERT_EQ(touch_surface_push(surface, &frame, nullptr), TOUCH_OK);
        ASSERT_EQ(touch_surface_filtered(surface, &wanted, nullptr), TOUCH_OK);
        ASSERT_EQ(touch_scene_metres(scene, &frame.depth, stored.data(), 4 * Hill::width, nullptr), TOUCH_OK);
        EXPECT_EQ(metres, stored) << "no filter is on";
    }
    touch_filtered wrong = wanted;
    wrong.metres_stride_bytes -= 4;
    refused("metres_stride_bytes", wrong);
    wrong = wanted;
    wrong.normals = metres.data();
    wrong.normals_stride_bytes = 12 * Hill::width + 2;
    refused("multiple of 4", wrong);
    wrong = wanted;
    wrong.error_degrees = metres.data();
    wrong.error_degrees_stride_bytes = 4 * Hill::width;
    refused("error_bars", wrong);
    touch_solver solver{};
    EXPECT_EQ(touch_solver_create(surface, nullptr, &solver, nullptr), TOUCH_USAGE);
    touch_surface_destroy(surface);
    touch_scene_destroy(scene);
}

TEST(Statuses, FingersAreLimited) {
    TouchedHill hill;
    EXPECT_EQ(touch_solver_destroy(hill.solver), TOUCH_OK);
    touch_solver_settings settings;
    touch_solver_settings_defaults(&settings, sizeof settings);
    for (const auto& [fingers, expected] : {std::pair(0, TOUCH_USAGE), {257, TOUCH_USAGE}, {256, TOUCH_OK}}) {
        settings.fingers = fingers;
        EXPECT_EQ(touch_solver_create(hill.surface, &settings, &hill.solver, nullptr), expected) << fingers;
    }
}

TEST(Statuses, ErrorsNameWhatIsWrong) {
    touch_camera camera = Hill::camera();
    touch_scene scene{};
    touch_error error = no_error();
    camera.metres_per_code = -1;
    EXPECT_EQ(touch_scene_from_camera(&camera, &scene, &error), TOUCH_USAGE);
    EXPECT_NE(std::string(error.line).find("metres_per_code"), std::string::npos) << error.line;
    camera = Hill::camera();
    camera.fx_px = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(touch_scene_from_camera(&camera, &scene, &error), TOUCH_USAGE);
    const std::string text = R"({"touchable_scene": 1, "nonsense": 3})";
    EXPECT_EQ(touch_scene_from_text(text.data(), text.size(), &scene, &error), TOUCH_INPUT);
    EXPECT_GT(std::string(error.line).size(), 10U);
    touch_error small{offsetof(touch_error, line) + 8, 0, {}};
    EXPECT_EQ(touch_scene_from_text(text.data(), text.size(), &scene, &small), TOUCH_INPUT);
    EXPECT_EQ(std::string(small.line).size(), 7U) << "cut where there is no room";
}

/// A scene that ends at 1 m (Hill), and floats of which some are beyond.
class FarDepth : public testing::Test {
protected:
    FarDepth() : metres_(static_cast<std::size_t>(pixels), 0.5F) {}

    touch_status push(std::int64_t number = 1) {
        touch_frame frame = hill_.frame(number);
        frame.depth = Hill::plane_of(metres_);
        frame.lost_pixels = &lost_;
        error_ = no_error();
        return touched_.push(frame, &error_);
    }
    void fill(std::int64_t count, float metres) { std::fill_n(metres_.begin(), count, metres); }

    static constexpr std::int64_t pixels = std::int64_t{Hill::width} * Hill::height;
    TouchedHill touched_;
    const Hill hill_;
    std::vector<float> metres_;
    std::int64_t lost_ = -1;
    touch_error error_{};
};

TEST_F(FarDepth, IsCounted) {
    fill(pixels / 2, 3);
    metres_[0] = std::numeric_limits<float>::quiet_NaN();
    metres_[1] = std::numeric_limits<float>::infinity();
    metres_[2] = -3;
    metres_[3] = 0;
    EXPECT_EQ(push(), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, pixels / 2 - 4);
    fill(pixels, 0.5F);
    EXPECT_EQ(push(2), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, 0);
}

TEST_F(FarDepth, IsRejectedWhenMost) {
    fill(pixels / 2 + 1, 3);
    metres_[0] = 80;
    EXPECT_EQ(push(), TOUCH_USAGE);
    EXPECT_EQ(lost_, pixels / 2 + 1);
    const std::string line = error_.line;
    for (const char* said : {"1537 of its 3072", "0 to 1 m", "3 to 80", "millimetres", "far_m"})
        EXPECT_NE(line.find(said), std::string::npos) << said << ": " << line;
    // A lens that is covered but for some noise tells nothing of units.
    fill(pixels, 0);
    fill(pixels / 100 - 1, 3);
    EXPECT_EQ(push(), TOUCH_OK) << error_.line;
}

TEST_F(FarDepth, IsNotARenderersBackground) {
    fill(pixels * 3 / 4, 1e10F);
    fill(pixels / 4, 65504);
    EXPECT_EQ(push(), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, 0);
    fill(1, 65505);  // so 65504 is a depth
    EXPECT_EQ(push(2), TOUCH_OK) << error_.line;
    EXPECT_EQ(lost_, pixels / 4);
}

TEST(Statuses, FramesAreCheckedInOrder) {
    TouchedHill touched;
    const Hill hill;
    touch_error error = no_error();
    touch_frame frame = hill.frame(0);
    EXPECT_EQ(touched.push(frame, &error), TOUCH_USAGE) << "not later";
    frame = hill.frame(1);
    frame.depth.width = 63;
    EXPECT_EQ(touched.push(frame, &error), TOUCH_USAGE);
    EXPECT_NE(std::string(error.line).find("63x48"), std::string::npos) << error.line;
    frame = hill.frame(1);
    frame.depth.stride_bytes = 3;
    EXPECT_EQ(touched.push(frame, &error), TOUCH_USAGE);
    frame = hill.frame(1);
    frame.haptic = frame.depth;
    EXPECT_EQ(touched.push(frame, &error), TOUCH_USAGE);
    for (const std::int64_t far : {INT64_MIN, INT64_MAX}) {
        frame = hill.frame(1);
        frame.time_ns = far;
        EXPECT_EQ(touched.push(frame, &error), TOUCH_USAGE);
        EXPECT_NE(std::string(error.line).find("time_ns"), std::string::npos) << error.line;
    }
    int pushed = 0;
    touch_status status = TOUCH_OK;
    for (std::int64_t n = 1; n < 20 && status == TOUCH_OK; ++n) {
        frame = hill.frame(n);
        status = touched.push(frame, &error);
        pushed += status == TOUCH_OK;
    }
    EXPECT_EQ(status, TOUCH_FULL) << "without ticks";
    EXPECT_GE(pushed, 2);
    EXPECT_EQ(touch_surface_begin_epoch(touched.surface, 1, &error), TOUCH_OK);
    EXPECT_EQ(touch_surface_begin_epoch(touched.surface, 1, &error), TOUCH_USAGE);
    EXPECT_EQ(touch_surface_end_epoch(touched.surface), TOUCH_OK);
}

TEST(Statuses, NanGoalsRampAway) {
    TouchedHill touched;
    touch_contact& contact = touched.contact;
    const touch_vec3 deep{0, 0, -0.44};
    for (std::int64_t tick = 0; tick < 200; ++tick) ASSERT_EQ(touched.tick(tick, deep), TOUCH_OK);
    EXPECT_GT(contact.force_n.z, 0.5);
    EXPECT_EQ(contact.touching, 1);
    EXPECT_EQ(touched.tick(199, deep), TOUCH_USAGE) << "again";
    const touch_tick at = tick_at(200);
    EXPECT_EQ(touch_solver_tick(touched.solver, &at, &deep, &contact, 8), TOUCH_USAGE) << "no room";
    double before = contact.force_n.z;
    for (std::int64_t tick = 200; tick < 320; ++tick) {
        ASSERT_EQ(touched.tick(tick, {NAN, 0, 0}), TOUCH_OK);
        EXPECT_LE(contact.force_n.z, before);
        EXPECT_TRUE(contact.guard & TOUCH_GUARD_FAULT);
        before = contact.force_n.z;
    }
    EXPECT_EQ(contact.force_n.z, 0);
}

TEST(Statuses, ForceLimitHolds) {
    touch_solver_settings settings;
    touch_solver_settings_defaults(&settings, sizeof settings);
    settings.max_force_n = 0.25;
    TouchedHill touched(&settings);
    for (std::int64_t tick = 0; tick < 300; ++tick) {
        ASSERT_EQ(touched.tick(tick), TOUCH_OK);
        const touch_vec3& force = touched.contact.force_n;
        EXPECT_LE(std::hypot(force.x, force.y, force.z), 0.25);
    }
}

TEST(Statuses, SceneTextRoundTrips) {
    touch_scene scene{}, again{};
    const touch_camera camera = Hill::camera();
    ASSERT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
    std::size_t length = 0;
    ASSERT_EQ(touch_scene_text(scene, nullptr, 0, &length), TOUCH_OK);
    std::string text(length, ' ');
    ASSERT_EQ(touch_scene_text(scene, text.data(), text.size(), &length), TOUCH_OK);
    touch_error error = no_error();
    ASSERT_EQ(touch_scene_from_text(text.data(), text.size(), &again, &error), TOUCH_OK)
        << error.line << text;
    std::string same(length, ' ');
    ASSERT_EQ(touch_scene_text(again, same.data(), same.size(), &length), TOUCH_OK);
    EXPECT_EQ(text, same);
    touch_scene_facts facts{};
    facts.struct_size = sizeof facts;
    ASSERT_EQ(touch_scene_describe(again, &facts), TOUCH_OK);
    EXPECT_EQ(facts.width, Hill::width);
    EXPECT_EQ(facts.fx_px, 60);
    EXPECT_EQ(facts.metres_per_scene_unit, 1);
    EXPECT_EQ(facts.unstated_filters, 1) << "a camera states no filter";
    touch_scene filtered{};
    const Hill hill;
    std::vector<touch_frame> frames;
    for (int k = 0; k < 5; ++k) frames.push_back(hill.frame(k));
    ASSERT_EQ(
        touch_scene_with_filters(scene, frames.data(), sizeof frames[0], frames.size(), &filtered, &error),
        TOUCH_OK)
        << error.line;
    ASSERT_EQ(touch_scene_describe(filtered, &facts), TOUCH_OK);
    EXPECT_EQ(facts.unstated_filters, 0);
    for (const touch_scene each : {scene, again, filtered}) EXPECT_EQ(touch_scene_destroy(each), TOUCH_OK);
}

}  // namespace
}  // namespace touchable::test

namespace touchable::capi {

// A struct that has grown is understood from programs that were compiled before it did.

/// `later` came with a second version.
struct Grown {
    std::uint32_t struct_size;
    int first;
    int later;
};
template <>
inline constexpr std::size_t first_size<Grown> = 8;

namespace {

struct AsItWas {
    std::uint32_t struct_size;
    int first;
    int beyond;  ///< of the program, behind the struct
};

Grown& as_grown(AsItWas& old) {
    return reinterpret_cast<Grown&>(old);
}

TEST(StructSizes, FillOnlyOlderProgramsPart) {
    AsItWas old{0, 0, 77};
    EXPECT_EQ(give_defaults(Grown{0, 1, 2}, &as_grown(old), 8), TOUCH_OK);
    EXPECT_EQ(old.struct_size, 8U);
    EXPECT_EQ(old.first, 1);
    EXPECT_EQ(old.beyond, 77);
    hand_out(Grown{0, 5, 6}, as_grown(old));
    EXPECT_EQ(old.struct_size, 8U);
    EXPECT_EQ(old.first, 5);
    EXPECT_EQ(old.beyond, 77);
}

TEST(StructSizes, ReadOnlyOlderProgramsPart) {
    AsItWas old{8, 3, 77};
    EXPECT_TRUE(has_known_size(&as_grown(old)));
    const Grown wanted = over_defaults(&as_grown(old), Grown{sizeof(Grown), 1, 2});
    EXPECT_EQ(wanted.first, 3);
    EXPECT_EQ(wanted.later, 2) << "its default";
}

TEST(StructSizes, OlderFramesGetNoCount) {
    const touch_camera camera = test::Hill::camera();
    touch_scene scene{};
    touch_surface surface{};
    ASSERT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
    ASSERT_EQ(touch_surface_create(scene, nullptr, &surface, nullptr), TOUCH_OK);
    std::vector<float> metres = test::Hill().metres();
    metres[3] = 7;  // beyond the far plane
    std::int64_t lost = -1;
    // Also where only a part of the pointer is known, nothing is written.
    std::int64_t number = 0;
    double degrees = -1;
    for (const std::size_t size :
         {offsetof(touch_frame, lost_pixels), offsetof(touch_frame, lost_degrees) - 1,
          offsetof(touch_frame, lost_degrees), sizeof(touch_frame) - 1}) {
        EXPECT_EQ(touch_surface_begin_epoch(surface, static_cast<std::uint64_t>(number) + 1, nullptr),
                  TOUCH_OK);
        touch_frame frame = test::Hill().frame(number++);
        frame.depth = test::Hill::plane_of(metres);
        frame.lost_pixels = &lost;
        frame.lost_degrees = &degrees;
        frame.struct_size = static_cast<std::uint32_t>(size);
        EXPECT_EQ(touch_surface_push(surface, &frame, nullptr), TOUCH_OK);
        EXPECT_EQ(lost, size < offsetof(touch_frame, lost_degrees) ? -1 : 1) << size;
        EXPECT_EQ(degrees, -1) << size;
    }
    touch_frame old{};
    old.lost_pixels = &lost;
    EXPECT_EQ(touch_frame_defaults(&old, offsetof(touch_frame, lost_pixels)), TOUCH_OK);
    EXPECT_EQ(old.lost_pixels, &lost) << "of the program, behind the struct";
    touch_surface_destroy(surface);
    touch_scene_destroy(scene);
}

TEST(StructSizes, OlderContactsHaveNoErrorBars) {
    test::TouchedHill hill;
    const touch_tick at = test::tick_at(0);
    const touch_vec3 goal = test::goal_at(0);
    touch_contact old{};
    old.error_degrees = old.error_newtons = 77;
    EXPECT_EQ(touch_solver_tick(hill.solver, &at, &goal, &old, offsetof(touch_contact, error_degrees)),
              TOUCH_OK);
    EXPECT_EQ(old.struct_size, offsetof(touch_contact, error_degrees));
    EXPECT_EQ(old.error_degrees, 77) << "of the program, behind the struct";
    EXPECT_EQ(old.error_newtons, 77);
}

TEST(StructSizes, RejectUnknown) {
    Grown grown{4, 0, 0};
    EXPECT_FALSE(has_known_size(&grown));
    grown.struct_size = sizeof grown + 4;
    EXPECT_FALSE(has_known_size(&grown));
    EXPECT_FALSE(has_known_size<Grown>(nullptr));
    EXPECT_EQ(give_defaults(Grown{}, &grown, 4), TOUCH_USAGE);
    EXPECT_EQ(give_defaults(Grown{}, &grown, sizeof grown + 4), TOUCH_USAGE);
}

}  // namespace

}  // namespace touchable::capi
