#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "tests/device/hand_path.hpp"

namespace touchable {
namespace {

/// Device metres per second between two goals one tick apart.
double speed(const glm::dvec3& a, const glm::dvec3& b) {
    return glm::length(b - a) * workspace.metres_per_scene_unit * 1000;
}

double fastest(const Path& path, std::size_t fingers) {
    double most = 0;
    for (std::size_t at = fingers; at < path.size(); ++at)
        most = std::max(most, speed(path[at - fingers], path[at]));
    return most;
}

/// FNV-1a over the goals' bits.
std::uint64_t hash_of(const Path& path) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const glm::dvec3& goal : path) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto bits = std::bit_cast<std::uint64_t>(goal[axis] + 0.0);
            for (int byte = 0; byte < 8; ++byte)
                hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3u;
        }
    }
    return hash;
}

/// A hilly view with a round hole and a cliff, from + - * / and sqrt alone so that its hash is one
/// everywhere.
FakeProbe broken_view() {
    return camera_view([](double x, double y) -> std::optional<double> {
        const double dx = x - 400, dy = y - 200;
        if (dx * dx + dy * dy < 60 * 60) return std::nullopt;
        const double hill = 30 / (1 + (x - 250) * (x - 250) / 4000 + (y - 300) * (y - 300) / 6000);
        return (x < 200 ? 700.0 : 800.0) + 0.05 * y - hill;
    });
}

/// Some 43 % of the pixels have no surface: the top third, and islands in the rest.
FakeProbe holed_view() {
    return camera_view([](double x, double y) -> std::optional<double> {
        if (y < 160) return std::nullopt;
        const double across = std::fmod(x, 80.0) - 40, down = std::fmod(y, 80.0) - 40;
        if (across * across + down * down < 17 * 17) return std::nullopt;
        return 800 + 0.2 * (x - 320);
    });
}

const std::vector<std::string> scripts{"wander", "stroke", "stroke:angle=30", "press", "poke"};

TEST(ScriptedHand, SameDescriptionGivesTheSameBits) {
    for (const std::string& script : scripts) {
        EXPECT_EQ(run(script, broken_view(), 3), run(script, broken_view(), 3)) << script;
    }
}

TEST(ScriptedHand, AnotherSeedTakesAnotherPath) {
    for (const std::string script : {"wander", "poke"}) {
        EXPECT_NE(run(script + ":seed=1", flat_view()), run(script + ":seed=2", flat_view())) << script;
    }
}

TEST(ScriptedHand, PathIsTheSameOnEveryCompiler) {
    EXPECT_EQ(hash_of(run("wander", broken_view(), 5)), 8440626929759240434u);
    EXPECT_EQ(hash_of(run("stroke:angle=30", broken_view(), 5)), 4102860940078882624u);
    EXPECT_EQ(hash_of(run("press", broken_view(), 5)), 11301433043578395642u);
    EXPECT_EQ(hash_of(run("poke", broken_view(), 5)), 2180521275585820885u);
}

TEST(ScriptedHand, KeepsItsSpeedOnAFlatSurface) {
    for (const double wanted : {0.05, 0.1, 0.3}) {
        for (const std::string script : {"wander", "stroke:angle=65"}) {
            const std::string key = script == "wander" ? ":speed=" : ",speed=";
            const Path path = run(script + key + std::to_string(wanted), flat_view(650));
            std::size_t off = 0;  // a turn at the edge shortens one step
            for (std::size_t tick = 300; tick < path.size(); ++tick) {
                if (std::fabs(speed(path[tick - 1], path[tick]) - wanted) > 0.05 * wanted) ++off;
            }
            EXPECT_LE(off, 20u) << script << " at " << wanted;
        }
    }
}

