#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "device/hand_parts.hpp"
#include "tests/device/hand_path.hpp"
#include "tests/device/temporary_file.hpp"
#include "tests/real_data.hpp"

namespace touchable {
namespace {

const std::string recordings = test::real_data("haptics/");

FakeProbe slanted_view() {
    return camera_view([](double x, double y) { return 750 + 0.1 * x + 0.05 * y; });
}

std::vector<glm::dvec3> goals_of(Hand& hand, const SurfaceProbe& probe) {
    const auto fingers = static_cast<std::size_t>(hand.fingers());
    const auto ticks = static_cast<std::size_t>(*hand.ticks());
    std::vector<glm::dvec3> goals(fingers * ticks);
    for (std::size_t tick = 0; tick < ticks; ++tick) {
        hand.goals_at(static_cast<std::int64_t>(tick), probe,
                      std::span(goals).subspan(tick * fingers, fingers));
    }
    return goals;
}

TEST(RecordedMotion, LinearDataIsResampledExactly) {
    // Rows at odd times; x goes at 3 units a second.
    const TemporaryFile file(
        "line.csv", "t_s,x\n0,1\n0.0007,1.0021\n0.0031,1.0093\n0.0040,1.012\n0.0059,1.0177\n0.0100,1.03\n");
    const auto motion = read_motion(file.path(), {.columns = {"x"}, .scale = 0.5});
    ASSERT_TRUE(motion) << motion.error().message;
    ASSERT_EQ(motion->size(), 11u);
    for (std::size_t tick = 0; tick < motion->size(); ++tick) {
        const glm::dvec3& p = (*motion)[tick];
        EXPECT_EQ(p.x, 0);
        EXPECT_EQ(p.y, 0);
        EXPECT_NEAR(p.z, -0.5 * (1 + 0.003 * static_cast<double>(tick)), 1e-15)
            << "positive values go in, along -Z";
    }
}

TEST(RecordedMotion, RowsThatFallOnTicksAreKeptToTheBit) {
    std::string text = "t_s,x\n";
    for (int row = 0; row <= 40; ++row) {
        text += std::to_string(row * 0.0005) + "," + std::to_string((row * row * 7919) % 1000) + "\n";
    }
    const TemporaryFile file("rows.csv", text);
    const auto motion = read_motion(file.path(), {.columns = {"x"}, .scale = 0.001});
    ASSERT_TRUE(motion);
    ASSERT_EQ(motion->size(), 21u);
    for (int tick = 0; tick <= 20; ++tick) {
        const int row = 2 * tick;
        EXPECT_EQ((*motion)[static_cast<std::size_t>(tick)].z, ((row * row * 7919) % 1000) * -0.001);
    }
}

TEST(RecordedMotion, RateStandsInForTimes) {
    const TemporaryFile file("bare.csv", "0\n1\n2\n3\n4\n5\n");
    const auto motion = read_motion(file.path(), {.columns = {"1"}, .rate = 2000});
    ASSERT_TRUE(motion);
    ASSERT_EQ(motion->size(), 3u);
    EXPECT_EQ((*motion)[1].z, -2);
    EXPECT_EQ((*motion)[2].z, -4);
}

TEST(RecordedMotion, NegativeScaleTurnsTheMotionRound) {
    const TemporaryFile file("line.csv", "t_s,x\n0,1\n0.001,2\n");
    EXPECT_EQ((*read_motion(file.path(), {.columns = {"x"}, .scale = -0.5}))[1].z, 1);
}

TEST(RecordedMotion, SpatialMotionIsLaidFlatCentredAndScaled) {
    // An ellipse of 4 x 2 in the plane x + y + z = 5.
    std::string text = "t_s,x,y,z\n";
    const glm::dvec3 a = glm::normalize(glm::dvec3(1, -1, 0)), n = glm::normalize(glm::dvec3(1, 1, 1));
    const glm::dvec3 b = glm::cross(n, a);
    for (int row = 0; row <= 100; ++row) {
        const double angle = 2 * 3.14159265358979 * row / 100;
        const glm::dvec3 p = 2 * std::cos(angle) * a + std::sin(angle) * b + glm::dvec3(5.0 / 3);
        text += std::to_string(row * 0.01) + "," + std::to_string(p.x) + "," + std::to_string(p.y) + "," +
                std::to_string(p.z) + "\n";
    }
    const TemporaryFile file("ellipse.csv", text);
    const auto motion = read_motion(file.path(), {.columns = {"x", "y", "z"}, .extent = 0.04});
    ASSERT_TRUE(motion) << motion.error().message;
    EXPECT_EQ(motion->size(), 1001u);
    glm::dvec3 least(1), greatest(-1);
    for (const glm::dvec3& p : *motion) {
        least = glm::min(least, p);
        greatest = glm::max(greatest, p);
    }
    EXPECT_NEAR(least.x, -0.02, 1e-9);
    EXPECT_NEAR(greatest.x, 0.02, 1e-9);
    EXPECT_NEAR(least.y, -0.01, 1e-5);
    EXPECT_NEAR(greatest.y, 0.01, 1e-5);
    EXPECT_NEAR(least.z, 0, 1e-7);
    EXPECT_NEAR(greatest.z, 0, 1e-7);
}

std::string refusal_of(const std::string& text, const MotionSettings& settings) {
    const TemporaryFile file("bad.csv", text);
    const auto motion = read_motion(file.path(), settings);
    if (motion) return "accepted";
    EXPECT_EQ(motion.error().kind, ErrorKind::input);
    EXPECT_TRUE(motion.error().message.starts_with(file.path() + ": ")) << motion.error().message;
    return motion.error().message.substr(file.path().size() + 2);
}

TEST(RecordedMotion, RefusalsNameTheLineAndWhatWouldBeRight) {
    const MotionSettings x{.columns = {"x"}};
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n0,2\n", x),
              "line 3: time does not increase; expected seconds that grow from row to row");
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n1,2\n0.5,2\n", x),
              "line 4: time does not increase; expected seconds that grow from row to row");
    EXPECT_EQ(refusal_of("t,x\n0,1\n1,2\n", x),
              "has no column 't_s'; name the column of seconds by time=NAME, or give rate=HZ");
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n", x), "has one row of data; a motion needs at least two");
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n1,nan\n", x),
              "line 3, column 'x' holds 'nan'; expected a finite number");
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n1,2e9\n", x), "line 3, column 'x': is beyond 1e9; expected a motion");
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n1,11\n", x),
              "moves more than 10 m; give scale= as metres per unit of the columns");
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n4000,2\n", x), "lasts more than an hour; are its times in seconds?");
    EXPECT_EQ(refusal_of("t_s,x\n-1e308,1\n1e308,2\n", x),
              "lasts more than an hour; are its times in seconds?");
    EXPECT_EQ(refusal_of("t_s,x\n0,1\n1,1\n", {.columns = {"x", "x", "x"}, .extent = 0.05}),
              "does not move, so that extent= has nothing to scale; give scale= instead");
}

