// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "device/hand.hpp"
#include "device/hand_parts.hpp"
#include "device/point_motion.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "tests/device/fake_driver.hpp"
#include "tests/device/hand_path.hpp"

namespace touchable {
namespace {

constexpr std::size_t down_at = 250;        // ticks: the hand has come down
constexpr double deepest = 0.002 * 10 / 7;  // how far the default hand goes under a surface, device metres

double millimetres(double scene_units) {
    return scene_units * workspace.metres_per_scene_unit * 1000;
}

double scene_units(double millimetres) {
    return millimetres / 1000 / workspace.metres_per_scene_unit;
}

/// Millimetres of device space by which a goal is behind the surface under it; far below 0 over a hole.
double behind(const glm::dvec3& goal, const SurfaceProbe& probe) {
    const glm::dvec3 seen = probe.project(goal);
    const std::optional<double> surface = probe.depth_under(seen.x, seen.y);
    return surface ? millimetres(seen.z - *surface) : -std::numeric_limits<double>::infinity();
}

double most_behind(const Path& path, const SurfaceProbe& probe) {
    double most = -std::numeric_limits<double>::infinity();
    for (const glm::dvec3& goal : path) most = std::max(most, behind(goal, probe));
    return most;
}

double share_behind(const Path& path, const SurfaceProbe& probe) {
    const auto count = std::count_if(path.begin() + down_at, path.end(),
                                     [&](const glm::dvec3& goal) { return behind(goal, probe) > 0; });
    return static_cast<double>(count) / static_cast<double>(path.size() - down_at);
}

/// The number of times that a path crosses pixel column x.
int crossings(const Path& path, const SurfaceProbe& probe, double x) {
    int count = 0;
    for (std::size_t at = down_at + 1; at < path.size(); ++at) {
        if ((probe.project(path[at - 1]).x < x) != (probe.project(path[at]).x < x)) ++count;
    }
    return count;
}

// Walls stand at or about the picture's middle, where -Z, in which goals are pushed, is along the rays.

FakeProbe cliff_view(double left, double right) {
    return camera_view([left, right](double x, double) { return x < 320 ? left : right; });
}

FakeProbe post_view(double half_width) {
    return camera_view(
        [half_width](double x, double) { return std::fabs(x - 320) < half_width ? 500.0 : 800.0; });
}

/// Steps of 3 mm of device space, each 40 pixels wide, rising to the right.
FakeProbe stairs_view() {
    return camera_view([](double x, double) { return 800 - scene_units(3) * std::floor(x / 40 - 8); });
}

FakeProbe hole_view(double left, double right) {
    return camera_view([left, right](double x, double) -> std::optional<double> {
        if (x > 300 && x < 340) return std::nullopt;
        return x < 320 ? left : right;
    });
}

struct Ground {
    const char* name;
    FakeProbe probe;
    double step = 0;  // millimetres: of low walls away from the middle, into whose side goals are pushed
};

std::vector<Ground> grounds() {
    return {{"cliff up", cliff_view(800, 500)},
            {"cliff down", cliff_view(600, 900)},
            {"low cliff", cliff_view(800, 760)},
            {"wide post", post_view(12)},
            {"narrow post", post_view(0.8)},
            {"stairs", stairs_view(), 3},
            {"hole", hole_view(800, 800)},
            {"hole with a far side higher", hole_view(800, 600)},
            {"hole with a far side lower", hole_view(600, 800)}};
}

TEST(BrokenGround, GoalsStayOutOfWalls) {
    for (const Ground& ground : grounds()) {
        for (const std::string hand :
             {"stroke", "stroke:speed=0.5", "stroke:speed=2,max_speed=2", "stroke:speed=0.02,extent=0.1",
              "wander:speed=0.3", "poke:speed=0.5"}) {
            const double most = most_behind(run(hand, ground.probe), ground.probe);
            EXPECT_LE(most, 1000 * deepest + 0.3 + ground.step) << hand << " on a " << ground.name;
        }
    }
}

TEST(BrokenGround, StrokeCrossesAndDescends) {
    for (const Ground& ground : grounds()) {
        const Path path = run("stroke:speed=0.2,glide=30", ground.probe);
        EXPECT_GE(crossings(path, ground.probe, 320), 3) << ground.name;
        EXPECT_GE(share_behind(path, ground.probe), 0.5) << ground.name;
    }
}

TEST(BrokenGround, FingerRisesBeforeCliff) {
    const FakeProbe probe = cliff_view(800, 500);
    const Path path = run("stroke", probe);
    int waited = 0;
    for (std::size_t at = down_at + 1; at < path.size(); ++at) {
        const glm::dvec3 seen = probe.project(path[at]);
        if (std::fabs(seen.x - 320) < 0.5) {
            EXPECT_LT(seen.z, 500) << "in the wall's column";
        }
        const double before = probe.project(path[at - 1]).x;
        if (seen.x < 320 && std::fabs(seen.x - before) < 0.05 && path[at].z > path[at - 1].z) ++waited;
    }
    EXPECT_GT(waited, 40) << "47 mm at 0.5 mm a tick";
}

TEST(BrokenGround, FingerHoversAboveHoleRim) {
    for (const auto& [left, right] : {std::pair{800.0, 800.0}, {800.0, 600.0}, {600.0, 800.0}}) {
        const FakeProbe probe = hole_view(left, right);
        const Path path = run("stroke", probe);
        int over = 0;
        for (std::size_t at = down_at; at < path.size(); ++at) {
            const glm::dvec3 seen = probe.project(path[at]);
            if (seen.x < 301 || seen.x > 339) continue;
            ++over;
            EXPECT_LT(seen.z, std::max(left, right)) << seen.x;
        }
        EXPECT_GT(over, 50);
    }
}

TEST(BrokenGround, FingerHopsAfterClimbingStep) {
    const FakeProbe probe = stairs_view();
    // Slow: a hop of 70 ms is over within 2.5 mm. So far it only goes to the right, up the stairs.
    const Path path = run("stroke:speed=0.03,glide=1", probe, 1, 2100);
    for (const double foot : {440.0, 480.0, 520.0}) {
        const double tread = 800 - scene_units(3) * (foot / 40 - 8);
        double highest = 0;  // above the tread, within 2.5 mm of its edge
        for (std::size_t at = down_at; at < path.size(); ++at) {
            const glm::dvec3 seen = probe.project({path[at].x, path[at].y, -tread});
            if (seen.x > foot && seen.x < foot + 10)
                highest = std::max(highest, millimetres(tread + path[at].z));
        }
        EXPECT_NEAR(highest, 1, 0.1) << "at the step to " << tread;
    }
}

TEST(BrokenGround, FollowsSmoothSlopesWithoutLifting) {
    const std::vector<FakeProbe> slopes{
        // Planes of 45 degrees, facing left and up, and a hill of radius 400.
        camera_view([](double x, double) { return 800 / (1 + (x - 320) / 500); }),
        camera_view([](double, double y) { return 800 / (1 - (y - 240) / 500); }),
        camera_view([](double x, double y) {
            const double across = (x - 320) / 500, down = (y - 240) / 500;
            const double square = 1 + across * across + down * down;
            return (1200 - std::sqrt(1200 * 1200 - square * (1200 * 1200 - 1000 * 1000))) / square;
        })};
    for (const FakeProbe& probe : slopes) {
        for (const std::string hand : {"stroke:depth=0,extent=0.6", "stroke:depth=0,extent=0.6,angle=90",
                                       "wander:depth=0,extent=0.6"}) {
            const Path path = run(hand, probe);
            for (std::size_t at = down_at; at < path.size(); ++at) {
                // The mean of 5 mm of the hill's arc lies (5 mm)^2 / 24 / 156 mm below it.
                const double below = &probe == &slopes.back() ? 0.008 : 0;
                ASSERT_NEAR(behind(path[at], probe), below / 2, below / 2 + 1e-9)
                    << hand << " at tick " << at;
            }
        }
    }
}

TEST(BrokenGround, PathWaitsForEveryFinger) {
    // One of four fingers meets the cliff long before the others: all stop.
    const FakeProbe probe = cliff_view(800, 500);
    constexpr std::size_t fingers = 4;
    const Path path = run("stroke:spread=0.03,max_speed=1", probe, fingers, 3000);
    int stopped = 0;
    for (std::size_t at = (down_at + 1) * fingers; at + fingers <= path.size(); at += fingers) {
        // Finger 2 is on the circle's other side, on even ground.
        if (path[at + 2] != path[at + 2 - fingers]) continue;
        ++stopped;
        EXPECT_GT(behind(path[at + 2], probe), 0);
        EXPECT_NEAR(probe.project(path[at]).x, probe.project(path[at - fingers]).x, 0.2)
            << "it only rises, or comes down";
    }
    EXPECT_GT(stopped, 30);
}

TEST(BrokenGround, PressDescendsBesideCliff) {
    // A press never moves sideways: a cliff beside it is no obstacle.
    const FakeProbe probe = cliff_view(800, 500);
    EXPECT_GT(share_behind(run("press:x=0.4995", probe), probe), 0.4);
}

/// Steps of up to 4 mm every few pixels; from frame to frame others.
FakeProbe rough_view(int frame) {
    return camera_view([frame](double x, double y) {
        auto hash =
            static_cast<std::uint32_t>(x / 6) * 2654435761u + static_cast<std::uint32_t>(y / 6) * 40503u;
        hash = (hash ^ static_cast<std::uint32_t>(frame)) * 2246822519u;
        return 800 - scene_units(4) * ((hash >> 8) & 0xff) / 255;
    });
}

/// Greatest speed and acceleration of a hand that was at rest before its first tick, over frames of 33 ms.
struct Motion {
    double speed = 0, acceleration = 0;  // device metres, seconds
    int shortest_hop = 1'000'000, hops = 0;
};
Motion motion_of(const std::string& description, std::span<const FakeProbe> frames, int fingers, int ticks) {
    auto hand = make_hand(description, fingers, workspace, frames[0]);
    if (!hand) {
        ADD_FAILURE() << hand.error().message;
        return {};
    }
    const auto count = static_cast<std::size_t>(fingers);
    Path goals(count), before(count);
    std::vector<glm::dvec3> velocity(count, glm::dvec3(0.0));
    std::vector<int> hopping(count, 0);
    Motion motion;
    for (int tick = 0; tick < ticks; ++tick) {
        (*hand)->goals_at(tick, frames[static_cast<std::size_t>(tick / 33) % frames.size()], goals);
        for (std::size_t k = 0; k < count; ++k) {
            const glm::dvec3 now = tick == 0
                                       ? glm::dvec3(0.0)
                                       : (goals[k] - before[k]) * (workspace.metres_per_scene_unit * 1000);
            motion.speed = std::max(motion.speed, glm::length(now));
            motion.acceleration = std::max(motion.acceleration, glm::length(now - velocity[k]) * 1000);
            velocity[k] = now;
            if ((*hand)->hops(k)) {
                ++hopping[k];
            } else if (const int hop = std::exchange(hopping[k], 0); hop > 0) {
                motion.shortest_hop = std::min(motion.shortest_hop, hop);
                ++motion.hops;
            }
        }
        before = goals;
    }
    return motion;
}

TEST(ScriptedHand, MovesAsHandsDo) {
    std::vector<std::vector<FakeProbe>> views;
    for (const Ground& ground : grounds()) views.push_back({ground.probe});
    views.push_back({rough_view(0)});
    views.push_back({rough_view(0), rough_view(1), rough_view(2), cliff_view(800, 500)});
    int hops = 0;
    for (const std::string hand :
         {"wander", "wander:speed=0.5,seed=7,glide=2", "wander:extent=0.05,depth=50,seed=3,glide=0", "stroke",
          "stroke:speed=0.5,angle=30,glide=1,extent=0.2", "press", "press:period=0.05,depth=50,lift=50",
          "press:period=0.05,lift=1", "poke", "poke:speed=0.5,period=0.05,seed=5", "poke:depth=50,lift=0"})
        for (const int fingers : {1, 3, 10})
            for (std::size_t view = 0; view < views.size(); ++view) {
                const Motion motion = motion_of(hand, views[view], fingers, 1200);
                EXPECT_LT(motion.speed, 0.5) << hand << " on " << view;
                EXPECT_LT(motion.acceleration, 20) << hand << " on " << view;
                EXPECT_GE(motion.shortest_hop, 40) << hand << " on " << view;
                hops += motion.hops;
            }
    EXPECT_GT(hops, 1000);
}

TEST(ScriptedHand, MovesFasterIfAsked) {
    const std::vector<FakeProbe> cliff{cliff_view(800, 500)};
    const Motion motion = motion_of("stroke:max_speed=2", cliff, 1, 2000);
    EXPECT_GT(motion.speed, 0.9);
    EXPECT_LT(motion.speed, 2);
    EXPECT_LT(motion.acceleration, 80);
}

TEST(ScriptedHand, HopLeavesSurfaceForFortyMilliseconds) {
    const FakeProbe probe =
        camera_view([](double x, double) { return x < 420 ? 800 : 800 - scene_units(0.5); });
    for (const std::string depth : {"1", "2", "5", "20", "50"}) {
        const Path path = run("stroke:glide=2,depth=" + depth, probe, 1, 1200);
        std::vector<int> aloft;
        for (std::size_t at = down_at; at < path.size(); ++at) {
            if (behind(path[at], probe) > 0) continue;
            if (aloft.empty() || behind(path[at - 1], probe) > 0) aloft.push_back(0);
            ++aloft.back();
        }
        if (behind(path.back(), probe) <= 0) aloft.pop_back();  // it is not over
        ASSERT_GE(aloft.size(), 1u) << depth;
        for (const int ticks : aloft) EXPECT_GE(ticks, 40) << depth;
    }
}

// The kind of ground that a gliding finger sees, by the limits of docs/touch.md ("Cliffs, holes and rough
// ground"), on surfaces whose steps, slopes and bends are given.

using Kind = LocalRelief::Kind;

constexpr double usual_reach = 0.0006;        // metres: that of a hand that moves slowly
constexpr double mm_per_pixel = 800 / 500.0;  // of the views below, at their middle

double tangent(double degrees) {
    return std::tan(degrees * std::acos(-1.0) / 180);
}

/// A millimetre of the scene is one of the device. `rise` of a place so many millimetres right of the middle:
/// millimetres towards the camera.
LocalRelief in_the_middle(double reach, const std::function<std::optional<double>(double)>& rise) {
    const FakeProbe probe = camera_view([&rise](double x, double) -> std::optional<double> {
        const auto here = rise((x - 320) * mm_per_pixel);
        return here ? std::optional(800 - *here) : std::nullopt;
    });
    return local_relief(probe, {320, 240}, 800, reach, 0.001, middle_of(probe, 1));
}

/// A quarter of a millimetre from the finger.
LocalRelief beside_step(double up_mm) {
    return in_the_middle(usual_reach, [up_mm](double right) { return right > 0.25 ? up_mm : 0; });
}

TEST(LocalRelief, SixMillimetreStepIsCliff) {
    EXPECT_EQ(beside_step(6.1).kind, Kind::broken);
    EXPECT_EQ(beside_step(-6.1).kind, Kind::broken);
    EXPECT_EQ(beside_step(5.9).kind, Kind::rough);
    EXPECT_EQ(beside_step(-5.9).kind, Kind::smooth) << "a proxy goes down it";
}

TEST(LocalRelief, FindsHighestPointWithinReach) {
    EXPECT_DOUBLE_EQ(beside_step(6.5).highest, 800 - 6.5);
    EXPECT_DOUBLE_EQ(beside_step(2).highest, 800 - 2);
    EXPECT_EQ(beside_step(-6.5).highest, 800);
}

TEST(LocalRelief, IgnoresWallBeyondReach) {
    const auto wall = [](double right) { return right > 0.65 ? 50.0 : 0.0; };
    EXPECT_EQ(in_the_middle(usual_reach, wall).kind, Kind::smooth);
    EXPECT_EQ(in_the_middle(0.0007, wall).kind, Kind::broken);
}

TEST(LocalRelief, HoleWithinReachIsCliff) {
    const auto hole = [](double right) { return right > 0.25 ? std::nullopt : std::optional(0.0); };
    const LocalRelief local_relief = in_the_middle(usual_reach, hole);
    EXPECT_EQ(local_relief.kind, Kind::broken);
    EXPECT_EQ(local_relief.highest, 800);
}

/// A hand so fast that it looks 8 mm far rises by more than 6 mm on a slope that it may well follow.
TEST(LocalRelief, SteepSlopeIsCliff) {
    for (const double side : {-1.0, 1.0}) {
        const auto slope = [side](double degrees) {
            return [slope = side * tangent(degrees)](double right) { return slope * right; };
        };
        EXPECT_EQ(in_the_middle(0.008, slope(64)).kind, Kind::smooth);
        EXPECT_EQ(in_the_middle(0.008, slope(66)).kind, Kind::broken);
        EXPECT_EQ(in_the_middle(usual_reach, slope(64)).kind, Kind::smooth);
        EXPECT_EQ(in_the_middle(usual_reach, slope(66)).kind, Kind::rough) << "1.3 mm within reach";
    }
}

/// A fold straight under the finger, whose sides rise or fall.
TEST(LocalRelief, ValleyOfSteepSidesIsRough) {
    const auto fold = [](double degrees) {
        return [slope = tangent(degrees)](double right) { return slope * std::fabs(right); };
    };
    EXPECT_EQ(in_the_middle(usual_reach, fold(64)).kind, Kind::smooth);
    EXPECT_EQ(in_the_middle(usual_reach, fold(66)).kind, Kind::rough);
    EXPECT_EQ(in_the_middle(usual_reach, fold(-80)).kind, Kind::smooth) << "no wall before a proxy";
}

/// A wedge a millimetre high that reaches from beside the finger out into one of the directions that are
/// looked at.
TEST(LocalRelief, SeesBumpInEachDirection) {
    constexpr int directions = 12;
    const double pi = std::acos(-1.0);
    for (int k = 0; k < directions; ++k) {
        const FakeProbe probe = camera_view([&](double x, double y) -> std::optional<double> {
            const double off = std::atan2(240 - y, x - 320) - 2 * pi * k / directions;
            const bool is_centre = x == 320 && y == 240;
            return !is_centre && std::cos(off) > std::cos(pi / directions) ? 799 : 800;
        });
        const auto relief = local_relief(probe, {320, 240}, 800, usual_reach, 0.001, middle_of(probe, 1));
        EXPECT_EQ(relief.kind, Kind::rough) << k;
    }
}

/// The nearest places that are looked at are 0.15 mm away.
TEST(LocalRelief, LowStepIsSmooth) {
    const auto step = [](double mm) {
        return in_the_middle(usual_reach, [mm](double right) { return right > 0.1 ? mm : 0; }).kind;
    };
    EXPECT_EQ(step(0.31), Kind::smooth);
    EXPECT_EQ(step(0.33), Kind::rough);
}

TEST(LocalRelief, IgnoresGroundOutsideArea) {
    const FakeProbe probe = camera_view([](double x, double) { return x > 320 ? 400.0 : 800.0; });
    const HandArea left{{0, 0}, {320, 479}};
    EXPECT_EQ(local_relief(probe, {320, 240}, 800, usual_reach, 0.001, left).kind, Kind::smooth);
}

constexpr double tick = 0.001;  // s
constexpr double any_speed = 1e9;
const LedPoint::Times times{0.02, 0.08};
const glm::dvec3 slow_way = glm::normalize(glm::dvec3(0.3, -0.2, -1));

/// Share of a way that a critically damped spring has left after t seconds, from rest.
double left_after(double t, double time_constant) {
    return (1 + t / time_constant) * std::exp(-t / time_constant);
}

TEST(LedPoint, MovesAsCriticallyDampedSpring) {
    LedPoint point(times, tick);
    const glm::dvec3 start(0.01, 0.02, -0.03), way(0.02, -0.01, 0.04), goal = start + way;
    const glm::dvec3 along = glm::dot(way, slow_way) * slow_way, across = way - along;
    point.put(start);
    for (int k = 1; k <= 300; ++k) {
        point.follow(goal, slow_way, any_speed);
        const double t = k * tick;
        const glm::dvec3 left = left_after(t, times.across_s) * across + left_after(t, times.along_s) * along;
        EXPECT_LT(glm::length(goal - left - point.place()), 1e-15) << k;
        const glm::dvec3 velocity =
            t / times.across_s / times.across_s * std::exp(-t / times.across_s) * across +
            t / times.along_s / times.along_s * std::exp(-t / times.along_s) * along;
        EXPECT_LT(glm::length(velocity - point.velocity()), 1e-13) << k;
    }
}

/// Half the way from the lowest to the highest place while the goal swings along `slow_way` by 1 mm.
double swing(double frequency) {
    LedPoint point(times, tick);
    double least = 1, greatest = -1;
    for (int k = 0; k < 8000; ++k) {
        point.follow(0.001 * std::sin(2 * pi * frequency * k * tick) * slow_way, slow_way, any_speed);
        if (k < 3000) continue;
        const double place = glm::dot(point.place(), slow_way);
        least = std::min(least, place);
        greatest = std::max(greatest, place);
    }
    return (greatest - least) / 2;
}

TEST(LedPoint, FollowsShapeAndSmoothsBumps) {
    for (const double frequency : {0.25, 2.0, 10.0}) {
        const double x = 2 * pi * frequency * times.along_s;
        EXPECT_NEAR(swing(frequency), 0.001 / (1 + x * x), 3e-6) << frequency;  // held goals: nearly this
    }
}

TEST(LedPoint, NeverExceedsSpeedOrOvershoots) {
    for (const double max_speed : {0.1, 1.0, 5.0}) {
        LedPoint point(times, tick);
        const glm::dvec3 goal(0.3, 0.2, -0.5);
        glm::dvec3 before = point.place();
        bool limited = false;
        for (int k = 0; k < 9000; ++k) {
            point.follow(goal, slow_way, max_speed);
            const double step = glm::length(point.place() - before);
            EXPECT_LE(step, max_speed * tick * (1 + 1e-12));
            limited = limited || step > 0.99 * max_speed * tick;
            const glm::dvec3 left = goal - point.place();
            EXPECT_GE(glm::dot(left, slow_way), -1e-12);
            EXPECT_GE(glm::dot(left, goal - glm::dot(goal, slow_way) * slow_way), -1e-12);
            before = point.place();
        }
        EXPECT_TRUE(limited) << max_speed;
        EXPECT_LT(glm::length(goal - point.place()), 1e-8);
    }
}

TEST(LedPoint, ViewRotationCausesNoMotion) {
    LedPoint still(times, tick), moving(times, tick);
    for (int k = 0; k < 100; ++k) {
        const glm::dvec3 along(sine(0.1 * k), 0, -cosine(0.1 * k));
        still.follow(glm::dvec3(0), along, 1);
        EXPECT_EQ(still.place(), glm::dvec3(0));
        const glm::dvec3 before = moving.place();
        moving.follow({0.02, 0.01, -0.03}, along, 1);
        EXPECT_LE(glm::length(moving.place() - before), 1e-3);
    }
}

TEST(LedPoint, IsBitIdenticalEverywhere) {
    LedPoint point({0.025, 0.09}, tick);
    const glm::dvec3 along(0.6, 0, -0.8);
    for (int k = 0; k < 150; ++k) point.follow({0.01 + 1e-5 * k, 0.02, -0.03}, along, 0.3);
    // The bits of GCC and Clang, with and without optimisation.
    EXPECT_EQ(point.place(), glm::dvec3(0x1.a67e41bc62aa8p-10, 0x1.413ff5415eb9cp-6, -0x1.1913c64c6fed4p-6));
    EXPECT_EQ(point.velocity(),
              glm::dvec3(0x1.103cd07e1cc86p-4, 0x1.b5d01460bc636p-7, -0x1.62e2c610b3f8fp-4));
}

/// A row of 16384 pixels; every second one is a hole, and so is the surface between them.
TEST(ScriptedHand, SearchesRowOfHolesOnce) {
    std::int64_t looks = 0;
    const FakeProbe probe(16384, 1, 500, [&looks](double x, double) -> std::optional<double> {
        ++looks;
        return std::fmod(x, 2) == 0 ? std::optional(800.0) : std::nullopt;
    });
    for (const char* hand : {"wander", "stroke", "press", "poke"}) {
        looks = 0;
        EXPECT_TRUE(make_hand(hand, 20, workspace, probe));
        EXPECT_LT(looks, 3 * 16384) << hand;
        std::stop_source given_up;
        given_up.request_stop();
        const auto stopped =
            work_until(given_up.get_token(), [&] { return make_hand(hand, 20, workspace, probe); });
        ASSERT_FALSE(stopped);
        EXPECT_EQ(stopped.error().kind, ErrorKind::interrupted) << hand;
    }
}

FakeProbe speck_at(double at_x, double at_y) {
    return camera_view([=](double x, double y) -> std::optional<double> {
        if (x != at_x || y != at_y) return std::nullopt;
        return 100 + x + y;
    });
}

TEST(NearestSurface, ReturnsStartOnSurface) {
    const FakeProbe probe = flat_view();
    const auto found = nearest_surface(probe, {10.25, 20.5}, middle_of(probe, 1));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->pixel, glm::dvec2(10.25, 20.5));
    EXPECT_EQ(found->depth, 800);
}

TEST(NearestSurface, FindsSinglePixelInBox) {
    for (const glm::dvec2 at :
         {glm::dvec2(0, 0), {639, 479}, {639, 0}, {0, 479}, {320, 240}, {321, 7}, {3, 240}}) {
        const FakeProbe probe = speck_at(at.x, at.y);
        const auto found = nearest_surface(probe, {320, 240}, middle_of(probe, 1));
        ASSERT_TRUE(found) << at.x << " " << at.y;
        EXPECT_EQ(found->pixel, at);
        EXPECT_EQ(found->depth, 100 + at.x + at.y);
    }
}

TEST(NearestSurface, IgnoresPixelsOutsideBox) {
    const FakeProbe probe = speck_at(10, 10);
    EXPECT_FALSE(nearest_surface(probe, {320, 240}, middle_of(probe, 0.5)));
}

TEST(NearestSurface, PrefersClosestInRing) {
    const FakeProbe probe = camera_view([](double x, double y) -> std::optional<double> {
        if (x == 326 && y == 246) return 1.0;
        if (x == 314 && y == 240) return 2.0;
        return std::nullopt;
    });
    EXPECT_EQ(nearest_surface(probe, {320, 240}, middle_of(probe, 1))->depth, 2.0);
}

TEST(PictureMiddle, IsCentredAndScaled) {
    const FakeProbe probe = flat_view();
    const HandArea whole = middle_of(probe, 1), half = middle_of(probe, 0.5);
    EXPECT_EQ(whole.least, glm::dvec2(0, 0));
    EXPECT_EQ(whole.greatest, glm::dvec2(639, 479));
    EXPECT_EQ(half.least, glm::dvec2(159.75, 119.75));
    EXPECT_EQ(half.greatest, glm::dvec2(479.25, 359.25));
}

TEST(Workspace, DefaultSpansSixteenCentimetres) {
    const Workspace workspace = default_workspace(640, 500, 800);
    EXPECT_EQ(workspace.origin, glm::dvec3(0, 0, -800));
    EXPECT_EQ(device_depth(workspace), 800);
    const FakeProbe probe = flat_view();
    const glm::dvec3 left = workspace.to_device(probe.unproject(0, 240, 800));
    const glm::dvec3 right = workspace.to_device(probe.unproject(640, 240, 800));
    EXPECT_NEAR(right.x - left.x, 0.16, 1e-15);
    EXPECT_NEAR(right.z, 0, 1e-15);
}

TEST(Workspace, RoundTripKeepsPosition) {
    const Workspace workspace{0.004, {1, 2, -30}};
    const glm::dvec3 there = workspace.to_scene({0.008, -0.004, 0.02});
    EXPECT_NEAR(there.x, 3, 1e-12);
    EXPECT_NEAR(there.y, 1, 1e-12);
    EXPECT_NEAR(there.z, -25, 1e-12);
    EXPECT_NEAR(workspace.to_device(there).z, 0.02, 1e-15);
}

/// Goals about a plane at 800 mm; a millimetre of the scene is one of the device.
class WatchedGoals : public ::testing::Test {
protected:
    void look(int often, const glm::dvec3& goal) {
        for (int time = 0; time < often; ++time) {
            glm::dvec3 looked_at = goal;
            watch.look(probe, std::span(&looked_at, 1));
            EXPECT_TRUE(looked_at == goal || goal != goal) << "it stays";
        }
    }
    glm::dvec3 below(double millimetres) const { return probe.unproject(320, 240, 800 + millimetres); }
    glm::dvec3 at(double x, double y) const { return probe.unproject(x, y, 800); }

