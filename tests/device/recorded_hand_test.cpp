// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <span>
#include <vector>

#include "device/hand.hpp"
#include "device/hand_parts.hpp"
#include "engine/base/files.hpp"
#include "engine/base/words.hpp"
#include "tests/device/fake_driver.hpp"
#include "tests/device/hand_path.hpp"
#include "tests/limits.hpp"
#include "tests/real_data.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

using test::TemporaryFile;

std::string table_refusal(const std::string& text, const std::string& column = "") {
    const TemporaryFile file("table.csv", text);
    const Result<CsvTable> table = CsvTable::read(file.path());
    Error error;
    if (!table) {
        error = table.error();
    } else {
        const Result<std::size_t> at = table->column(column);
        if (!at) {
            error = at.error();
        } else {
            const Result<std::vector<double>> numbers = table->numbers(*at);
            if (numbers) return "accepted";
            error = numbers.error();
        }
    }
    EXPECT_EQ(error.kind, ErrorKind::input);
    EXPECT_TRUE(error.message.starts_with(file.path() + ": ")) << error.message;
    return error.message.substr(file.path().size() + 2);
}

TEST(CsvTable, ReadsNamedColumns) {
    const TemporaryFile file("table.csv", "t,\"x, m\",note\n0,1.5,a\n0.5, -2e-3 ,b\n1,+7,\"c,d\"\n");
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_EQ(table->rows(), 3u);
    EXPECT_EQ(table->columns(), 3u);
    EXPECT_TRUE(table->names("x, m"));
    EXPECT_FALSE(table->names("y"));
    EXPECT_EQ(*table->column("x, m"), 1u);
    EXPECT_EQ(*table->numbers(1), (std::vector<double>{1.5, -2e-3, 7}));
    EXPECT_FALSE(table->numbers(2));
}

TEST(CsvTable, NumbersColumnsWithoutHeader) {
    const TemporaryFile file("table.csv", "1,2\n3,4\n");
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_TRUE(table);
    EXPECT_EQ(table->rows(), 2u);
    EXPECT_EQ(*table->numbers(*table->column("2")), (std::vector<double>{2, 4}));
    EXPECT_FALSE(table->column("0"));
    EXPECT_FALSE(table->column("3"));
}

TEST(CsvTable, AcceptsLineEndsAndBom) {
    for (const std::string text :
         {"a,b\n1,2\n", "a,b\r\n1,2\r\n", "a,b\n1,2", "a,b\n1,2\n\n", "a,b\n1,2\n\n \r\n\t\n",
          "\xEF\xBB\xBF"
          "a,b\n1,2\n"}) {
        const TemporaryFile file("table.csv", text);
        const Result<CsvTable> table = CsvTable::read(file.path());
        ASSERT_TRUE(table) << text;
        EXPECT_EQ(table->rows(), 1u) << text;
        EXPECT_EQ(*table->column("a"), 0u) << text;
        EXPECT_EQ(*table->numbers(1), std::vector<double>{2}) << text;
    }
}

TEST(CsvTable, ReadsOtherSeparators) {
    for (const std::string text :
         {"t_s;x;note, such as this\n0;1;a,b\n0.5;-2;c\n", "t_s\tx\tnote\n0\t1\t\n0.5\t-2\tc d\n",
          "t_s x  note\n 0   1 a\n0.5\t-2 \"b c\" \n", "t_s, x, a;b\n0, 1, c;d\n0.5, -2, e\n"}) {
        const TemporaryFile file("table.csv", text);
        const Result<CsvTable> table = CsvTable::read(file.path());
        ASSERT_TRUE(table) << text << table.error().message;
        EXPECT_EQ(table->columns(), 3u) << text;
        EXPECT_EQ(*table->numbers(*table->column("t_s")), (std::vector<double>{0, 0.5})) << text;
        EXPECT_EQ(*table->numbers(*table->column("x")), (std::vector<double>{1, -2})) << text;
    }
    const TemporaryFile one("table.csv", "penetration depth\n0.1\n0.2\n");
    const Result<CsvTable> table = CsvTable::read(one.path());
    ASSERT_TRUE(table);
    EXPECT_EQ(*table->numbers(*table->column("penetration depth")), (std::vector<double>{0.1, 0.2}));
    EXPECT_EQ(table_refusal("t_s;x\n0;1,5\n", "x"),
              "line 2, column 'x' holds '1,5'; expected a finite number");
}