TEST(RecordedHand, HoldsItsLastPositionAfterItsEnd) {
    const TemporaryFile file("short.csv", "t_s,x\n0,0\n0.005,0.01\n");
    const FakeProbe probe = flat_view();
    auto hand = make_hand("csv:" + file.path() + ":columns=x", 1, workspace, probe);
    ASSERT_TRUE(hand) << hand.error().message;
    ASSERT_EQ((*hand)->ticks(), 6);
    glm::dvec3 last{}, later{};
    (*hand)->goals_at(5, probe, {&last, 1});
    (*hand)->goals_at(500000, probe, {&later, 1});
    EXPECT_EQ(last, later);
}

TEST(RecordedHand, OneColumnMovesAlongZAtThePicturesCentre) {
    const TemporaryFile file("press.csv", "t_s,x\n0,0\n0.1,0.01\n");
    const FakeProbe probe = flat_view();
    auto hand = make_hand("csv:" + file.path() + ":columns=x,contact=0.25", 1, workspace, probe);
    ASSERT_TRUE(hand);
    const std::vector<glm::dvec3> goals = goals_of(**hand, probe);
    const glm::dvec3 centre = probe.unproject(319.5, 239.5, 800);
    for (const glm::dvec3& goal : goals) EXPECT_EQ(glm::dvec2(goal), glm::dvec2(centre));
    EXPECT_NEAR((goals.front().z - goals.back().z) * workspace.metres_per_scene_unit, 0.01, 1e-12);
    EXPECT_LT(goals.back().z, goals.front().z);
    EXPECT_NEAR(share_under(goals, probe), 0.25, 0.01);
}

TEST(RecordedHand, ContactIsTheShareAskedFor) {
    std::string text = "t_s,x,y,z\n";
    for (int row = 0; row <= 400; ++row) {
        const double t = row * 0.01;
        text += std::to_string(t) + "," + std::to_string(0.05 * std::cos(3 * t)) + "," +
                std::to_string(0.03 * std::sin(4 * t)) + "," + std::to_string(0.01 * std::sin(7 * t)) + "\n";
    }
    const TemporaryFile file("curve.csv", text);
    for (const double contact : {0.05, 0.3, 0.6, 0.95}) {
        for (const int fingers : {1, 5}) {
            const FakeProbe probe = slanted_view();
            auto hand = make_hand("csv:" + file.path() + ":columns=x+y+z,contact=" + std::to_string(contact),
                                  fingers, workspace, probe);
            ASSERT_TRUE(hand) << hand.error().message;
            EXPECT_NEAR(share_under(goals_of(**hand, probe), probe), contact, 0.01);
        }
    }
}

