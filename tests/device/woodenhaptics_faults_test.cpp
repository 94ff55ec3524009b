#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <thread>

#include "device/drivers/driven_device.hpp"
#include "tests/device/wooden_bench.hpp"

namespace touchable {
namespace {

/// Reports as a bad cable would bring them.
void damage(std::mt19937& random, FakeWire& wire, const Bytes& sound, Bytes& kept) {
    const auto any = [&](int below) { return static_cast<int>(random() % static_cast<unsigned>(below)); };
    switch (any(8)) {
        case 0:
            return;  // lost
        case 1:
            return wire.lay(Bytes(sound.begin(), sound.begin() + any(14)));  // short
        case 2: {
            Bytes broken = sound;
            broken[static_cast<std::size_t>(any(14))] ^= static_cast<std::byte>(1 << any(8));
            return wire.lay(broken);
        }
        case 3:
            wire.lay(sound);
            return wire.lay(sound);  // twice
        case 4:
            kept = sound;
            return;  // late: with the next
        case 5:
            return wire.lay(Bytes(static_cast<std::size_t>(any(65)), static_cast<std::byte>(any(256))));
        case 6:
            return wire.unplug();
        default:
            wire.lay(kept);
            return wire.lay(sound);
    }
}

TEST(WoodenDriver, TenThousandFaultsNeverLeaveAForce) {
    Bench bench;
    bench.wire->remembers = false;
    std::mt19937 random(20);
    std::uniform_real_distribution<double> newton(-30, 30);
    Bytes kept;
    int faults = 0, heard_partings = 0, places = 0;
    bool faulty = false;
    bench.board->silent = true;  // it is answered for
    bench.wire->answer = [&](FakeWire& wire, const Bytes& report) {
        bench.board->hear(wire, report);
        EXPECT_LE(std::abs(bench.board->milliamperes[0]), 1000);
        EXPECT_LE(std::abs(bench.board->milliamperes[1]), 2000);
        EXPECT_LE(std::abs(bench.board->milliamperes[2]), 2000);
        if (!faulty) return wire.lay(bench.board->reading());
        ++faults;
        damage(random, wire, bench.board->reading(), kept);
    };
    while (faults < 10'000) {
        faulty = false;
        bench.wire->plug_in();
        ASSERT_TRUE(bench.connect());
        ASSERT_TRUE(bench.turn(glm::dvec3(0)));
        for (bool held = true; held && faults < 10'000;) {
            faulty = random() % 2 == 0;
            bench.board->pressed = random() % 20 == 0 || bench.board->pressed;
            const bool knew = bench.has_place();
            held = bool(bench.turn({newton(random), newton(random), newton(random)}));
            if (!knew) {
                ASSERT_EQ(bench.board->milliamperes, (std::array<int, 3>{}));
            }
            places += bench.has_place() ? 1 : 0;
        }
        const bool is_in_again = random() % 2 == 0;
        if (is_in_again) bench.wire->plug_in();
        faulty = false;
        bench.driver->disconnect();
        if (is_in_again) {
            ++heard_partings;
            ASSERT_EQ(bench.wire->last_sent(), unpowered);
            ASSERT_EQ(bench.board->milliamperes, (std::array<int, 3>{}));
        }
    }
    EXPECT_GT(heard_partings, 100);
    EXPECT_GT(places, 1000);
}

TEST(WoodenDriver, AHandThatLetsGoOrIsPulledOutIsLimp) {
    auto wire = std::make_shared<FakeWire>();
    wire->waits = true;
    auto board = std::make_shared<Board>();
    wire->answer = [board](FakeWire& on, const Bytes& report) { board->hear(on, report); };
    DrivenDevice device(std::make_unique<WoodenHapticsDriver>(
                            published_build(), false,
                            [wire]() -> Result<std::unique_ptr<ReportTransport>> {
                                return std::unique_ptr<ReportTransport>(std::make_unique<FakeReports>(wire));
                            }),
                        {.away_s = 10, .look_again_s = 0.001});
    ASSERT_TRUE(device.open());
    const std::array<glm::dvec3, 1> push{glm::dvec3(0, 1, 0)};
    std::array<glm::dvec3, 1> place{};
    const auto pushed = [&] { return word_at(wire->last_sent(), 5) == 788; };
    while (!pushed()) {
        ASSERT_TRUE(device.read_positions(place));
        ASSERT_TRUE(device.write_forces(push));
        std::this_thread::yield();
    }
    // Nobody writes any more: it goes unpowered by itself.
    while (wire->last_sent() != unpowered) std::this_thread::yield();
    while (!pushed()) {
        ASSERT_TRUE(device.write_forces(push));
        std::this_thread::yield();
    }
    wire->unplug();
    while (device.facts().losses == 0) std::this_thread::yield();
    wire->plug_in();
    const auto before = device.facts().samples;
    while (device.facts().samples < before + 5) {
        ASSERT_TRUE(device.write_forces(push));
        std::this_thread::yield();
    }
    ASSERT_TRUE(device.read_positions(place));
    EXPECT_TRUE(std::isnan(place[0].x));
    EXPECT_EQ(wire->last_sent(), unpowered);
    device.close();
    EXPECT_EQ(wire->last_sent(), unpowered);
}

}  // namespace
}  // namespace touchable
