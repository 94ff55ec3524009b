#include "device/recorded_device.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <thread>
#include <utility>

#include "device/hand_options.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

using std::chrono::nanoseconds;

class SteadyReplayClock final : public ReplayClock {
public:
    nanoseconds now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
    void wait_until(nanoseconds moment) override {
        std::this_thread::sleep_until(std::chrono::steady_clock::time_point(moment));
    }
};

}  // namespace

std::unique_ptr<ReplayClock> steady_replay_clock() {
    return std::make_unique<SteadyReplayClock>();
}

ReplayDriver::ReplayDriver(std::string file, DeviceLog log, DeviceLimits limits,
                           std::unique_ptr<ReplayClock> clock)
    : file_(std::move(file)), log_(std::move(log)), limits_(limits), clock_(std::move(clock)) {}

DeviceCapabilities ReplayDriver::capabilities() const {
    const std::size_t ticks = log_.ticks();
    const double length = log_.seconds(ticks - 1);
    return {.axes_sensed = 3,
            .axes_driven = 0,
            .reach = glm::dvec3(0),
            .rate_hz = length > 0 ? static_cast<double>(ticks - 1) / length : 0,
            .buttons = 32,
            .own_watchdog = true};
}

Result<void> ReplayDriver::connect(const GivenUp&) {
    connected_ = true;
    since_ = clock_->now();
    next_ = 0;
    over_ = false;
    return {};
}

Result<void> ReplayDriver::send(std::span<const glm::dvec3>) {
    if (!connected_) return Error{ErrorKind::device, "the replay of " + printable(file_) + " is closed"};
    return {};
}

nanoseconds ReplayDriver::time_of(std::size_t tick) const {
    return since_ + nanoseconds(static_cast<std::int64_t>(log_.seconds(tick) * 1e9 + 0.5));
}

/// The newest tick whose time has come; those that were missed are gone, as they are for a device.
Result<bool> ReplayDriver::receive(DeviceSample& sample, std::chrono::microseconds patience) {
    if (!connected_) return Error{ErrorKind::device, "the replay of " + printable(file_) + " is closed"};
    const nanoseconds until = clock_->now() + patience;
    if (next_ == log_.ticks()) {
        // The last tick's place stands as long as those before did: until another would have come.
        if (over_) {
            clock_->wait_until(until);
            return false;
        }
        const nanoseconds end = time_of(next_ - 1) + std::chrono::milliseconds(1);
        clock_->wait_until(std::min(until, end));
        if (clock_->now() < end) return false;
        over_ = true;
        sample.metres.fill(glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
        sample.buttons = 0;
        return true;
    }
    if (time_of(next_) > clock_->now()) clock_->wait_until(std::min(until, time_of(next_)));
    const nanoseconds now = clock_->now();
    if (time_of(next_) > now) return false;
    while (next_ + 1 < log_.ticks() && time_of(next_ + 1) <= now) ++next_;
    sample = log_.sample(next_++);
    return true;
}

std::string ReplayDriver::prompt() const {
    return over_ ? "the log " + printable(file_) + " has ended: nothing holds the handle any more"
                 : std::string();
}

namespace {

constexpr std::array<HandKey, 2> recorded_keys{{
    {"force", "N", 0.1, 1000, 10},
    {"stiffness", "N/mm", 0.01, 1000, 3},
}};

}  // namespace

Result<std::unique_ptr<ReplayDriver>> read_recorded_device(std::string_view text,
                                                           std::unique_ptr<ReplayClock> clock) {
    // A file's name may have colons; keys have an equals sign after the last one.
    const std::size_t colon = text.rfind(':');
    const bool keys = colon != text.npos && text.find('=', colon) != text.npos;
    const std::string file(keys ? text.substr(0, colon) : text);
    if (file.empty())
        return usage_error(
            "device 'recorded': no file is given; right would be recorded:FILE with a device's log");
    TRY_ASSIGN(const auto given,
               HandOptions::parse("device 'recorded'", keys ? text.substr(colon + 1) : std::string_view(),
                                  recorded_keys));
    TRY_ASSIGN(auto log, DeviceLog::read(file));
    const DeviceLimits limits{given.number("force"), given.number("stiffness") * 1000};
    return std::make_unique<ReplayDriver>(file, std::move(log), limits, std::move(clock));
}

Result<std::unique_ptr<HapticDevice>> make_recorded_device(std::string_view text,
                                                           const DrivenSettings& driven) {
    TRY_ASSIGN(auto driver, read_recorded_device(text, steady_replay_clock()));
    return std::unique_ptr<HapticDevice>(std::make_unique<DrivenDevice>(std::move(driver), driven));
}

}  // namespace touchable
