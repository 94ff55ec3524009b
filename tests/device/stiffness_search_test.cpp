// SPDX-License-Identifier: Apache-2.0
// The stiffness at which a spring begins to shake, found in virtual time, against what theory says of it
// (docs/measurements.md).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "device/drivers/device_catalog.hpp"
#include "device/drivers/device_measure.hpp"
#include "tests/device/fake_driver.hpp"

namespace touchable::test {
namespace {

constexpr double period = 0.001;

/// Expects that the search finds the boundary within its step, and 5 % for what theory leaves out.
void expect_found(BenchDevice& device, double boundary) {
    const auto found = find_stiffness(device, device.pace());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LE(found->quiet, 1.05 * boundary);
    EXPECT_GE(found->quiet, boundary / std::sqrt(2.0) / 1.05);
    EXPECT_NEAR(found->shaking / found->quiet, std::sqrt(2.0), 1e-9);
    EXPECT_TRUE(found->moved);
    EXPECT_EQ(device.asked, glm::dvec3(0)) << "it ends without force";
    EXPECT_LE(device.longest, 1.5 * (1 + 1e-12));
    EXPECT_LT(device.farthest, 0.006) << "let go 3 mm from where it rested, which nudges may have moved";
}

TEST(StiffnessSearch, FindsColgateAndSchenkelsBound) {
    for (const double damping : {1.0, 3.0, 5.0})
        for (const double mass : {0.1, 0.5}) {
            SCOPED_TRACE(std::to_string(damping) + " N s/m, " + std::to_string(mass) + " kg");
            BenchDevice device({.mass = mass, .damping = damping, .hand_stiffness = 0});
            expect_found(device, 2 * damping / period);
        }
}

TEST(StiffnessSearch, FindsGilsBoundWithDelay) {
    for (const int delay : {1, 3}) {
        SCOPED_TRACE(std::to_string(delay) + " ticks late");
        BenchDevice device({.mass = 0.5, .damping = 5, .hand_stiffness = 0}, delay);
        expect_found(device, 5 / (period / 2 + delay * period));
    }
}

TEST(StiffnessSearch, CoarseEncodersLowerStiffness) {
    BenchDevice device({.mass = 0.5, .damping = 5, .quantum = 60e-6, .hand_stiffness = 0});
    const auto found = find_stiffness(device, device.pace());
    ASSERT_TRUE(found);
    EXPECT_LT(found->quiet, 0.5 * 2 * 5 / period) << "without friction it shakes by a quantum for ever";
    EXPECT_FALSE(found->why.empty());
}

TEST(StiffnessSearch, EndsAtDeviceLimit) {
    BenchDevice device({.mass = 0.5, .damping = 20, .hand_stiffness = 0});
    device.limit = {2, 1234};
    const auto found = find_stiffness(device, device.pace());
    ASSERT_TRUE(found);
    EXPECT_EQ(found->quiet, 1234);
    EXPECT_EQ(found->shaking, 0);
    EXPECT_EQ(found->most_force, 1) << "half of what it bears";
    EXPECT_LE(device.longest, 1.0 + 1e-12);
}

TEST(StiffnessSearch, ReportsHandleHeldByFriction) {
    BenchDevice device({.mass = 0.5, .damping = 5, .friction = 2, .hand_stiffness = 0});
    const auto found = find_stiffness(device, device.pace());
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->moved);
}

TEST(StiffnessSearch, RejectsDeviceWithoutForce) {
    BenchDevice device({});
    device.driven = 0;
    const auto found = find_stiffness(device, device.pace());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().kind, ErrorKind::usage);
    EXPECT_EQ(device.longest, 0);
}

/// Each end comes in the middle of a spring's trial, in which a force is on.
TEST(StiffnessSearch, EveryEndRemovesForce) {
    constexpr std::int64_t in_the_nudge = 305;
    BenchDevice stopped({.hand_stiffness = 0}), lost({.hand_stiffness = 0}), broken({.hand_stiffness = 0});
    stopped.stops_at = lost.loses_place_at = broken.breaks_at = in_the_nudge;
    EXPECT_EQ(find_stiffness(stopped, stopped.pace()).error().kind, ErrorKind::interrupted);
    EXPECT_EQ(find_stiffness(lost, lost.pace()).error().kind, ErrorKind::device);
    EXPECT_EQ(find_stiffness(broken, broken.pace()).error().message, "bench device: broke");
    for (const BenchDevice* device : {&stopped, &lost, &broken}) {
        EXPECT_EQ(device->asked, glm::dvec3(0));
        EXPECT_GT(device->longest, 0.4) << "there was a force to end";
    }
}

/// A handle that rests until it is pushed first. From then on it does what a test says.
class ScriptedHandle final : public HapticDevice {
public:
    /// Metres from where it rested, so many ticks after it was pushed first.
    explicit ScriptedHandle(std::function<double(int)> away) : away_(std::move(away)) {}

