// A device that is watched, in virtual time.
#include "device/drivers/device_catalog.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/device/bench_device.hpp"
#include "tests/device/fake_driver.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// Hardware whose thread has its turn 0.3 ms after each tick of the reader.
class Watched : public testing::Test {
protected:
    Watched() { EXPECT_TRUE(device.open()); }
    TickPace pace() {
        return {[this] {
                    now += 300'000;
                    hardware.place.x = tick % 2 == 0 ? 0 : 50e-6;
                    device.turn();
                    now += 700'000;
                    return ++tick != stops_at;
                },
                [this] { return now; }};
    }

    std::int64_t now = ms;
    int tick = 0, stops_at = 0;
    FakeHardware hardware;
    DriveTimes times{10'000};
    DrivenDevice device{std::make_unique<FakeDriver>(hardware),
                        {.clock = [this] { return now; },
                         .on_received = [this](std::int64_t moment) { times.received(moment); },
                         .on_sent = [this](std::int64_t moment) { times.sent(moment); },
                         .own_thread = false}};
};

TEST_F(Watched, FiguresAreThoseOfItsTurns) {
    const auto figures = watch_device(device, times, pace(), 1001);
    ASSERT_TRUE(figures) << figures.error().message;
    EXPECT_EQ(figures->readings, 1001);
    EXPECT_NEAR(figures->seconds, 1.001, 1e-12);
    EXPECT_EQ(figures->without_place, 1) << "the first reading comes before the first report";
    EXPECT_NEAR(figures->reports_per_s, 1000, 1e-6);
    EXPECT_NEAR(figures->interval_s.greatest, 0.001, 1e-12);
    EXPECT_NEAR(figures->age_s.median, 0.0007, 1e-12);
    EXPECT_NEAR(figures->going_out_s.median, 0.0003, 1e-12);
    EXPECT_EQ(figures->until_received_s.greatest, 0) << "the fake answers at once";
    EXPECT_EQ(figures->rest.places, 1000);
    EXPECT_NEAR(figures->rest.step_m.x, 50e-6, 1e-12);
    EXPECT_NEAR(figures->rest.deviation_m.x, 25e-6, 1e-12);
    EXPECT_EQ(hardware.force, glm::dvec3(0));
    EXPECT_GT(hardware.sent, 900);
}

TEST_F(Watched, ASilenceShowsInTheFigures) {
    auto beat = pace();
    auto steps = beat.next_tick;
    beat.next_tick = [this, steps] {
        hardware.fault = tick >= 500 && tick < 540 ? FakeHardware::Fault::silent : FakeHardware::Fault::none;
        return steps();
    };
    const auto figures = watch_device(device, times, beat, 1000);
    ASSERT_TRUE(figures);
    EXPECT_NEAR(figures->interval_s.greatest, 0.041, 1e-9);
    EXPECT_NEAR(figures->interval_s.median, 0.001, 1e-12);
    EXPECT_GE(figures->without_place, 19) << "older than 20 ms is no position";
    EXPECT_LE(figures->without_place, 22);
}

TEST_F(Watched, StopsWhenItIsToldTo) {
    stops_at = 10;
    const auto figures = watch_device(device, times, pace(), 1000);
    ASSERT_FALSE(figures);
    EXPECT_EQ(figures.error().kind, ErrorKind::interrupted);
}

TEST(DeviceWatch, ADeviceThatFailsSaysWhy) {
    BenchDevice device({});
    device.breaks_at = 5;
    const DriveTimes nothing(10);
    const auto figures = watch_device(device, nothing, device.pace(), 100);
    ASSERT_FALSE(figures);
    EXPECT_EQ(figures.error().message, "bench device: broke");
}

TEST(DeviceWatch, TheLongestCallIsWhatTheDeviceKeptItsReaderFor) {
    BenchDevice device({});
    device.takes_ns = 40'000;
    const DriveTimes nothing(10);
    const auto figures = watch_device(device, nothing, device.pace(), 100);
    ASSERT_TRUE(figures);
    EXPECT_NEAR(figures->longest_call_s, 40e-6, 1e-12);
}

TEST(DriverCounts, OfReportsThatWereLeftOutAreTheDriversOrNone) {
    FakeHardware hardware;
    DrivenDevice device(std::make_unique<FakeDriver>(hardware),
                        {.clock = [] { return ms; }, .own_thread = false});
    ASSERT_TRUE(device.open());
    device.turn();
    EXPECT_EQ(device.facts().left_out, -1);
}

}  // namespace
}  // namespace touchable::test
