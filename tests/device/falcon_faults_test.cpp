#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "device/drivers/falcon_device.hpp"
#include "tests/device/fake_falcon.hpp"
#include "tests/device/fault_sessions.hpp"

namespace touchable::test {
namespace {

/// A Falcon on a bad cable. Now and then it loses its power, and with it its firmware and its homing.
class FaultyFalcon final : public FaultyDevice {
public:
    FaultyFalcon()
        : FaultyDevice("falcon", {.is_stream = true, .place_step = 1e-4, .longest_force = 4096}),
          falcon_(std::make_shared<FakeFalcon>()) {
        for (int byte = 0; byte < 1500; ++byte) falcon_->image += static_cast<char>(byte * 7);
    }

    std::unique_ptr<DeviceDriver> driver() override {
        falcon_->written.clear();
        falcon_->commands.clear();
        FalconSettings settings;
        settings.firmware = bytes_of(falcon_->image);
        const auto plug = [this]() -> Result<std::unique_ptr<UsbPort>> {
            if (line.is_cut()) return gone();
            line.clear();
            return std::unique_ptr<UsbPort>(std::make_unique<Port>(*this));
        };
        return std::make_unique<FalconDriver>(settings, plug, [this] { return time.now_ns(); });
    }
    void live(double angle) override {
        const auto angles = falcon_angles(0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0));
        ASSERT_TRUE(angles);
        for (std::size_t arm = 0; arm < 3; ++arm)
            falcon_->counts[arm] =
                static_cast<int>(std::lround(((*angles)[arm] - 0.610865238198) / 6.35905e-4));
        place_ = 0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0);
    }
    void tend(const std::string&) override { falcon_->homed = true; }
    void suffer_its_own() override {
        falcon_->pull_power();
        line.went_out(0);
    }

    /// Another process leaves it unpowered.
    void hear_another() {
        Port port(*this);
        for (int packet = 0; packet < 2; ++packet) ASSERT_TRUE(port.write(bytes_of("<AAAAAAAAAAAABA>")));
    }
    const glm::dvec3& place() const { return place_; }

private:
    class Port final : public UsbPort {
    public:
        explicit Port(FaultyFalcon& to) : to_(to) {}
        Result<void> command(const FtdiCommand& command) override {
            if (to_.line.is_cut()) return gone();
            if (command == FtdiCommand{0, 1}) to_.line.clear();
            to_.falcon_->command(command);
            return {};
        }
        Result<void> write(std::span<const std::byte> bytes) override {
            if (!to_.line.passes()) return gone();
            FakeFalcon& falcon = *to_.falcon_;
            falcon.write(bytes);
            const bool tells = falcon.has_firmware && falcon.homed;
            for (; !falcon.coming.empty(); falcon.coming.pop_front())
                to_.line.tell(bytes_of(falcon.coming.front()),
                              tells ? to_.place_ : glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
            int longest = 0;
            for (const int word : falcon.motors) longest = std::max(longest, std::abs(word));
            to_.line.went_out(longest);
            return {};
        }
        Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds patience) override {
            if (to_.line.is_cut()) return gone();
            // The converter has a packet for whoever waits a millisecond, be it empty.
            const auto came = to_.line.next(std::min(patience, std::chrono::microseconds(1000)));
            std::fill_n(room.begin(), 2, std::byte{0x60});
            if (!came) return 2;
            const std::size_t bytes = std::min(came->size(), room.size() - 2);
            std::copy_n(came->begin(), bytes, room.begin() + 2);
            return 2 + bytes;
        }

    private:
        FaultyFalcon& to_;
    };
    static Error gone() { return {ErrorKind::device, "fake: was unplugged"}; }

    std::shared_ptr<FakeFalcon> falcon_;
    glm::dvec3 place_{0.0};
};

/// A place is answered a millisecond after it was asked for, and the grip goes on moving.
class SpokenForFalcon : public ::testing::Test {
protected:
    void SetUp() override {
        falcon.time.on_tick = [this] { falcon.live(static_cast<double>(falcon.time.now_ns()) * 7.5e-9); };
        falcon.time.pass(VirtualTime::ms);
        ASSERT_TRUE(driver->connect());
        for (int turns = 0; turns < 20; ++turns) turn();
        ASSERT_EQ(driver->prompt(), "");
    }
    /// How far the place that a turn tells is from where the grip was when it was asked for, metres.
    double turn() {
        const glm::dvec3 none(0), asked = falcon.place();
        EXPECT_TRUE(driver->send(std::span(&none, 1)));
        DeviceSample sample;
        const auto came = driver->receive(sample, std::chrono::microseconds(5000));
        EXPECT_TRUE(came && *came);
        return glm::length(sample.metres[0] - asked);
    }
    FaultyFalcon falcon;
    const std::unique_ptr<DeviceDriver> driver = falcon.driver();
};

TEST_F(SpokenForFalcon, AnswersThatAnotherProcessAskedForShiftNothing) {
    constexpr double encoder_step = 1e-4, of_a_tick = 0.02 * 7.5e-3;
    static_assert(of_a_tick > encoder_step);
    for (const bool goes_on_as_it_speaks : {false, true}) {
        for (int words = 0; words < 10; ++words) {
            falcon.hear_another();
            falcon.time.pass(20 * VirtualTime::ms);
        }
        if (goes_on_as_it_speaks) falcon.hear_another();
        ASSERT_TRUE(driver->forget_what_came());
        if (goes_on_as_it_speaks) falcon.hear_another();
        falcon.time.pass(VirtualTime::ms / 2);
        for (int turns = 0; turns < 5; ++turns)
            ASSERT_LT(turn(), encoder_step) << "turn " << turns << ", " << goes_on_as_it_speaks;
    }
}

TEST_F(SpokenForFalcon, TheTimeInWhichTheProgramStoodStillIsNotItsSilence) {
    falcon.time.pass(1000 * VirtualTime::ms);
    ASSERT_TRUE(driver->forget_what_came());
    DeviceSample sample;
    EXPECT_TRUE(driver->receive(sample, std::chrono::microseconds(0)));
}

TEST(FalconFaults, AtRandomMoments) {
    FaultyFalcon falcon;
    run_fault_sessions(falcon);
}

TEST(FalconFaults, ForceAfterSilence) {
    FaultyFalcon falcon;
    expect_force_after_silence(falcon);
}

}  // namespace
}  // namespace touchable::test