// As `touch --forces` writes goals: nothing is turned, scaled or shifted.
TEST(RecordedHand, AMotionInSceneCoordinatesIsTakenAsItIs) {
    const TemporaryFile file("goals.csv", "t_s,x,y,z\n0,12,-7,-700\n0.002,14,-7,-900\n");
    const FakeProbe probe = flat_view();
    auto hand = make_hand("csv:" + file.path() + ":columns=x+y+z,space=scene", 1, workspace, probe);
    ASSERT_TRUE(hand) << hand.error().message;
    EXPECT_EQ(goals_of(**hand, probe),
              (std::vector<glm::dvec3>{{12, -7, -700}, {13, -7, -800}, {14, -7, -900}}));
    for (const char* wrong : {"columns=z,space=scene", "columns=x+y+z,space=scene,scale=2",
                              "columns=x+y+z,space=scene,contact=0.5", "columns=x+y+z,space=moon"}) {
        const auto refused = make_hand("csv:" + file.path() + ":" + wrong, 1, workspace, probe);
        ASSERT_FALSE(refused) << wrong;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
}

TEST(RecordedHand, GoalsDeeperThanTheirLimitAreRaisedAlongTheirRays) {
    const TemporaryFile file("goals.csv", "t_s,x,y,z\n0,12,-7,-700\n0.001,12,-7,-900\n0.002,9000,-7,-900\n");
    const FakeProbe probe = flat_view(800);
    const std::string words = "csv:" + file.path() + ":columns=x+y+z,space=scene";
    auto limited = make_hand(words + ",depth=4", 1, workspace, probe),
         free = make_hand(words, 1, workspace, probe);
    ASSERT_TRUE(limited) << limited.error().message;
    ASSERT_TRUE(free);
    const auto raised = goals_of(**limited, probe), as_they_are = goals_of(**free, probe);
    EXPECT_EQ(raised[0], as_they_are[0]) << "in front of the surface";
    EXPECT_EQ(raised[2], as_they_are[2]) << "outside the picture";
    const double units = 0.004 / workspace.metres_per_scene_unit;
    EXPECT_NEAR(-raised[1].z, 800 + units, 1e-9);
    EXPECT_NEAR(raised[1].x / raised[1].z, as_they_are[1].x / as_they_are[1].z, 1e-12);
    const auto said = (*free)->remarks();
    ASSERT_EQ(said.size(), 2U);
    EXPECT_TRUE(said[0].starts_with("33.3 % of the goals lie outside the picture")) << said[0];
    EXPECT_TRUE(said[1].starts_with("33.3 % of the goals lie more than 10 mm below")) << said[1];
    EXPECT_NE((*limited)->remarks()[1].find("were raised"), std::string::npos);
}

TEST(RecordedHand, FingersKeepTheirCircle) {
    const TemporaryFile file("press.csv", "t_s,x\n0,0\n0.1,0.01\n");
    const FakeProbe probe = slanted_view();
    auto hand = make_hand("csv:" + file.path() + ":columns=x,spread=0.03", 4, workspace, probe);
    ASSERT_TRUE(hand);
    const std::vector<glm::dvec3> goals = goals_of(**hand, probe);
    for (std::size_t tick = 0; tick < 100; tick += 10) {
        const glm::dvec3 across = (goals[4 * tick] - goals[4 * tick + 2]) * workspace.metres_per_scene_unit;
        const glm::dvec3 up = (goals[4 * tick + 1] - goals[4 * tick + 3]) * workspace.metres_per_scene_unit;
        EXPECT_NEAR(glm::length(across - glm::dvec3(0.06, 0, 0)), 0, 1e-12);
        EXPECT_NEAR(glm::length(up - glm::dvec3(0, 0.06, 0)), 0, 1e-12);
    }
}

TEST(RecordedHand, WithoutAnySurfaceItMovesAboutTheDevicesCentre) {
    const TemporaryFile file("press.csv", "t_s,x\n0,0\n0.1,0.01\n");
    const FakeProbe nothing = camera_view([](double, double) { return std::optional<double>(); });
    auto hand = make_hand("csv:" + file.path() + ":columns=x", 2, workspace, nothing);
    ASSERT_TRUE(hand);
    for (const glm::dvec3& goal : goals_of(**hand, nothing)) EXPECT_NEAR(goal.z, -800, 100);
}

TEST(RecordedHand, StaysInFrontOfTheCamera) {
    const TemporaryFile file("long.csv", "t_s,x\n0,-9\n0.1,9\n");
    const FakeProbe probe = flat_view();
    auto hand = make_hand("csv:" + file.path() + ":columns=x,contact=0.01", 1, workspace, probe);
    ASSERT_TRUE(hand);
    for (const glm::dvec3& goal : goals_of(**hand, probe)) EXPECT_LT(goal.z, 0);
}

TEST(RecordedHand, FileNamesMayHoldColons) {
    const TemporaryFile file("a:b:c.csv", "t_s,x\n0,0\n0.1,0.01\n");
    const FakeProbe probe = flat_view();
    EXPECT_TRUE(make_hand("csv:" + file.path() + ":columns=x", 1, workspace, probe));
    const auto missing = make_hand("csv:no:such.csv:columns=x", 1, workspace, probe);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().kind, ErrorKind::input);
    EXPECT_TRUE(missing.error().message.starts_with("no:such.csv: ")) << missing.error().message;
}