    const FakeProbe probe = flat_view(800);
    GoalWatch watch{0.001, std::nullopt};
    const std::vector<std::string> far_below{
        "1.0 % of the goals lie more than 10 mm below the surface; depth=MM among the hand's keys raises "
        "them"};
    const std::vector<std::string> outside{
        "1.0 % of the goals lie outside the picture, where there is only the wall around it"};
};

TEST_F(WatchedGoals, ReportsGoalsFarBelowSurface) {
    look(100, below(9.9));
    EXPECT_TRUE(watch.remarks().empty());
    look(1, below(10.1));
    EXPECT_TRUE(watch.remarks().empty()) << "one of 101 is less than 1 %";
    look(1, below(10.1));
    look(98, below(-50));
    EXPECT_EQ(watch.remarks(), far_below) << "two of 200";
}

TEST_F(WatchedGoals, CountsEdgeAsInside) {
    look(96, at(320, 240));
    for (const auto& [x, y] : {std::pair{0, 0}, {639, 0}, {0, 479}, {639, 479}}) look(25, at(x, y));
    EXPECT_TRUE(watch.remarks().empty());
}

TEST_F(WatchedGoals, ReportsGoalsOutsidePicture) {
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    for (const glm::dvec3& goal : {at(-0.5, 240), at(639.5, 240), at(320, -0.5), at(320, 479.5),
                                   glm::dvec3(0, 0, 5), glm::dvec3(0, 0, 0), glm::dvec3(nowhere)}) {
        watch = GoalWatch(0.001, std::nullopt);
        look(99, at(320, 240));
        look(1, goal);
        EXPECT_EQ(watch.remarks(), outside) << goal.x << ' ' << goal.y << ' ' << goal.z;
    }
}

}  // namespace
}  // namespace touchable

