// The safety contract of every backend, in virtual time: a tick is a reading, a force and a turn of the
// device's thread.
#include "device/drivers/driven_device.hpp"

#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "tests/device/fake_driver.hpp"
#include "tests/device/fault_sessions.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
using Fault = FakeHardware::Fault;

class Driven : public testing::Test {
protected:
    Driven() { EXPECT_TRUE(device.open()); }
    bool turn() {
        now += ms;
        return device.turn();
    }
    /// A haptic tick, then the device's: what the hardware exerts afterwards.
    glm::dvec3 tick(const glm::dvec3& newtons) {
        reads = device.read_positions(std::span(&place, 1));
        writes = device.write_forces(std::span(&newtons, 1));
        turn();
        return hardware.force;
    }
    void settle() {
        for (int turns = 0; turns < 105; ++turns) tick({0, 0, 1});
        ASSERT_EQ(hardware.force, glm::dvec3(0, 0, 1));
    }

    std::int64_t now = ms;
    FakeHardware hardware;
    DrivenDevice device{
        std::make_unique<FakeDriver>(hardware),
        {.away_s = 2, .look_again_s = 0.1, .clock = [this] { return now; }, .own_thread = false}};
    glm::dvec3 place{0.0};
    bool reads = false, writes = false;
};

TEST_F(Driven, ReadsPlacesAndButtonsAndExertsForces) {
    hardware.place = {0.01, 0.02, 0.03};
    hardware.buttons = 2;
    settle();
    EXPECT_TRUE(reads && writes);
    EXPECT_EQ(place, glm::dvec3(0.01, 0.02, 0.03));
    EXPECT_EQ(device.buttons(), 2U);
    EXPECT_LE(device.age_s(), 0.0011);
    EXPECT_TRUE(device.health());
}

TEST_F(Driven, ExertsNothingBeforeItIsAskedTo) {
    for (int turns = 0; turns < 5; ++turns) turn();
    EXPECT_GT(hardware.sent, 3) << "zeros go out all the same";
    EXPECT_EQ(hardware.force, glm::dvec3(0));
}

TEST_F(Driven, ShortensWhatIsLongerThanItsLimit) {
    settle();
    const glm::dvec3 force = tick({30, 0, -40});
    EXPECT_NEAR(glm::length(force), 10, 1e-12);
    EXPECT_NEAR(force.x / force.z, -0.75, 1e-12);
}

TEST_F(Driven, ForceRisesWithinItsCeiling) {
    for (int turns = 0; turns < 150; ++turns) {
        const double force = glm::length(tick({300, -400, 0}));
        ASSERT_LE(force, std::min(10.0, 0.1 * turns + 0.1) + 1e-12) << turns;
        ASSERT_GE(force, std::min(10.0, 0.1 * turns - 0.2) - 1e-12) << turns;
    }
}

TEST_F(Driven, ForceDoesNotLeapAfterALateTurn) {
    double before = 0;
    for (int turns = 0; turns < 30; ++turns) before = tick({0, 0, 10}).z;
    ASSERT_GT(before, 2.5);
    now += 14 * ms;
    const double after = tick({0, 0, 10}).z;
    EXPECT_GT(after, before);
    EXPECT_LE(after - before, 0.7) << "five milliseconds of a tenth of a second, and a tick of headroom";
    for (int turns = 0; turns < 100; ++turns) tick({0, 0, 10});
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 10));
}

TEST_F(Driven, IsLimpAfterASilentCaller) {
    settle();
    int exerted = 0;
    for (; exerted < 100 && turn() && hardware.force != glm::dvec3(0); ++exerted) {
    }
    EXPECT_GE(exerted, 48);
    EXPECT_LE(exerted, 50);
}

TEST_F(Driven, IsLimpAndWithoutAPlaceOrButtonsAfterASilentDevice) {
    hardware.buttons = 3;
    settle();
    EXPECT_EQ(device.buttons(), 3U);
    hardware.fault = Fault::silent;
    int exerted = 0;
    while (exerted < 100 && tick({0, 0, 1}) != glm::dvec3(0)) {
        EXPECT_TRUE(std::isfinite(place.x));
        ++exerted;
    }
    EXPECT_GE(exerted, 19);
    EXPECT_LE(exerted, 20);
    tick({0, 0, 1});
    tick({0, 0, 1});
    EXPECT_TRUE(reads) << "it has not failed, it has nothing to say";
    EXPECT_TRUE(std::isnan(place.x));
    EXPECT_EQ(device.buttons(), 0U);
    hardware.fault = Fault::none;
    tick({0, 0, 1});
    tick({0, 0, 1});
    EXPECT_TRUE(std::isfinite(place.x));
    EXPECT_EQ(device.buttons(), 3U);
}

