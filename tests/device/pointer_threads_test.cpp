// The window's thread, the haptic thread and one that stops, at once: what ThreadSanitizer has to see.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <glm/geometric.hpp>
#include <thread>

#include "device/haptic_device.hpp"

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

TEST(PointerThreads, NobodyEverSeesHalfOfWhatAnotherSaid) {
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

}  // namespace
}  // namespace touchable::test