TEST(ScriptedHand, PenetrationIsTheDepthAskedForOnAverage) {
    for (const std::string script : {"wander:depth=3.5", "stroke:depth=3.5"}) {
        const Path path = run(script, flat_view(), 1, 20250);
        double sum = 0, least = 1, most = 0;
        for (std::size_t tick = 250; tick < path.size(); ++tick) {
            const double under = (-path[tick].z - 800) * workspace.metres_per_scene_unit;
            sum += under;
            least = std::min(least, under);
            most = std::max(most, under);
        }
        EXPECT_NEAR(sum / 20000, 0.0035, 1e-6) << script;
        EXPECT_NEAR(least, 0.002, 1e-6) << script;
        EXPECT_NEAR(most, 0.005, 1e-6) << script;
    }
}

TEST(ScriptedHand, ComesDownFromFiftyMillimetresInAQuarterSecond) {
    const Path path = run("wander:depth=2", flat_view(), 1, 300);
    const double above = (800 + path[0].z) * workspace.metres_per_scene_unit;
    EXPECT_NEAR(above, 0.048, 1e-9);
    EXPECT_FALSE(is_under(path[200], flat_view()));
    EXPECT_TRUE(is_under(path[250], flat_view()));
}

TEST(ScriptedHand, NoGoalLeavesTheExtentOfThePicture) {
    for (const std::string script :
         {"wander:speed=1,extent=0.5", "stroke:angle=80,speed=1,extent=0.5", "poke:speed=1,extent=0.5"}) {
        const FakeProbe probe = flat_view();
        for (const glm::dvec3& goal : run(script, probe, 4)) {
            // Along -Z a goal leaves its pixel: look where it meets the surface's depth.
            const glm::dvec3 seen = probe.project({goal.x, goal.y, -800});
            EXPECT_GE(seen.x, 0.25 * 639 - 1e-9) << script;
            EXPECT_LE(seen.x, 0.75 * 639 + 1e-9) << script;
            EXPECT_GE(seen.y, 0.25 * 479 - 1e-9) << script;
            EXPECT_LE(seen.y, 0.75 * 479 + 1e-9) << script;
        }
    }
}

TEST(ScriptedHand, WanderReachesMostOfThePicture) {
    const FakeProbe probe = flat_view();
    std::vector<bool> visited(8 * 6);
    for (const glm::dvec3& goal : run("wander:speed=0.3,extent=1", probe, 1, 60000)) {
        const glm::dvec3 seen = probe.project({goal.x, goal.y, -800});
        visited[static_cast<std::size_t>(seen.y / 80) * 8 + static_cast<std::size_t>(seen.x / 80)] = true;
    }
    EXPECT_GE(std::count(visited.begin(), visited.end(), true), 40);
}

TEST(ScriptedHand, NoGoalOutrunsMaxSpeedAtACliff) {
    const FakeProbe cliff = camera_view([](double x, double) { return x < 320 ? 500.0 : 900.0; });
    for (const std::string script : {"wander:speed=0.3,max_speed=", "stroke:speed=0.3,max_speed=",
                                     "poke:speed=0.3,max_speed=", "press:max_speed="}) {
        for (const double most : {0.4, 1.0}) {
            EXPECT_LE(fastest(run(script + std::to_string(most), cliff, 5), 5), most * (1 + 1e-9)) << script;
        }
    }
    EXPECT_GT(fastest(run("stroke:speed=0.3,max_speed=10", cliff), 1), 2.0)
        << "the cliff is no trial of the cap";
}

TEST(ScriptedHand, HoversOverAHoleAtTheDepthItCameFrom) {
    const FakeProbe slope_with_hole = camera_view([](double x, double) -> std::optional<double> {
        if (x > 380 && x < 460) return std::nullopt;
        return 700 + 0.25 * x;
    });
    const Path path = run("stroke:depth=0,speed=0.2", slope_with_hole, 1, 1500);
    const double clearance = 0.001 / workspace.metres_per_scene_unit;
    int over_hole = 0;
    for (const glm::dvec3& goal : path) {
        const double x = slope_with_hole.project(goal).x;
        if (x < 385 || x > 455 || goal.z > -780) continue;  // not there, or still coming down
        ++over_hole;
        const double above = -goal.z + clearance;
        EXPECT_TRUE(std::fabs(above - (700 + 0.25 * 380)) < 0.5 ||
                    std::fabs(above - (700 + 0.25 * 460)) < 0.5)
            << above;
    }
    EXPECT_GT(over_hole, 50);
}