TEST_F(Driven, AForceThatAnswersAPlaceBeforeAGapDoesNotComeBack) {
    settle();
    hardware.fault = Fault::leap;
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 1));
    for (int turns = 0; turns < 15; ++turns) tick({0, 0, 1});
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 1)) << "its last place is not old yet";
    for (int turns = 0; turns < 10; ++turns) tick({0, 0, 1});
    EXPECT_EQ(hardware.force, glm::dvec3(0)) << "it has no place";
    hardware.fault = Fault::none;
    turn();
    turn();
    EXPECT_EQ(hardware.force, glm::dvec3(0)) << "what was asked for answers another place";
    double before = 0;
    for (int turns = 0; turns < 105; ++turns) {
        const double now_felt = tick({0, 0, 1}).z;
        EXPECT_LE(now_felt - before, 0.0101) << "it rises";
        before = now_felt;
    }
    EXPECT_EQ(before, 1);
}

TEST_F(Driven, AFingerThatTheDeviceKnowsNoPlaceOfIsLimpAtOnce) {
    settle();
    hardware.fault = Fault::no_place;
    tick({0, 0, 1});
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0)) << "its last place is not old, but it is not there any more";
    EXPECT_TRUE(std::isnan(place.x));
    EXPECT_TRUE(device.health());
}

TEST_F(Driven, OpenedAgainItKnowsNoPlaceOrButtonOfBefore) {
    hardware.buttons = 1;
    hardware.over = true;
    settle();
    device.close();
    hardware.fault = Fault::silent;
    hardware.over = false;
    ASSERT_TRUE(device.open());
    EXPECT_FALSE(device.is_over());
    for (int turns = 0; turns < 15; ++turns) {
        EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0)) << "it answers a place of before";
        EXPECT_TRUE(std::isnan(place.x));
        EXPECT_EQ(device.buttons(), 0U);
        EXPECT_EQ(device.age_s(), std::numeric_limits<double>::infinity());
    }
}

TEST_F(Driven, OpenedAgainItExertsNothingThatWasAskedForBefore) {
    settle();
    device.close();
    hardware.kept_ns = 3 * ms;  // what it tells first had come before that
    ASSERT_TRUE(device.open());
    for (int turns = 0; turns < 60; ++turns) {
        turn();
        EXPECT_EQ(hardware.force, glm::dvec3(0)) << turns;
    }
}

/// Hardware that speaks by itself: a force may be asked for before the first word to it.
TEST_F(Driven, OpenedAgainItsForceRisesFromNothing) {
    hardware.descriptor = eventfd(1, EFD_CLOEXEC);  // readable always
    settle();
    device.close();
    ASSERT_TRUE(device.open());
    double before = 0;
    for (int turns = 0; turns < 120; ++turns) {
        const double felt = tick({0, 0, 1}).z;
        EXPECT_LE(felt - before, 0.0501) << "five milliseconds of a tenth of a second, at most";
        before = felt;
    }
    EXPECT_EQ(before, 1);
    ::close(hardware.descriptor);
}

/// The caller lives for 50 ms after its last word; the place is found in these.
TEST_F(Driven, AForceThatWasAskedForBeforeItsFingerWasFoundNeverGoesOut) {
    hardware.fault = Fault::silent;
    for (int turns = 0; turns < 5; ++turns) tick({0, 0, 1});
    hardware.fault = Fault::none;
    for (int turns = 0; turns < 60; ++turns) {
        turn();
        EXPECT_EQ(hardware.force, glm::dvec3(0)) << turns << " ms after it was found first";
    }
    settle();
    hardware.fault = Fault::silent;
    for (int turns = 0; turns < 25; ++turns) tick({0, 0, 1});
    hardware.fault = Fault::none;
    for (int turns = 0; turns < 60; ++turns) {
        turn();
        EXPECT_EQ(hardware.force, glm::dvec3(0)) << turns << " ms after it was found again";
    }
}

TEST_F(Driven, AForceThatIsNotFiniteLeavesItLimpUntilItIsOpenedAgain) {
    settle();
    EXPECT_EQ(tick({0, no_number, 0}), glm::dvec3(0));
    EXPECT_FALSE(writes);
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    EXPECT_FALSE(reads || writes);
    EXPECT_EQ(device.health().error().kind, ErrorKind::device);
    EXPECT_TRUE(device.open());
    settle();
}

TEST_F(Driven, AnUnpluggedDeviceIsLookedForAndComesBackWithoutForce) {
    settle();
    hardware.plugged = false;
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    EXPECT_FALSE(hardware.connected);
    tick({0, 0, 1});
    EXPECT_TRUE(reads && writes);
    EXPECT_TRUE(std::isnan(place.x));
    EXPECT_EQ(device.health().error().message, "fake: gone");
    EXPECT_EQ(device.prompt(), "looking for the fake again");
    for (int turns = 0; turns < 500; ++turns) EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    hardware.plugged = true;
    for (int turns = 0; turns < 101 && !hardware.connected; ++turns) tick({0, 0, 1});
    EXPECT_TRUE(hardware.connected);
    EXPECT_EQ(hardware.force, glm::dvec3(0)) << "nothing was heard of it yet";
    settle();
    EXPECT_TRUE(device.health());
    EXPECT_EQ(device.facts().losses, 1);
}