    std::string name() const override { return "scripted handle"; }
    DeviceLimits limits() const override { return {8, 100}; }
    int fingers() const override { return 1; }
    DeviceCapabilities capabilities() const override { return {.axes_driven = 3}; }
    Result<void> open() override { return {}; }
    void close() override {}
    bool read_positions(std::span<glm::dvec3> metres) override {
        is_at_ = pushed_at_ ? away_(ticks_++ - *pushed_at_) : 0;
        metres[0] = {0, is_at_, 0};
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override {
        force = glm::length(newtons[0]);
        if (force == 0) return true;
        if (!pushed_at_) pushed_at_ = ticks_;
        ++pushes;
        longest = std::max(longest, force);
        farthest = std::max(farthest, std::abs(is_at_));
        return true;
    }
    Result<void> health() const override { return {}; }
    TickPace pace() {
        return {[] { return true; }, [] { return std::int64_t{0}; }};
    }

    double force = 0, longest = 0, farthest = 0;  ///< N now, and at most; metres away while there was any
    int pushes = 0;                               ///< ticks with a force

private:
    std::function<double(int)> away_;
    int ticks_ = 0;
    std::optional<int> pushed_at_;
    double is_at_ = 0;
};

TEST(StiffnessSearch, NudgesByThirdOfForce) {
    ScriptedHandle device([](int) { return 0.0; });
    const auto found = find_stiffness(device, device.pace());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->most_force, 1.5);
    EXPECT_FALSE(found->moved);
    EXPECT_NEAR(device.longest, 0.5, 1e-12);
    EXPECT_EQ(device.pushes, 10);
}

/// A handle whose motor has the wrong sign creeps off, and never swings.
TEST(StiffnessSearch, ReleasesHandleThatDriftsAway) {
    ScriptedHandle device([](int ticks) { return 0.00002 * ticks; });
    const auto found = find_stiffness(device, device.pace());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->quiet, 0);
    EXPECT_EQ(found->why, "it went 3 mm away");
    EXPECT_LE(device.farthest, 0.003);
    EXPECT_GE(device.farthest, 0.0029);
    EXPECT_EQ(device.force, 0);
}

/// Swings of 20 ms whose peaks grow by 0.1 mm every tenth of a second.
TEST(StiffnessSearch, ReleasesHandleOnDoubledSwings) {
    ScriptedHandle device(
        [](int ticks) { return (0.0001 + 0.000001 * ticks) * std::sin(2 * std::acos(-1.0) * ticks / 20); });
    const auto found = find_stiffness(device, device.pace());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->why, "its swings doubled");
    EXPECT_GE(device.farthest, 0.0002);
    EXPECT_LE(device.farthest, 0.00023) << "at once";
    EXPECT_EQ(device.force, 0);
}

TEST(SpringTrial, EndsWithoutForce) {
    BenchDevice device({.mass = 0.5, .damping = 5, .hand_stiffness = 0});
    const TickPace pace = device.pace();
    SpringTrial trial(device, pace, 1.5);
    for (const double stiffness : {1000.0, 18'000.0}) {  // 10 000 is the bound
        const auto rest = trial.wait_for_rest();
        ASSERT_TRUE(rest);
        const auto verdict = trial.try_spring(stiffness, *rest);
        ASSERT_TRUE(verdict);
        EXPECT_EQ(verdict->quiet, stiffness < 10'000);
        EXPECT_EQ(device.asked, glm::dvec3(0)) << stiffness;
        EXPECT_GT(device.longest, 0.4) << "there was a force to end";
    }
}

TEST(StiffnessSearch, NeverPushesMovingHandle) {
    // A hand that pulls it away: it swings for long.
    class Swinging final : public HapticDevice {
    public:
        std::string name() const override { return "swinging"; }
        DeviceLimits limits() const override { return {8, 1000}; }
        int fingers() const override { return 1; }
        Result<void> open() override { return {}; }
        void close() override {}
        bool read_positions(std::span<glm::dvec3> metres) override {
            metres[0] = {0.002 * std::sin(++reads_ * 0.02), 0, 0};
            return true;
        }
        bool write_forces(std::span<const glm::dvec3> newtons) override {
            pushed = pushed || newtons[0] != glm::dvec3(0);
            return true;
        }
        Result<void> health() const override { return {}; }
        bool pushed = false;

    private:
        int reads_ = 0;
    } device;
    const auto found = find_stiffness(device, {[] { return true; }, [] { return std::int64_t{0}; }});
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().kind, ErrorKind::device);
    EXPECT_NE(found.error().message.find("does not stay still"), std::string::npos) << found.error().message;
    EXPECT_FALSE(device.pushed);
}

// A device that is watched, in virtual time.

constexpr std::int64_t ms = 1'000'000;

/// Hardware whose thread has its turn 0.3 ms after each tick of the reader.
class WatchedDevice : public testing::Test {
protected:
    WatchedDevice() { EXPECT_TRUE(device.open()); }
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
                         .on_received = [this](std::int64_t moment) { times.received.add(moment); },
                         .on_sent = [this](std::int64_t moment) { times.sent.add(moment); },
                         .own_thread = false}};
};