TEST(ScriptedHand, WanderIsUnderTheSurfaceMostOfTheTimeDespiteHoles) {
    const FakeProbe probe = holed_view();
    int holes = 0;
    for (int y = 0; y < 480; ++y) {
        for (int x = 0; x < 640; ++x) holes += probe.depth_under(x, y) ? 0 : 1;
    }
    ASSERT_GT(holes, 0.42 * 640 * 480);
    for (int seed = 1; seed <= 4; ++seed) {
        const std::string wander = "wander:seed=" + std::to_string(seed);
        EXPECT_GE(share_under(run(wander, probe, 1, 20000), probe), 0.6) << wander;
        EXPECT_GE(share_under(run(wander, probe, 5, 20000), probe), 0.5) << wander;
    }
}

TEST(ScriptedHand, WanderFindsASurfaceThatHasMovedAway) {
    const auto patch = [](double left) {
        return camera_view([left](double x, double) -> std::optional<double> {
            if (x < left || x > left + 80) return std::nullopt;
            return 800.0;
        });
    };
    const FakeProbe before = patch(280), after = patch(440);
    Result<std::unique_ptr<Hand>> hand = make_hand("wander:extent=1", 1, workspace, before);
    ASSERT_TRUE(hand);
    glm::dvec3 goal{};
    int under = 0;
    for (int tick = 0; tick < 40000; ++tick) {
        const FakeProbe& now = tick < 1000 ? before : after;
        (*hand)->goals_at(tick, now, {&goal, 1});
        if (tick >= 20000 && is_under(goal, now)) ++under;
    }
    EXPECT_GT(under, 10000);
}

TEST(ScriptedHand, SurvivesAViewWithoutAnySurface) {
    const FakeProbe nothing = camera_view([](double, double) { return std::optional<double>(); });
    for (const std::string& script : scripts) {
        for (const glm::dvec3& goal : run(script, nothing, 3, 1000)) {
            ASSERT_TRUE(std::isfinite(goal.x) && std::isfinite(goal.y) && goal.z < 0) << script;
            ASSERT_NEAR(goal.z, -800, 335) << script << ": the device's centre is at 800";
        }
    }
}

TEST(ScriptedHand, SurvivesTinyPictures) {
    for (const int size : {1, 2, 3}) {
        const FakeProbe probe(size, size, 500, [](double, double) { return 800.0; });
        for (const std::string& script : scripts) {
            for (const glm::dvec3& goal : run(script, probe, 2, 500)) {
                ASSERT_TRUE(std::isfinite(goal.x) && std::isfinite(goal.y) && goal.z < 0)
                    << script << " " << size;
            }
        }
    }
}

TEST(ScriptedHand, StaysInFrontOfTheCamera) {
    const FakeProbe near = camera_view([](double x, double) { return x < 320 ? 5.0 : 900.0; });
    for (const std::string& script : scripts) {
        for (const glm::dvec3& goal : run(script, near, 5)) ASSERT_LT(goal.z, 0) << script;
    }
}

TEST(ScriptedHand, FingersSitOnACircleEachInItsOwnPhase) {
    constexpr std::size_t fingers = 5, ticks = 1000;
    const Path path = run("press:spread=0.02", flat_view(), fingers, ticks);
    const glm::dvec3 centre = flat_view().unproject(319.5, 239.5, 800);
    for (std::size_t f = 0; f < fingers; ++f) {
        for (std::size_t tick = 250; tick < ticks; ++tick) {
            const glm::dvec2 away(path[tick * fingers + f] - centre);
            ASSERT_NEAR(glm::length(away) * workspace.metres_per_scene_unit, 0.02, 1e-6);
        }
        for (std::size_t g = 0; g < f; ++g) {
            double apart = 0;
            for (std::size_t at = 0; at < path.size(); at += fingers) {
                apart = std::max(apart, std::fabs(path[at + f].z - path[at + g].z));
            }
            EXPECT_GT(apart * workspace.metres_per_scene_unit, 0.002) << f << " and " << g;
        }
        const std::size_t down = 250 * fingers;
        const glm::dvec2 neighbour(path[down + f] - path[down + (f + 1) % fingers]);
        EXPECT_NEAR(glm::length(neighbour) * workspace.metres_per_scene_unit, 0.02 * 1.1755705, 1e-6);
    }
}

