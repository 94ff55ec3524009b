#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "device/falcon/falcon_driver.hpp"
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

TEST(FalconFaults, TenThousandAtRandomMoments) {
    FaultyFalcon falcon;
    run_fault_sessions(falcon);
}

}  // namespace
}  // namespace touchable::test