namespace touchable::test {
namespace {

constexpr std::int64_t tick_ns = 1'000'000;

TEST(PlausibleMotion, AcceptsMovingHand) {
    PlausibleMotion motion;
    for (std::int64_t tick = 1; tick <= 1000; ++tick)
        ASSERT_TRUE(
            motion.believe({0.002 * std::abs(static_cast<double>(tick % 100 - 50)), 0, 0}, tick * tick_ns))
            << tick;
}

TEST(PlausibleMotion, SkipsSingleBadPosition) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    EXPECT_FALSE(motion.believe({0.131, 0, 0}, 2 * tick_ns));
    EXPECT_FALSE(motion.believe({0, std::numeric_limits<double>::quiet_NaN(), 0}, 3 * tick_ns));
    EXPECT_FALSE(motion.believe({0, 0, std::numeric_limits<double>::infinity()}, 4 * tick_ns));
    const auto next = motion.believe({0.001, 0, 0}, 5 * tick_ns);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->x, 0.001);
}

TEST(PlausibleMotion, AcceptsNewPositionAfterDelay) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    for (std::int64_t tick = 2; tick < 152; ++tick)
        ASSERT_FALSE(motion.believe({0.3, 0, 0}, tick * tick_ns)) << "believed after " << tick - 2 << " ms";
    EXPECT_TRUE(motion.believe({0.3, 0, 0}, 152 * tick_ns));
}