TEST(ScriptedHand, OneFingerSitsAtTheCentre) {
    const glm::dvec3 goal = run("press:x=0.25,y=0.75,spread=0.1", flat_view(), 1, 251).back();
    const glm::dvec3 seen = flat_view().project({goal.x, goal.y, -800});
    EXPECT_NEAR(seen.x, 0.25 * 639, 1e-9);
    EXPECT_NEAR(seen.y, 0.75 * 479, 1e-9);
}

TEST(ScriptedHand, PressSwingsFromLiftToDepth) {
    const Path path = run("press:depth=3,lift=1,period=0.5", flat_view(), 1, 1250);
    double deepest = -1, highest = -1;
    for (std::size_t tick = 250; tick < path.size(); ++tick) {
        const double under = (-path[tick].z - 800) * workspace.metres_per_scene_unit;
        deepest = std::max(deepest, under);
        highest = std::max(highest, -under);
        EXPECT_EQ(path[tick].x, path[250].x);
        EXPECT_EQ(path[tick].y, path[250].y);
    }
    EXPECT_NEAR(deepest, 0.003, 1e-6);
    EXPECT_NEAR(highest, 0.001, 1e-6);
}

TEST(ScriptedHand, PokeTravelsAboveAndPokesInPlace) {
    const FakeProbe probe = flat_view();
    const Path path = run("poke:depth=3,lift=2,period=0.2,speed=0.5", probe, 1, 20000);
    int pokes = 0;
    for (std::size_t tick = 251; tick < path.size(); ++tick) {
        const glm::dvec3 &before = path[tick - 1], &now = path[tick];
        if (!is_under(now, probe)) continue;
        EXPECT_EQ(glm::dvec2(before), glm::dvec2(now)) << "moved sideways while inside";
        if (!is_under(before, probe)) ++pokes;
    }
    EXPECT_GT(pokes, 30);
    EXPECT_LT(pokes, 100);
}

TEST(ScriptedHand, PokeAimsAtPixelsThatHaveASurface) {
    const FakeProbe probe = holed_view();
    int inside = 0, over_surface = 0;
    for (const glm::dvec3& goal : run("poke:depth=3,speed=1", probe, 1, 20000)) {
        if (-goal.z < 700) continue;
        const glm::dvec3 seen = probe.project(goal);
        ++inside;
        over_surface += probe.depth_under(seen.x, seen.y) ? 1 : 0;
    }
    EXPECT_GT(over_surface, 0.75 * inside);
}

TEST(ScriptedHand, StrokeIsAStraightLineThroughTheCentreAtItsAngle) {
    const FakeProbe probe = flat_view();
    const Path path = run("stroke:angle=30,speed=0.3", probe, 1, 3000);
    const glm::dvec3 centre = probe.unproject(319.5, 239.5, 800);
    double farthest = 0;
    for (std::size_t tick = 250; tick < path.size(); ++tick) {
        const glm::dvec2 away = glm::dvec2(path[tick] - centre);
        EXPECT_NEAR(away.y, away.x * 0.57735026918962576, 1e-6);
        farthest = std::max(farthest, glm::length(away));
    }
    EXPECT_GT(farthest * workspace.metres_per_scene_unit, 0.05);
}

TEST(ScriptedHand, HasNoEnd) {
    const FakeProbe probe = flat_view();
    EXPECT_EQ((*make_hand("wander", 1, workspace, probe))->ticks(), std::nullopt);
}

}  // namespace
}  // namespace touchable
