// SPDX-License-Identifier: Apache-2.0
// The window's thread, the haptic thread and one that stops, at once: what ThreadSanitizer has to see.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "device/drivers/driven_device.hpp"
#include "device/haptic_device.hpp"
#include "tests/limits.hpp"

namespace touchable::test {
namespace {

constexpr int fingers = 5;
using Places = std::array<glm::dvec3, fingers>;
const glm::dvec3 refuge(0, 0, 0.2);

Places all_at(const glm::dvec3& place) {
    Places places;
    places.fill(place);
    return places;
}

TEST(PointerThreads, ReadersNeverSeePartialUpdate) {
    PointerDevice device(fingers, refuge);
    ASSERT_TRUE(device.open());
    std::atomic<bool> done{false};
    std::thread window([&] {
        for (int k = 0; !done; ++k) {
            device.intend(all_at({0.01 * (k % 7), 0, 0}), refuge);
        }
    });
    std::thread stopper([&] {
        while (!done) {
            device.set_force(false);
            EXPECT_TRUE(device.health());
            device.set_force(true);
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
    });
    Places places;
    for (int tick = 0; tick < 20'000; ++tick) {
        ASSERT_TRUE(device.read_positions(places));
        for (const glm::dvec3& place : places) ASSERT_EQ(place, places[0]) << "all fingers are meant alike";
        ASSERT_TRUE(device.write_forces(all_at({0, 0, 1e-4 * (tick % 1000)})));
    }
    done = true;
    window.join();
    stopper.join();
}

// A device's own thread beside a haptic one: for ThreadSanitizer, and for what only threads can show.

using std::chrono::microseconds;

/// Hardware of atomics: whatever the test does to it, it may do at any time.
struct Hardware {
    std::atomic<bool> plugged{true}, throws{false};
    std::atomic<bool> hangs{false}, is_hanging{false};
    std::atomic<double> force{0};
    std::atomic<std::int64_t> connections{0};
};

class ThreadedDriver final : public DeviceDriver {
public:
    explicit ThreadedDriver(Hardware& hardware) : hardware_(hardware) {}
    std::string name() const override { return "threaded"; }
    int fingers() const override { return 1; }
    DeviceLimits limits() const override { return {10, 3000}; }
    DeviceCapabilities capabilities() const override { return {}; }
    Result<void> connect() override {
        if (!hardware_.plugged) return gone();
        ++hardware_.connections;
        return {};
    }
    void disconnect() noexcept override { hardware_.force = 0; }
    Result<void> send(std::span<const glm::dvec3> newtons) override {
        if (!hardware_.plugged) return gone();
        hardware_.force = newtons[0].z;
        return {};
    }
    Result<bool> receive(DeviceSample& sample, microseconds) override {
        do {
            hardware_.is_hanging = hardware_.hangs.load();
            std::this_thread::sleep_for(microseconds(200));
        } while (hardware_.hangs);
        if (hardware_.throws) throw 1;
        if (!hardware_.plugged) return gone();
        sample.metres[0] = glm::dvec3(0.01);
        return true;
    }

private:
    static Error gone() { return {ErrorKind::device, "threaded: gone"}; }
    Hardware& hardware_;
};

/// The haptic thread's share of a tick.
bool tick(DrivenDevice& device, glm::dvec3& place) {
    const glm::dvec3 newtons(0, 0, 2);
    return device.read_positions(std::span(&place, 1)) && device.write_forces(std::span(&newtons, 1));
}

template <class Condition>
bool comes_true(Condition&& condition) {
    for (int tries = 0; tries < 5000; ++tries) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
}

TEST(DrivenThreads, ForcesEndWithTheirCaller) {
    Hardware hardware;
    DrivenDevice device(std::make_unique<ThreadedDriver>(hardware), {.look_again_s = 0.001});
    ASSERT_TRUE(device.open());
    glm::dvec3 place;
    EXPECT_TRUE(comes_true([&] { return tick(device, place) && hardware.force == 2; }));
    EXPECT_TRUE(comes_true([&] { return hardware.force == 0; })) << "no caller renews it";
    EXPECT_TRUE(comes_true([&] { return tick(device, place) && hardware.force == 2; }));
    device.close();
    EXPECT_EQ(hardware.force, 0);
}

TEST(DrivenThreads, CallsNeverAllocateOrBlock) {
    Hardware hardware;
    DrivenDevice device(std::make_unique<ThreadedDriver>(hardware));
    ASSERT_TRUE(device.open());
    glm::dvec3 place;
    ASSERT_TRUE(comes_true([&] { return tick(device, place) && hardware.force == 2; }));
    hardware.hangs = true;
    ASSERT_TRUE(comes_true([&] { return hardware.is_hanging.load(); }));
    const auto before = allocations();
    for (int ticks = 0; ticks < 1000; ++ticks) ASSERT_TRUE(tick(device, place));
    EXPECT_EQ(allocations(), before);
    EXPECT_TRUE(hardware.is_hanging) << "all of them passed while the hardware gave no answer";
    hardware.hangs = false;
    EXPECT_TRUE(comes_true([&] { return hardware.force == 0; }));
}

TEST(DrivenThreads, SurviveRandomFaults) {
    Hardware hardware;
    DrivenDevice device(std::make_unique<ThreadedDriver>(hardware), {.away_s = 60, .look_again_s = 0.001});
    ASSERT_TRUE(device.open());
    std::atomic<bool> over{false};
    std::thread haptic([&] {
        glm::dvec3 place;
        while (!over) {
            EXPECT_TRUE(tick(device, place));
            std::this_thread::sleep_for(microseconds(100));
        }
    });
    std::mt19937 random(5);
    // A hundred, and more where the device's thread has met too few.
    for (int fault = 0; fault < 100 || (hardware.connections <= 10 && fault < 10'000); ++fault) {
        (fault % 2 == 0 ? hardware.plugged : hardware.throws) = fault % 2 != 0;
        std::this_thread::sleep_for(microseconds(random() % 1000));
        [[maybe_unused]] const auto words = device.prompt() + (device.health() ? "" : "?");
        hardware.plugged = true;
        hardware.throws = false;
        std::this_thread::sleep_for(microseconds(random() % 3000));
    }
    EXPECT_TRUE(comes_true([&] { return hardware.force == 2; }));
    over = true;
    haptic.join();
    device.close();
    EXPECT_EQ(hardware.force, 0);
    EXPECT_GT(hardware.connections, 10);
}

}  // namespace
}  // namespace touchable::test
