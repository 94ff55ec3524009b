#include "device/spacemouse_driver.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "device/spacemouse_protocol.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::chrono::microseconds spacemouse_turn{1000};  // a finger that moves is asked for at 1 kHz

}  // namespace

SpaceMouseDriver::SpaceMouseDriver(const SpaceMousePace& pace, Open open, DriverClock clock)
    : pace_(pace), open_(std::move(open)), clock_(std::move(clock)) {}

DeviceCapabilities SpaceMouseDriver::capabilities() const {
    return {.axes_sensed = 3,
            .axes_driven = 0,
            .reach = glm::dvec3(pace_.reach),
            .rate_hz = 1000,
            .buttons = 32,
            .own_watchdog = false};
}

Result<void> SpaceMouseDriver::connect(const GivenUp&) {
    TRY_ASSIGN(auto opened, open_());
    transport_ = std::move(opened);
    motion_.emplace(pace_, clock_());
    buttons_ = 0;
    return {};
}

Result<void> SpaceMouseDriver::send(std::span<const glm::dvec3>) {
    return {};
}

void SpaceMouseDriver::take(std::span<const std::byte> bytes) {
    const auto report = decode_spacemouse_report(bytes);
    if (!report.ok()) {
        ++left_out_;
        return;
    }
    if (report->translation) motion_->deflect(*report->translation, clock_());
    if (report->buttons) buttons_ = *report->buttons;
}

Result<bool> SpaceMouseDriver::receive(DeviceSample& sample, std::chrono::microseconds patience) {
    std::array<std::byte, 64> room;
    auto wait = std::min(patience, spacemouse_turn);
    for (int most = 16; most > 0; --most) {
        TRY_ASSIGN(const auto came, transport_->receive(room, wait));
        if (came == 0) break;
        take(std::span(room).first(came));
        wait = std::chrono::microseconds(0);
    }
    sample.metres[0] = motion_->place(clock_());
    sample.buttons = buttons_;
    return true;
}

}  // namespace touchable