class RealRecording : public ::testing::TestWithParam<std::string> {
protected:
    void SetUp() override { TOUCHABLE_NEEDS_DATA(recordings); }
};

TEST_P(RealRecording, LiesUnderTheFirstFrameForSixTenthsOfItsGoals) {
    for (const FakeProbe& probe : {flat_view(), slanted_view()}) {
        for (const int fingers : {1, 5}) {
            auto hand = make_hand("csv:" + recordings + GetParam(), fingers, workspace, probe);
            ASSERT_TRUE(hand) << hand.error().message;
            const std::vector<glm::dvec3> goals = goals_of(**hand, probe);
            EXPECT_GT(*(*hand)->ticks(), 4000);
            EXPECT_NEAR(share_under(goals, probe), 0.6, 0.02) << fingers << " fingers";
            double fastest = 0;
            const auto step = static_cast<std::size_t>(fingers);
            for (std::size_t at = step; at < goals.size(); ++at) {
                fastest = std::max(fastest, glm::length(goals[at] - goals[at - step]));
            }
            EXPECT_LT(fastest * workspace.metres_per_scene_unit, 0.002) << "device metres in a tick";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    TueOneDof, RealRecording,
    ::testing::Values("tue_1dof/m2_question1a_foam3.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/m2_question1a_free_motion.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/m2_question1a_rigid.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/m2_question1a_spring.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/m2_question1e_foam2.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/m2_question1e_free_motion.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/m2_question1e_rigid.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/m2_question1e_spring.csv:columns=master_rad,scale=0.075",
                      "tue_1dof/handRef_2kHz_rad.csv:columns=1,rate=2000,scale=0.075"));

INSTANTIATE_TEST_SUITE_P(
    EpflWiping, RealRecording,
    ::testing::Values("epfl_wiping/circular_wiping_dataset_0.csv:columns=x_m+y_m+z_m,extent=0.048",
                      "epfl_wiping/circular_wiping_dataset_1.csv:columns=x_m+y_m+z_m,extent=0.048",
                      "epfl_wiping/circular_wiping_dataset_2.csv:columns=x_m+y_m+z_m,extent=0.048",
                      "epfl_wiping/circular_wiping_dataset_3.csv:columns=x_m+y_m+z_m,extent=0.048"));

TEST(RecordedMotion, WipingLiesFlatAndFortyEightMillimetresWide) {
    const std::string file = recordings + "epfl_wiping/circular_wiping_dataset_0.csv";
    TOUCHABLE_NEEDS_DATA(file);
    const auto motion = read_motion(file, {.columns = {"x_m", "y_m", "z_m"}, .extent = 0.048});
    ASSERT_TRUE(motion) << motion.error().message;
    EXPECT_EQ(motion->size(), 12595u);
    glm::dvec3 least(1), greatest(-1), mean(0), variance(0);
    for (const glm::dvec3& p : *motion) {
        least = glm::min(least, p);
        greatest = glm::max(greatest, p);
        mean += p / static_cast<double>(motion->size());
    }
    for (const glm::dvec3& p : *motion) variance += (p - mean) * (p - mean);
    EXPECT_NEAR(std::max(greatest.x - least.x, greatest.y - least.y), 0.048, 1e-12);
    EXPECT_GT(variance.x, variance.y);
    EXPECT_GT(variance.y, variance.z);
}

}  // namespace
}  // namespace touchable
