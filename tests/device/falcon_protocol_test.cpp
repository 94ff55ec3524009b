// SPDX-License-Identifier: Apache-2.0
// Packets of the Novint Falcon, against letters written by hand from its owners' description.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "device/drivers/falcon_device.hpp"

namespace touchable::test {
namespace {

std::string sent(const FalconCommand& command) {
    std::string text;
    for (const std::byte byte : encode(command)) text += static_cast<char>(byte);
    return text;
}

std::optional<FalconReport> read(FalconReader& reader, const std::string& text) {
    std::optional<FalconReport> last;
    for (const char byte : text)
        if (const auto report = reader.take(static_cast<std::byte>(byte))) last = report;
    return last;
}

std::string with_state(const std::string& counts, int state) {
    return "<" + counts + static_cast<char>('A' + state) + "A>";
}

TEST(FalconProtocol, EncodesWordsLowestLetterFirst) {
    // B: the homing bit alone.
    EXPECT_EQ(sent({}), "<AAAAAAAAAAAABA>");
    EXPECT_EQ(sent({{1, 256, -1}, FalconLamp::none}), "<BAAAAABAPPPPBA>");
    EXPECT_EQ(sent({{0x7FFF, -32768, -1447}, FalconLamp::none}), "<PPPHAAAIJFKPBA>");
    EXPECT_EQ(sent({{4096, -4096, 0}, FalconLamp::green}), "<AAABAAAPAAAADA>");
    EXPECT_EQ(sent({{}, FalconLamp::blue}), "<AAAAAAAAAAAAFA>");
    EXPECT_EQ(sent({{}, FalconLamp::red}), "<AAAAAAAAAAAAJA>");
}

// JFKP, 0xFA59, is the example of the public description.
TEST(FalconProtocol, DecodesSignedCounts) {
    FalconReader reader;
    const auto report = read(reader, "<JFKPAAAIPPPHAA>");
    ASSERT_TRUE(report);
    EXPECT_EQ(report->counts, (std::array<std::int16_t, 3>{-1447, -32768, 32767}));
    EXPECT_EQ(report->buttons, 0);
    EXPECT_FALSE(report->homed);
    EXPECT_EQ(reader.damaged(), 0);
}

TEST(FalconProtocol, DecodesHomingAndButtons) {
    for (int state = 0; state < 128; ++state) {
        FalconReader reader;
        const auto report = read(reader, with_state("AAAAAAAAAAAA", state));
        ASSERT_TRUE(report) << state;
        EXPECT_EQ(report->buttons, state % 16);
        EXPECT_EQ(report->homed, state / 16 == 7);
    }
}

// libnifalcon's users saw a packet of 14 bytes as homed and with buttons pressed.
TEST(FalconProtocol, SkipsShortPacket) {
    FalconReader reader;
    EXPECT_FALSE(read(reader, "<AAAAAAAAAAAA>"));
    EXPECT_FALSE(read(reader, "<BAAA"));
    const auto report = read(reader, "<CAAAAAAAAAAAAA>");
    ASSERT_TRUE(report);
    EXPECT_EQ(report->counts[0], 2);
    EXPECT_EQ(reader.damaged(), 2);
}

TEST(FalconProtocol, RejectsPacketWithInvalidByte) {
    for (std::size_t place = 0; place < 16; ++place)
        for (int wrong = 0; wrong < 256; ++wrong) {
            std::string packet = "<DAAAEAAAFAAAAA>";
            packet[place] = static_cast<char>(wrong);
            const bool letter = wrong >= 'A' && wrong <= 'P';
            const bool may = place == 0    ? wrong == '<'
                             : place == 15 ? wrong == '>'
                             : place == 13 ? wrong >= 'A' && wrong <= 'A' + 127
                             : place == 14 ? wrong >= 'A'
                                           : letter;
            FalconReader reader;
            EXPECT_EQ(read(reader, packet).has_value(), may) << place << " " << wrong;
            const auto next = read(reader, "<GAAAAAAAAAAAAA>");
            ASSERT_TRUE(next) << place << " " << wrong;
            EXPECT_EQ(next->counts[0], 6);
        }
}

TEST(FalconProtocol, FindsReportsInNoise) {
    std::mt19937 random(4);
    FalconReader reader;
    for (int go = 0; go < 2000; ++go) {
        std::string noise;
        for (unsigned left = random() % 40; left > 0; --left) noise += static_cast<char>(random() % 256);
        read(reader, noise);
        const auto report = read(reader, "<HAAAAAAAAAAAAA>");
        ASSERT_TRUE(report) << go;
        EXPECT_EQ(report->counts[0], 7);
    }
}

TEST(Ftdi, EncodesChipCommands) {
    using std::chrono::milliseconds;
    EXPECT_EQ(FtdiCommand::latency(milliseconds(16)), (FtdiCommand{9, 16}));
    EXPECT_EQ(FtdiCommand::divisor(0x4138), (FtdiCommand{3, 0x4138}));
    EXPECT_EQ(FtdiCommand::eight_bits(), (FtdiCommand{4, 8}));
    EXPECT_EQ(FtdiCommand::no_flow_control(), (FtdiCommand{2, 0}));
    EXPECT_EQ(FtdiCommand::dtr(true), (FtdiCommand{1, 0x0101}));
    EXPECT_EQ(FtdiCommand::dtr(false), (FtdiCommand{1, 0x0100}));
    EXPECT_EQ(FtdiCommand::rts(true), (FtdiCommand{1, 0x0202}));
    EXPECT_EQ(FtdiCommand::rts(false), (FtdiCommand{1, 0x0200}));
    EXPECT_EQ(FtdiCommand::purge_received(), (FtdiCommand{0, 1}));
    EXPECT_EQ(FtdiCommand::purge_to_send(), (FtdiCommand{0, 2}));
}

// Geometry of the Falcon, against its published closed form and against what the mechanism itself says.

constexpr double degrees = 3.14159265358979323846 / 180;

/// Every 5 mm of the ball that is reached.
std::vector<glm::dvec3> reached_places() {
    std::vector<glm::dvec3> places;
    for (int x = -10; x <= 10; ++x)
        for (int y = -10; y <= 10; ++y)
            for (int z = -10; z <= 10; ++z)
                if (x * x + y * y + z * z <= 100) places.emplace_back(0.005 * x, 0.005 * y, 0.005 * z);
    return places;
}

glm::dvec3 anywhere(std::mt19937& random, double radius) {
    std::uniform_real_distribution<double> side(-radius, radius);
    glm::dvec3 place;
    do place = {side(random), side(random), side(random)};
    while (glm::length(place) > radius);
    return place;
}

// Angles by the published solution, with the tangent of the half angle, in another program.
TEST(FalconKinematics, AnglesMatchPublishedSolution) {
    const auto expect = [](const glm::dvec3& place, double top, double right, double left) {
        const auto angles = falcon_angles(place);
        ASSERT_TRUE(angles);
        EXPECT_NEAR((*angles)[0], top, 1e-11);
        EXPECT_NEAR((*angles)[1], right, 1e-11);
        EXPECT_NEAR((*angles)[2], left, 1e-11);
    };
    expect({0, 0, 0}, 0.483618370935, 0.483618370935, 0.483618370935);
    expect({0.01, -0.02, 0.03}, 1.123345767287, 0.806807825667, 0.870896607237);
    expect({-0.03, 0.025, -0.02}, -0.095311333216, 0.732290209305, 0.326081832236);
    expect({0.02, 0.01, -0.035}, -0.023809424562, -0.244439855973, 0.338930138356);
}

TEST(FalconKinematics, InvertsEveryReachablePosition) {
    double worst_anew = 0, worst_going_on = 0;
    glm::dvec3 last(0.0);
    for (const glm::dvec3& place : reached_places()) {
        const auto angles = falcon_angles(place);
        ASSERT_TRUE(angles);
        const auto anew = falcon_pose(*angles), going_on = falcon_pose(*angles, last);
        ASSERT_TRUE(anew && going_on) << place.x << " " << place.y << " " << place.z;
        worst_anew = std::max(worst_anew, glm::length(anew->place - place));
        worst_going_on = std::max(worst_going_on, glm::length(going_on->place - place));
        last = going_on->place;
    }
    EXPECT_LT(worst_anew, 1e-9);
    EXPECT_LT(worst_going_on, 1e-9);
}

TEST(FalconKinematics, ConvergesFromAnyStart) {
    std::mt19937 random(11);
    for (int go = 0; go < 3000; ++go) {
        const glm::dvec3 place = anywhere(random, falcon_reach), start = anywhere(random, falcon_reach);
        const auto pose = falcon_pose(*falcon_angles(place), start);
        ASSERT_TRUE(pose) << go;
        EXPECT_LT(glm::length(pose->place - place), 1e-9) << go;
    }
}

// 35 degrees, and 360 / 1280 * 14.25 / 110 for each count.
TEST(FalconKinematics, ConvertsCountsToAngles) {
    EXPECT_NEAR(falcon_angle(0), 35 * degrees, 1e-15);
    EXPECT_NEAR(falcon_angle(1000), 71.43465909090909 * degrees, 1e-12);
    EXPECT_NEAR(falcon_angle(-2000), -37.86931818181818 * degrees, 1e-12);
}

TEST(FalconKinematics, ResolvesHundredthsOfMillimetre) {
    const auto angles = falcon_angles(glm::dvec3(0.0));
    auto next = *angles;
    next[0] += falcon_angle(1) - falcon_angle(0);
    const double step = glm::length(falcon_pose(next)->place);
    EXPECT_GT(step, 1e-5);
    EXPECT_LT(step, 1e-4);
}

TEST(FalconKinematics, RejectsUnreachableAngles) {
    EXPECT_FALSE(falcon_pose({90 * degrees, -80 * degrees, 10 * degrees}));
    EXPECT_FALSE(falcon_pose({falcon_angle(32767), falcon_angle(32767), falcon_angle(32767)}));
    EXPECT_FALSE(falcon_pose({falcon_angle(-32768), falcon_angle(0), falcon_angle(0)}));
    const double none = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(falcon_pose({none, 0.5, 0.5}));
    EXPECT_FALSE(falcon_pose({0.5, 0.5, 0.5}, glm::dvec3(none)));
    EXPECT_FALSE(falcon_angles({0, 0, 0.2}));
    EXPECT_FALSE(falcon_angles({0.3, 0, 0}));
    EXPECT_FALSE(falcon_angles(glm::dvec3(none)));
}

TEST(FalconKinematics, PositionAlwaysFitsItsCounts) {
    std::mt19937 random(12);
    int refused = 0, found = 0;
    for (int go = 0; go < 20000; ++go) {
        const int range = go % 2 == 0 ? 32767 : 2500;
        FalconAngles angles;
        for (double& angle : angles)
            angle = falcon_angle(static_cast<std::int16_t>(static_cast<int>(random() % (2 * range)) - range));
        const auto pose = falcon_pose(angles);
        if (!pose) {
            ++refused;
            continue;
        }
        ++found;
        ASSERT_LE(glm::length(pose->place), falcon_edge);
        const auto own = falcon_angles(pose->place);
        ASSERT_TRUE(own);
        for (std::size_t arm = 0; arm < 3; ++arm) EXPECT_NEAR((*own)[arm], angles[arm], 1e-6);
    }
    EXPECT_GT(refused, 10000);
    EXPECT_GT(found, 100);
}

TEST(FalconKinematics, JacobianMatchesFiniteDifferences) {
    std::mt19937 random(13);
    for (int go = 0; go < 300; ++go) {
        const auto angles = *falcon_angles(anywhere(random, falcon_reach));
        const auto pose = falcon_pose(angles);
        for (std::size_t arm = 0; arm < 3; ++arm) {
            constexpr double h = 1e-5;
            auto more = angles, less = angles;
            more[arm] += h;
            less[arm] -= h;
            const glm::dvec3 slope =
                (falcon_pose(more, pose->place)->place - falcon_pose(less, pose->place)->place) / (2 * h);
            EXPECT_LT(glm::length(slope - pose->metres_per_radian[static_cast<glm::length_t>(arm)]), 1e-6);
        }
    }
}

// Worked out in another program.
TEST(FalconForce, MatchesPublicDriverAtCentre) {
    const auto pose = falcon_pose(*falcon_angles(glm::dvec3(0.0)));
    const auto pulled = falcon_motor_words(*pose, {0, 0, 8});
    EXPECT_EQ(pulled, (std::array<std::int16_t, 3>{-2019, -2019, -2019}));
    const auto up = falcon_motor_words(*pose, {0, 4, 0});
    EXPECT_EQ(up, (std::array<std::int16_t, 3>{2386, -573, -1813}));
}

// The public driver sends 47716 here, which its packet makes -17820: a force the other way round.
TEST(FalconForce, LargeForceNeverReverses) {
    for (const double x : {-80.0, 80.0}) {
        const auto pose = falcon_pose(*falcon_angles({0, 0, -0.003}));
        const auto much = falcon_motor_words(*pose, {x, 0, 0}),
                   little = falcon_motor_words(*pose, {x / 80, 0, 0});
        for (std::size_t arm = 0; arm < 3; ++arm) {
            EXPECT_GT(much[arm] * little[arm], 0);
            EXPECT_LE(std::abs(much[arm]), 4096);
        }
    }
}

TEST(FalconForce, SaturationKeepsDirection) {
    std::mt19937 random(14);
    for (int go = 0; go < 3000; ++go) {
        const auto pose = falcon_pose(*falcon_angles(anywhere(random, falcon_reach)));
        const glm::dvec3 direction = glm::normalize(anywhere(random, 1) + glm::dvec3(1e-9));
        for (const double newtons : {5.0, 80.0, 1e6}) {
            const auto words = falcon_motor_words(*pose, newtons * direction);
            const glm::dvec3 torques(words[0], words[1], words[2]);
            const glm::dvec3 felt = -glm::inverse(glm::transpose(pose->metres_per_radian)) * torques;
            EXPECT_LE(std::max({std::abs(words[0]), std::abs(words[1]), std::abs(words[2])}), 4096);
            EXPECT_GT(glm::dot(glm::normalize(felt), direction), 0.99999) << go;
        }
    }
}

TEST(FalconForce, NonFiniteForceIsZero) {
    const auto pose = falcon_pose(*falcon_angles(glm::dvec3(0.0)));
    const double none = std::numeric_limits<double>::quiet_NaN();
    const double endless = std::numeric_limits<double>::infinity();
    EXPECT_EQ(falcon_motor_words(*pose, {none, 0, 0}), (std::array<std::int16_t, 3>{}));
    EXPECT_EQ(falcon_motor_words(*pose, {0, endless, 0}), (std::array<std::int16_t, 3>{}));
    EXPECT_EQ(falcon_motor_words(*pose, {0, 0, 0}), (std::array<std::int16_t, 3>{}));
}

}  // namespace
}  // namespace touchable::test