TEST(CsvTable, RejectsLargeFilesUnread) {
    const TemporaryFile file("table.csv", "t_s,x\n0,1\n");
    std::filesystem::resize_file(file.path(), std::uintmax_t{4} << 30);
    const test::LimitedMemory little(256);
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_FALSE(table);
    EXPECT_NE(table.error().message.find("is larger than 256 MiB"), std::string::npos);
}

TEST(CsvTable, LimitsRowCount) {
    std::string text;
    for (int n = 0; n < 10'000'002; ++n) text += "1\n";
    EXPECT_EQ(table_refusal(text, "1"),
              "has more than 10000000 rows; give a recorded motion of at most an hour");
}

TEST(CsvTable, KeepsErrorMessagesShort) {
    const std::string wide(3'000'000, 'x');
    EXPECT_LT(table_refusal("a,b\n1,2\n3," + wide + "\n", "b").size(), 200u);
    EXPECT_LT(table_refusal("a," + wide + "\n1,2\n", "c").size(), 600u);
    EXPECT_LT(table_refusal("a," + wide + "\n1,\n", wide).size(), 200u);
}

TEST(CsvTable, RefusalNamesLineAndColumn) {
    EXPECT_EQ(table_refusal("a,b\n1,2\n3,x\n", "b"),
              "line 3, column 'b' holds 'x'; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,\n", "b"), "line 2, column 'b' holds nothing; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,nan\n", "b"), "line 2, column 'b' holds 'nan'; expected a finite number");
    EXPECT_EQ(table_refusal("1\n-inf\n", "1"), "line 2, column '1' holds '-inf'; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,1e999\n", "b"),
              "line 2, column 'b' holds '1e999'; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,2\n", "c"), "has no column 'c'; columns are 1 to 2, a, b");
    EXPECT_EQ(table_refusal("a,b\n1,2\n3\n"), "line 3 has 1 fields; the lines before have 2");
    EXPECT_EQ(table_refusal("a,b\n1,2\n\n3,4\n"), "line 3 has 1 fields; the lines before have 2");
    EXPECT_EQ(table_refusal(""), "has no row of data; expected numbers");
    EXPECT_EQ(table_refusal("a,b\n"), "has no row of data; expected numbers");
    EXPECT_EQ(table_refusal("a,\"b\n1,2\n"), "line 1: a quote is opened and not closed");
    EXPECT_EQ(table_refusal("a,\"b\"c\n1,2\n"), "line 1: text follows a closing quote; expected a comma");
    EXPECT_EQ(table_refusal(std::string("a,b\n1,\0\n", 8)),
              "line 2 holds bytes that are no text; give a comma-separated table");
}

TEST(CsvTable, AllowsEmptyFieldsOnRequest) {
    const TemporaryFile file("table.csv", "a,b\n1,2\n,x\n3,4\n");
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_TRUE(table) << table.error().message;
    const Result<std::vector<double>> given = table->numbers(0, true);
    ASSERT_TRUE(given) << given.error().message;
    ASSERT_EQ(given->size(), 3u);
    EXPECT_EQ((*given)[0], 1);
    EXPECT_TRUE(std::isnan((*given)[1]));
    EXPECT_EQ((*given)[2], 3);
    EXPECT_FALSE(table->numbers(0));
    const Result<std::vector<double>> letter = table->numbers(1, true);
    ASSERT_FALSE(letter);
    EXPECT_TRUE(letter.error().message.ends_with("line 3, column 'b' holds 'x'; expected a finite number"));
}

TEST(CsvTable, RejectsUnreadablePaths) {
    EXPECT_FALSE(CsvTable::read(::testing::TempDir() + "there-is-no-such.csv"));
    EXPECT_FALSE(CsvTable::read(::testing::TempDir()));
}

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