TEST(PlausibleMotion, RejectsJumpingPositions) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    for (std::int64_t tick = 2; tick < 1000; ++tick)
        EXPECT_FALSE(motion.believe({tick % 2 == 0 ? 0.3 : -0.3, 0, 0}, tick * tick_ns));
}

TEST(PlausibleMotion, RejectsJumpAfterGap) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    EXPECT_FALSE(motion.believe({0.06, 0, 0}, 1000 * tick_ns));
    motion.forget();
    EXPECT_TRUE(motion.believe({0.06, 0, 0}, 1001 * tick_ns));
}

/// docs/devices.md: 5 m/s, and 52 mm after any gap; 2 mm of them are slack.
TEST(PlausibleMotion, LimitsSpeedAndUnseenDistance) {
    const auto believes = [](double metres, std::int64_t ms) {
        PlausibleMotion motion;
        EXPECT_TRUE(motion.believe({0, 0, 0}, tick_ns));
        return motion.believe({0, metres, 0}, tick_ns + ms * tick_ns).has_value();
    };
    EXPECT_TRUE(believes(0.0069, 1));
    EXPECT_FALSE(believes(0.0071, 1));
    EXPECT_TRUE(believes(0.0269, 5));
    EXPECT_FALSE(believes(0.0271, 5));
    for (const std::int64_t gap_ms : {10, 11, 100, 100'000}) {
        EXPECT_TRUE(believes(0.0519, gap_ms)) << gap_ms;
        EXPECT_FALSE(believes(0.0521, gap_ms)) << gap_ms;
    }
}

TEST(PlausibleMotion, RejectsPositionsBeyondRoom) {
    PlausibleMotion motion;
    EXPECT_FALSE(motion.believe({0, 5.1, 0}, 1 * tick_ns));
    EXPECT_TRUE(motion.believe({0, 4.9, 0}, 2 * tick_ns));
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

using Points = std::vector<glm::dvec3>;

/// A cloud with the given sizes along three perpendicular directions.
Points cloud(const glm::dmat3& directions, const glm::dvec3& sizes, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Points points;
    for (int i = 0; i < 2000; ++i) {
        points.push_back(directions * (sizes * glm::dvec3(normal(random), normal(random), normal(random))) +
                         glm::dvec3(3, -2, 0.5));
    }
    return points;
}

glm::dmat3 some_rotation(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const glm::dvec3 x = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    const glm::dvec3 z =
        glm::normalize(glm::cross(x, glm::dvec3(normal(random), normal(random), normal(random))));
    return glm::dmat3(x, glm::cross(z, x), z);
}

glm::dmat3 covariance(const Points& points) {
    glm::dvec3 mean(0);
    for (const glm::dvec3& p : points) mean += p / static_cast<double>(points.size());
    glm::dmat3 sum(0.0);
    for (const glm::dvec3& p : points) sum += glm::outerProduct(p - mean, p - mean);
    return sum / static_cast<double>(points.size());
}

void expect_proper(const glm::dmat3& r) {
    const glm::dmat3 product = r * glm::transpose(r);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(product[i][j], i == j ? 1 : 0, 1e-14);
    }
    EXPECT_NEAR(glm::determinant(r), 1, 1e-14);
}

TEST(PrincipalRotation, IsProperAndOrdersVariances) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        Points points = cloud(some_rotation(seed), {0.2, 0.1, 0.01}, seed);
        const glm::dmat3 rotation = principal_rotation(points);
        expect_proper(rotation);
        for (glm::dvec3& p : points) p = rotation * p;
        const glm::dmat3 c = covariance(points);
        EXPECT_GT(c[0][0], c[1][1]);
        EXPECT_GT(c[1][1], c[2][2]);
        for (const double rest : {c[0][1], c[0][2], c[1][2]}) EXPECT_NEAR(rest, 0, 1e-14);
    }
}