TEST_F(Driven, ADeviceThatComesBackElsewhereIsBelievedAtOnce) {
    settle();
    hardware.plugged = false;
    tick({0, 0, 1});
    hardware.place = {0.3, 0, 0};
    hardware.plugged = true;
    for (int turns = 0; turns < 101 && !hardware.connected; ++turns) tick({0, 0, 1});
    ASSERT_TRUE(hardware.connected);
    tick({0, 0, 1});
    tick({0, 0, 1});
    EXPECT_EQ(place, glm::dvec3(0.3, 0, 0)) << "where it was before says nothing of where it is";
    EXPECT_EQ(device.facts().implausible, 0);
    settle();
}

TEST_F(Driven, WhatKeepsItFromComingBackIsSaid) {
    settle();
    hardware.plugged = false;
    tick({0, 0, 1});
    hardware.not_opened_because = "fake: may not be opened";
    while (device.prompt() == "looking for the fake again" && turn()) {
    }
    EXPECT_EQ(device.prompt(), "looking for the fake again: fake: may not be opened");
    EXPECT_EQ(device.health().error().message, "fake: gone; now fake: may not be opened");
    for (int turns = 0; turns < 300; ++turns) turn();
    EXPECT_EQ(device.health().error().message, "fake: gone; now fake: may not be opened") << "said once";
    while (turn()) {
    }
    EXPECT_EQ(device.health().error().message, "fake: gone; it did not come back: fake: may not be opened");
}

TEST_F(Driven, OneThatDoesNotComeBackIsGivenUp) {
    settle();
    hardware.plugged = false;
    int turns = 0;
    while (turns < 10'000 && turn()) ++turns;
    EXPECT_GE(turns, 1990);
    EXPECT_LE(turns, 2110);
    tick({0, 0, 1});
    EXPECT_FALSE(reads || writes);
    EXPECT_EQ(device.health().error().message, "fake: gone; it did not come back");
    hardware.plugged = true;
    ASSERT_TRUE(device.open());
    settle();
    EXPECT_TRUE(reads && writes);
}

TEST_F(Driven, ADriverThatThrowsHasFailed) {
    settle();
    hardware.fault = Fault::throws;
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    EXPECT_EQ(device.health().error().message, "fake: bytes that cannot be");
}

TEST_F(Driven, ClosingLeavesNoForce) {
    settle();
    device.close();
    EXPECT_EQ(hardware.force, glm::dvec3(0));
    EXPECT_FALSE(hardware.connected);
    EXPECT_FALSE(device.read_positions(std::span(&place, 1)));
}

TEST_F(Driven, TellsWhatItWaitsFor) {
    hardware.prompt = "pull the grip out, then push it in";
    turn();
    EXPECT_EQ(device.prompt(), hardware.prompt);
}

/// Faults of every kind at random moments, each for a random time: whatever happens, no force goes out that
/// answers a place older than promised, and none that was not asked for.
TEST_F(Driven, TenThousandFaultsAtRandomMoments) {
    SCOPED_TRACE("seed " + std::to_string(fault_seed()));
    std::mt19937 random(fault_seed());
    const auto below = [&](unsigned n) { return static_cast<int>(random() % n); };
    settle();
    std::int64_t sound_ns = now, asked_ns = now;  // the hardware told a sound place; a force was asked for
    for (int fault = 0; fault < 10'000; ++fault) {
        hardware.fault = static_cast<Fault>(1 + below(8));
        const bool unplugged = below(4) == 0, caller_sleeps = below(5) == 0;
        hardware.plugged = !unplugged;
        const int lasts = below(40);
        for (int turns = 0; turns < lasts + 10; ++turns) {
            if (turns == lasts) {
                hardware.fault = Fault::none;
                hardware.plugged = true;
            }
            hardware.place.x = 0.02 * std::sin(static_cast<double>(now) * 5e-9);
            const glm::dvec3 newtons(0, 0, below(20));
            if (!caller_sleeps) {
                ASSERT_TRUE(device.read_positions(std::span(&place, 1)));
                ASSERT_TRUE(std::isnan(place.x) || glm::length(place) < 0.021) << "a place that never was";
                ASSERT_TRUE(device.write_forces(std::span(&newtons, 1)));
                asked_ns = now;
            }
            const bool tells = hardware.connected && hardware.plugged && hardware.fault == Fault::none;
            ASSERT_TRUE(turn());
            if (hardware.force != glm::dvec3(0)) {
                ASSERT_TRUE(hardware.connected);
                ASSERT_LE(glm::length(hardware.force), 10.0);
                ASSERT_LE(now - asked_ns, 50 * ms + ms) << "outlived its caller";
                ASSERT_LE(now - sound_ns, 20 * ms + ms) << "answers a place that is too old";
            }
            if (tells) sound_ns = now;
        }
    }
    EXPECT_GT(device.facts().losses, 500);
    EXPECT_GT(device.facts().implausible, 1000);
    hardware.fault = Fault::none;
    for (int turns = 0; turns < 300; ++turns) tick({0, 0, 1});
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 1)) << "it works again after all that";
    device.close();
    EXPECT_EQ(hardware.force, glm::dvec3(0));
    std::printf("any driver: 10000 faults, seed %u, %.0f s of virtual time\n", fault_seed(),
                static_cast<double>(now) * 1e-9);
}

}  // namespace
}  // namespace touchable::test