TEST(RecordedMotion, ResamplesLinearDataExactly) {
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

TEST(RecordedMotion, KeepsRowsOnTicksExactly) {
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

TEST(RecordedMotion, RateReplacesTimes) {
    const TemporaryFile file("bare.csv", "0\n1\n2\n3\n4\n5\n");
    const auto motion = read_motion(file.path(), {.columns = {"1"}, .rate = 2000});
    ASSERT_TRUE(motion);
    ASSERT_EQ(motion->size(), 3u);
    EXPECT_EQ((*motion)[1].z, -2);
    EXPECT_EQ((*motion)[2].z, -4);
}

TEST(RecordedMotion, NegativeScaleReversesMotion) {
    const TemporaryFile file("line.csv", "t_s,x\n0,1\n0.001,2\n");
    EXPECT_EQ((*read_motion(file.path(), {.columns = {"x"}, .scale = -0.5}))[1].z, 1);
}

TEST(RecordedMotion, FlattensCentresAndScalesMotion) {
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

TEST(RecordedMotion, RefusalNamesLineAndRemedy) {
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

TEST(RecordedHand, HoldsLastPositionAfterEnd) {
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

TEST(RecordedHand, SingleColumnMovesAlongZ) {
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

TEST(RecordedHand, ContactMatchesRequestedShare) {
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

// Goals as `touch --forces` writes them: nothing is turned, scaled or shifted.
TEST(RecordedHand, KeepsSceneCoordinates) {
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

TEST(RecordedHand, RaisesDeepGoalsAlongRays) {
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

TEST(RecordedHand, MovesAboutCentreWithoutSurface) {
    const TemporaryFile file("press.csv", "t_s,x\n0,0\n0.1,0.01\n");
    const FakeProbe nothing = camera_view([](double, double) { return std::optional<double>(); });
    auto hand = make_hand("csv:" + file.path() + ":columns=x", 2, workspace, nothing);
    ASSERT_TRUE(hand);
    for (const glm::dvec3& goal : goals_of(**hand, nothing)) EXPECT_NEAR(goal.z, -800, 100);
}

TEST(RecordedHand, NeverPassesCamera) {
    const TemporaryFile file("long.csv", "t_s,x\n0,-9\n0.1,9\n");
    const FakeProbe probe = flat_view();
    auto hand = make_hand("csv:" + file.path() + ":columns=x,contact=0.01", 1, workspace, probe);
    ASSERT_TRUE(hand);
    for (const glm::dvec3& goal : goals_of(**hand, probe)) EXPECT_LT(goal.z, 0);
}

TEST(RecordedHand, AcceptsColonsInFileNames) {
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

TEST_P(RealRecording, TouchesSurfaceForSixtyPercent) {
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

TEST(RecordedMotion, ScalesWipingToExtent) {
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

TEST(ScriptedHand, SameDescriptionGivesSameBits) {
    for (const std::string& script : scripts) {
        EXPECT_EQ(run(script, broken_view(), 3), run(script, broken_view(), 3)) << script;
    }
}

TEST(ScriptedHand, SeedChangesPath) {
    for (const std::string script : {"wander", "poke"}) {
        EXPECT_NE(run(script + ":seed=1", flat_view()), run(script + ":seed=2", flat_view())) << script;
    }
}

TEST(ScriptedHand, EveryCompilerGivesSamePath) {
    EXPECT_EQ(hash_of(run("wander", broken_view(), 5)), 10178614045688231193u);
    EXPECT_EQ(hash_of(run("stroke:angle=30", broken_view(), 5)), 11716403843416955393u);
    EXPECT_EQ(hash_of(run("press", broken_view(), 5)), 12348998252595274956u);
    EXPECT_EQ(hash_of(run("poke", broken_view(), 5)), 4808618358777041697u);
}

TEST(ScriptedHand, KeepsSpeedOnFlatSurface) {
    for (const double wanted : {0.05, 0.1, 0.3}) {
        for (const std::string script : {"wander", "stroke:angle=65"}) {
            const std::string key = script == "wander" ? ":speed=" : ",speed=";
            const Path path = run(script + key + std::to_string(wanted), flat_view(650));
            std::size_t off = 0, turns = 0;  // a turn at the edge takes 51 ticks, at a corner two
            for (std::size_t tick = 300; tick < path.size(); ++tick) {
                const bool is_off = std::fabs(speed(path[tick - 1], path[tick]) - wanted) > 0.05 * wanted;
                turns += is_off && off == 0;
                off = is_off ? off + 1 : 0;
                EXPECT_LE(off, 104u) << script << " at " << wanted;
            }
            EXPECT_LE(turns, 20u) << script << " at " << wanted;
        }
    }
}

TEST(ScriptedHand, MeanPenetrationMatchesDepth) {
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

// From 50 mm above its goal.
TEST(ScriptedHand, DescendsInQuarterSecond) {
    const Path path = run("wander:depth=2", flat_view(), 1, 300);
    const double above = (800 + path[0].z) * workspace.metres_per_scene_unit;
    EXPECT_NEAR(above, 0.048, 1e-9);
    EXPECT_FALSE(is_under(path[200], flat_view()));
    EXPECT_TRUE(is_under(path[250], flat_view()));
}

TEST(ScriptedHand, GoalsStayWithinExtent) {
    for (const std::string script : {"wander:speed=1,max_speed=2,extent=0.5",
                                     "stroke:angle=80,speed=0.5,extent=0.5", "poke:speed=0.5,extent=0.5"}) {
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

TEST(ScriptedHand, WanderCoversMostOfPicture) {
    const FakeProbe probe = flat_view();
    std::vector<bool> visited(8 * 6);
    for (const glm::dvec3& goal : run("wander:speed=0.3,extent=1", probe, 1, 60000)) {
        const glm::dvec3 seen = probe.project({goal.x, goal.y, -800});
        visited[static_cast<std::size_t>(seen.y / 80) * 8 + static_cast<std::size_t>(seen.x / 80)] = true;
    }
    EXPECT_GE(std::count(visited.begin(), visited.end(), true), 40);
}

TEST(ScriptedHand, KeepsMaxSpeedAtCliff) {
    const FakeProbe cliff = camera_view([](double x, double) { return x < 320 ? 500.0 : 900.0; });
    for (const std::string script : {"wander:speed=0.3,max_speed=", "stroke:speed=0.3,max_speed=",
                                     "poke:speed=0.3,max_speed=", "press:max_speed="}) {
        for (const double most : {0.4, 1.0}) {
            EXPECT_LE(fastest(run(script + std::to_string(most), cliff, 5), 5), most * (1 + 1e-9)) << script;
        }
    }
    EXPECT_GT(fastest(run("stroke:speed=0.3,max_speed=10", cliff), 1), 1.0)
        << "the cliff is no trial of the cap";
}

TEST(ScriptedHand, KeepsRimDepthOverHole) {
    const FakeProbe slope_with_hole = camera_view([](double x, double) -> std::optional<double> {
        if (x > 380 && x < 460) return std::nullopt;
        return 700 + 0.25 * x;
    });
    const Path path = run("stroke:depth=0,speed=0.2", slope_with_hole, 1, 4000);
    const double clearance = 0.001 / workspace.metres_per_scene_unit;
    int over_hole = 0;
    for (const glm::dvec3& goal : std::span(path).subspan(250)) {  // it has come down
        const double x = slope_with_hole.project(goal).x;
        if (x < 405 || x > 435) continue;  // the mean of 10 mm
        ++over_hole;
        const double above = -goal.z + clearance;
        EXPECT_TRUE(std::fabs(above - (700 + 0.25 * 380)) < 0.5 ||
                    std::fabs(above - (700 + 0.25 * 460)) < 0.5)
            << above;
    }
    EXPECT_GT(over_hole, 50);
}

TEST(ScriptedHand, WanderMostlyTouchesDespiteHoles) {
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

TEST(ScriptedHand, WanderFindsMovedSurface) {
    const auto patch = [](double left) {
        return camera_view([left](double x, double) -> std::optional<double> {
            if (x < left || x > left + 80) return std::nullopt;
            return 800.0;
        });
    };
    const FakeProbe before = patch(280), after = patch(440);
    Result<std::unique_ptr<Hand>> hand = make_hand("wander:extent=1,speed=0.05", 1, workspace, before);
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

TEST(ScriptedHand, SurvivesViewWithoutSurface) {
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

TEST(ScriptedHand, NeverPassesCamera) {
    const FakeProbe near = camera_view([](double x, double) { return x < 320 ? 5.0 : 900.0; });
    for (const std::string& script : scripts) {
        for (const glm::dvec3& goal : run(script, near, 5)) ASSERT_LT(goal.z, 0) << script;
    }
}

TEST(ScriptedHand, CircleFingersHaveSeparatePhases) {
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

TEST(ScriptedHand, SingleFingerSitsAtCentre) {
    const glm::dvec3 goal = run("press:x=0.25,y=0.75,spread=0.1", flat_view(), 1, 251).back();
    const glm::dvec3 seen = flat_view().project({goal.x, goal.y, -800});
    EXPECT_NEAR(seen.x, 0.25 * 639, 1e-9);
    EXPECT_NEAR(seen.y, 0.75 * 479, 1e-9);
}

TEST(ScriptedHand, PressReachesLiftAndDepth) {
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

TEST(ScriptedHand, PokeNeverSlidesInside) {
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

TEST(ScriptedHand, PokeAimsAtSurfacePixels) {
    const FakeProbe probe = holed_view();
    int inside = 0, over_surface = 0;
    for (const glm::dvec3& goal : run("poke:depth=3,speed=0.5", probe, 1, 20000)) {
        if (-goal.z < 700) continue;
        const glm::dvec3 seen = probe.project(goal);
        ++inside;
        over_surface += probe.depth_under(seen.x, seen.y) ? 1 : 0;
    }
    EXPECT_GT(over_surface, 0.75 * inside);
}

TEST(ScriptedHand, StrokeFollowsLineAtAngle) {
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

constexpr std::array keys{
    KeyedValues::Key{"speed", "m/s", 0.001, 2, 0.1},
    KeyedValues::Key{"seed", "", 0, 0x1p53, 1, KeyedValues::Key::Kind::whole},
    KeyedValues::Key{.name = "columns", .unit = "names joined by '+'", .kind = KeyedValues::Key::Kind::words},
};

std::string hand_refusal(const std::string& text) {
    const Result<KeyedValues> options = KeyedValues::parse("hand 'test'", text, keys);
    if (options) return {};
    EXPECT_EQ(options.error().kind, ErrorKind::usage);
    return options.error().message;
}

TEST(KeyedValues, ReadsValuesOrDefaults) {
    const Result<KeyedValues> options = KeyedValues::parse("hand 'test'", "columns=a+b,seed=7", keys);
    ASSERT_TRUE(options);
    EXPECT_EQ(options->number("seed"), 7);
    EXPECT_EQ(options->number("speed"), 0.1);
    EXPECT_EQ(options->words("columns"), "a+b");
    EXPECT_TRUE(options->given("seed"));
    EXPECT_FALSE(options->given("speed"));
}

TEST(KeyedValues, RefusalNamesLegalKeys) {
    EXPECT_EQ(hand_refusal("sped=1"),
              "hand 'test': unknown key 'sped'; keys are speed (0.001 to 2 m/s), seed (a whole number, 0 to "
              "9007199254740992), columns (names joined by '+')");
    EXPECT_EQ(hand_refusal("speed=3"), "hand 'test': speed=3 is not allowed; speed takes 0.001 to 2 m/s");
}

TEST(KeyedValues, RejectsInvalidValues) {
    for (const std::string text :
         {"speed=", "speed=abc", "speed=0.1x", "speed=nan", "speed=inf", "speed=-1", "speed=0", "speed= 1",
          "seed=1.5", "seed=-1", "seed=1e300", "columns=", "speed", "=1", ",", "speed=1,", "speed=1,,seed=1",
          "speed=1,speed=1", "Speed=1"}) {
        EXPECT_FALSE(hand_refusal(text).empty()) << text;
    }
}

TEST(HandFactory, RejectsInvalidDescriptions) {
    const FakeProbe probe = flat_view();
    const Workspace workspace = default_workspace(640, 500, 800);
    const auto refusal = [&](const std::string& description, int fingers) {
        const auto hand = make_hand(description, fingers, workspace, probe);
        if (hand) return std::string("accepted");
        EXPECT_EQ(hand.error().kind, ErrorKind::usage) << description;
        EXPECT_EQ(hand.error().message.find('\n'), std::string::npos);
        return hand.error().message;
    };
    EXPECT_EQ(refusal("wave", 1),
              "unknown hand 'wave'; must be one of wander, stroke, press, poke, csv:FILE, rec:FILE");
    EXPECT_EQ(refusal("", 1),
              "unknown hand ''; must be one of wander, stroke, press, poke, csv:FILE, rec:FILE");
    EXPECT_EQ(refusal("wander", 0), "a hand has 1 to 256 fingers, not 0");
    EXPECT_EQ(refusal("wander:speed=1.5,max_speed=1", 1),
              "hand 'wander': max_speed=1 is below speed; give max_speed=1.5 or more");
    EXPECT_EQ(refusal("stroke:speed=0.6", 1),
              "hand 'stroke': max_speed=0.5 is below speed; give max_speed=0.6 or more");
    for (const std::string description :
         {"wander:angle=3", "stroke:seed=3", "press:speed=0.1", "press:extent=0.5", "poke:angle=3",
          "wander:depth=51", "press:x=1.01", "csv", "csv:", "csv::columns=a", "csv:f.csv:colums=a",
          "csv:f.csv", "csv:f.csv:columns=a+b", "csv:f.csv:columns=a,extent=0.05",
          "csv:f.csv:columns=a+b+c,extent=0.05,scale=2", "csv:f.csv:columns=a,rate=5,time=t",
          "csv:f.csv:columns=a,contact=1", "csv:f.csv:columns=a,scale=0"}) {
        EXPECT_NE(refusal(description, 1), "accepted") << description;
    }
}

}  // namespace
}  // namespace touchable