TEST(PrincipalRotation, LargestAxisComponentIsPositive) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        const glm::dmat3 rotation = principal_rotation(cloud(some_rotation(seed), {0.2, 0.1, 0.01}, seed));
        for (int axis = 0; axis < 2; ++axis) {
            const glm::dvec3 direction = glm::transpose(rotation)[axis];
            const double least = std::min({direction.x, direction.y, direction.z});
            const double greatest = std::max({direction.x, direction.y, direction.z});
            EXPECT_GT(greatest, -least) << "seed " << seed;
        }
    }
}

TEST(PrincipalRotation, KeepsAlignedAxes) {
    const Points points{{2, 0, 0}, {-2, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 0.5}, {0, 0, -0.5}};
    EXPECT_EQ(principal_rotation(points), glm::dmat3(1.0));
}

TEST(PrincipalRotation, HandlesDegenerateClouds) {
    expect_proper(principal_rotation(Points{{1, 2, 3}}));
    expect_proper(principal_rotation(Points{{0, 0, 0}, {1, 2, 3}}));
    expect_proper(principal_rotation(Points{{0, 0, 0}, {1, 2, 3}, {3, 2, 1}}));
    expect_proper(principal_rotation(Points{{1e-160, 0, 0}, {0, 1e-160, 0}, {0, 0, 1e9}}));
}

}  // namespace
}  // namespace touchable