TEST_F(WatchedDevice, MeasuresItsTurns) {
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

TEST_F(WatchedDevice, FiguresShowSilence) {
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

TEST_F(WatchedDevice, StopsOnRequest) {
    stops_at = 10;
    const auto figures = watch_device(device, times, pace(), 1000);
    ASSERT_FALSE(figures);
    EXPECT_EQ(figures.error().kind, ErrorKind::interrupted);
}

TEST(DeviceWatch, ReportsDeviceFailure) {
    BenchDevice device({});
    device.breaks_at = 5;
    const DriveTimes nothing(10);
    const auto figures = watch_device(device, nothing, device.pace(), 100);
    ASSERT_FALSE(figures);
    EXPECT_EQ(figures.error().message, "bench device: broke");
}

TEST(DeviceWatch, MeasuresLongestCall) {
    BenchDevice device({});
    device.takes_ns = 40'000;
    const DriveTimes nothing(10);
    const auto figures = watch_device(device, nothing, device.pace(), 100);
    ASSERT_TRUE(figures);
    EXPECT_NEAR(figures->longest_call_s, 40e-6, 1e-12);
}

/// Reports that were left out; -1: the driver does not count them.
TEST(DriverCounts, AreUnknownWithoutDriverSupport) {
    FakeHardware hardware;
    DrivenDevice device(std::make_unique<FakeDriver>(hardware),
                        {.clock = [] { return ms; }, .own_thread = false});
    ASSERT_TRUE(device.open());
    device.turn();
    EXPECT_EQ(device.facts().left_out, -1);
}

// Figures of moments and places, worked out by hand.

TEST(Percentiles, AreActualValues) {
    std::vector<double> values;
    for (int k = 200; k >= 1; --k) values.push_back(k);
    const WatchFigures::Percentiles found = percentiles_of(values);
    EXPECT_EQ(found.count, 200);
    EXPECT_EQ(found.median, 100);
    EXPECT_EQ(found.p99, 198);
    EXPECT_EQ(found.greatest, 200);
    EXPECT_EQ(percentiles_of({7}).p99, 7);
    EXPECT_EQ(percentiles_of({}).count, 0);
}

TEST(Intervals, SpanConsecutiveMoments) {
    const std::vector<std::int64_t> times{5'000'000, 6'000'000, 9'000'000};
    const auto intervals = intervals_between(times);
    ASSERT_EQ(intervals.size(), 2u);
    EXPECT_NEAR(intervals[0], 0.001, 1e-15);
    EXPECT_NEAR(intervals[1], 0.003, 1e-15);
    EXPECT_TRUE(intervals_between(std::span(times).first(1)).empty());
}

TEST(AnswerWaits, CountOnlyLatestRequest) {
    const std::vector<std::int64_t> asked{1000, 2000, 3000, 9000}, answered{500, 2400, 2500, 5000};
    const auto waits = until_the_next(asked, answered);
    ASSERT_EQ(waits.size(), 2u) << "that of 1000 came after another was asked for, that of 9000 never";
    EXPECT_NEAR(waits[0], 400e-9, 1e-15);
    EXPECT_NEAR(waits[1], 2000e-9, 1e-15);
}

TEST(Rest, MeasuresFlickeringEncoder) {
    std::vector<glm::dvec3> places;
    for (int k = 0; k < 100; ++k) places.push_back({k % 2 == 0 ? 0.0 : 40e-6, 0.001, k < 50 ? 0.0 : 10e-6});
    const WatchFigures::Rest rest = rest_of(places);
    EXPECT_NEAR(rest.deviation_m.x, 20e-6, 1e-12);
    EXPECT_NEAR(rest.deviation_m.y, 0, 1e-12);
    EXPECT_NEAR(rest.deviation_m.z, 5e-6, 1e-12);
    EXPECT_NEAR(rest.step_m.x, 40e-6, 1e-12);
    EXPECT_EQ(rest.step_m.y, 0);
    EXPECT_NEAR(rest.step_m.z, 10e-6, 1e-12);
    EXPECT_NEAR(rest.farthest_m, std::hypot(20e-6, 5e-6), 1e-12);
    EXPECT_FALSE(rest.moved());
}

TEST(Rest, DetectsMovingHand) {
    std::vector<glm::dvec3> places;
    for (int k = 0; k <= 100; ++k) places.push_back({0, k * 20e-6, 0});
    EXPECT_TRUE(rest_of(places).moved()) << "1 mm to each side of the mean";
    EXPECT_EQ(rest_of({}).places, 0);
}

TEST(DriveTimes, KeepNewestWithinRange) {
    DriveTimes times(4);
    for (std::int64_t moment = 1; moment <= 6; ++moment) times.received.add(moment * 10);
    times.sent.add(35);
    EXPECT_EQ(times.received.within(0, 1000), (std::vector<std::int64_t>{30, 40, 50, 60}));
    EXPECT_EQ(times.received.within(40, 60), (std::vector<std::int64_t>{40, 50}));
    EXPECT_EQ(times.sent.within(0, 1000), (std::vector<std::int64_t>{35}));
}

}  // namespace
}  // namespace touchable::test
