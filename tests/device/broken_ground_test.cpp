#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

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

/// How often a path goes from one side of pixel column x to the other.
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

TEST(BrokenGround, NoGoalIsDraggedIntoAWall) {
    for (const Ground& ground : grounds()) {
        for (const std::string hand : {"stroke", "stroke:speed=0.5", "stroke:speed=2,max_speed=2",
                                       "wander:speed=0.3", "poke:speed=0.5"}) {
            const double most = most_behind(run(hand, ground.probe), ground.probe);
            EXPECT_LE(most, 1000 * deepest + 0.3 + ground.step) << hand << " on a " << ground.name;
        }
    }
}

TEST(BrokenGround, StrokeGetsAcrossAndComesDownAgain) {
    for (const Ground& ground : grounds()) {
        const Path path = run("stroke:speed=0.2", ground.probe);
        EXPECT_GE(crossings(path, ground.probe, 320), 3) << ground.name;
        EXPECT_GE(share_behind(path, ground.probe), 0.5) << ground.name;
    }
}

TEST(BrokenGround, FingerRisesBeforeTheCliffAndWaitsThere) {
    const FakeProbe probe = cliff_view(800, 500);
    const Path path = run("stroke:max_speed=1", probe);
    int waited = 0;
    for (std::size_t at = down_at + 1; at < path.size(); ++at) {
        const glm::dvec3 seen = probe.project(path[at]);
        if (std::fabs(seen.x - 320) < 0.5) {
            EXPECT_LT(seen.z, 500) << "in the wall's column";
        }
        const double before = probe.project(path[at - 1]).x;
        if (seen.x < 320 && std::fabs(seen.x - before) < 0.05 && path[at].z > path[at - 1].z) ++waited;
    }
    EXPECT_GT(waited, 40) << "47 mm at 1 mm a tick";
}

TEST(BrokenGround, FingerHoversOverAHoleAboveItsRim) {
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

TEST(BrokenGround, FingerHopsOnceItHasClimbedAStep) {
    const FakeProbe probe = stairs_view();
    const Path path = run("stroke", probe, 1, 900);  // so far it only goes to the right, up the stairs
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

TEST(BrokenGround, SmoothSlopesAreFollowedWithoutLifting) {
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
                ASSERT_NEAR(behind(path[at], probe), 0, 1e-9) << hand << " at tick " << at;
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
        const auto rise = [&](std::size_t to) { return millimetres(path[to].z - path[to - fingers].z); };
        if (rise(at) < 0.9 || rise(at - fingers) < 0.9) continue;
        ++stopped;
        // Finger 2 is on the circle's other side, on even ground.
        if (behind(path[at + 2], probe) > 0) {
            EXPECT_EQ(path[at + 2].x, path[at + 2 - fingers].x);
        }
    }
    EXPECT_GT(stopped, 30);
}

TEST(BrokenGround, PressComesDownBesideACliff) {
    // It never moves sideways: what stands beside it is no obstacle.
    const FakeProbe probe = cliff_view(800, 500);
    EXPECT_GT(share_behind(run("press:x=0.4995", probe), probe), 0.4);
}

}  // namespace
}  // namespace touchable
