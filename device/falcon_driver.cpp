#include "device/falcon_driver.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;

constexpr std::array<std::int16_t, 3> no_force{};

Error interrupted() {
    return {ErrorKind::interrupted, "connecting the Novint Falcon was given up"};
}

}  // namespace

DeviceCapabilities FalconDriver::capabilities() const {
    return {.axes_sensed = 3,
            .axes_driven = 3,
            .reach = glm::dvec3(falcon_reach),
            .rate_hz = 1000,
            .buttons = 4,
            .own_watchdog = false,
            .answers = true};
}

Result<void> FalconDriver::connect(const GivenUp& given_up) {
    disconnect();
    TRY_ASSIGN(auto port, plug_());
    transport_ = std::make_unique<FtdiTransport>(std::move(port), clock_);
    TRY_ASSIGN(auto answered, answers(given_up));
    if (!answered)
        if (auto loaded = load(given_up); !loaded.ok()) return loaded;
    runs_ = true;
    return command(no_force);
}

/// Twice, because the first may follow the beginning of another and be lost with it.
void FalconDriver::disconnect() noexcept {
    if (transport_ && runs_) {
        try {
            for (int again = 0; again < 2; ++again)
                [[maybe_unused]] const auto sent = transport_->send(encode(FalconCommand{}));
        } catch (...) {
        }
    }
    transport_.reset();
    runs_ = false;
    reader_.forget();
    unanswered_ = 0;
    homed_in_a_row_ = impossible_in_a_row_ = 0;
    pose_.reset();
}

/// Whether firmware runs on it. One that has just begun may leave the first questions unanswered.
Result<bool> FalconDriver::answers(const GivenUp& given_up) {
    constexpr int most_questions = 10;
    TRY(begin_falcon_run(*transport_));
    reader_.forget();
    unanswered_ = 0;
    for (int question = 0; question < most_questions; ++question) {
        if (given_up()) return interrupted();
        TRY(command(no_force));
        TRY_ASSIGN(const auto report, newest_report(settings_.patience.question));
        if (report) return true;
    }
    return false;
}

/// Known to need several goes on real devices.
Result<void> FalconDriver::load(const GivenUp& given_up) {
    constexpr int most_goes = 4;
    if (settings_.firmware.empty())
        return Error{ErrorKind::device,
                     "Novint Falcon: has no firmware, which it loses with its power; name the file, "
                     "which an owner finds as docs/devices.md says",
                     {{Setting::device, "falcon:firmware=FILE"}}};
    Error last;
    for (int go = 0; go < most_goes; ++go) {
        const auto loaded =
            load_falcon_firmware(*transport_, settings_.firmware, settings_.patience, given_up);
        if (!loaded.ok() && loaded.error().kind == ErrorKind::interrupted) return loaded;
        if (!loaded.ok()) {
            last = loaded.error();
            continue;
        }
        TRY_ASSIGN(const auto answered, answers(given_up));
        if (answered) return {};
        last = {ErrorKind::device,
                "Novint Falcon: took its firmware but does not answer; is the file its firmware?"};
    }
    last.message += " (" + std::to_string(most_goes) + " goes)";
    return last;
}

Result<void> FalconDriver::command(const std::array<std::int16_t, 3>& motors) {
    FalconCommand command;
    command.motors = motors;
    command.lamp = is_homed() ? FalconLamp::green : FalconLamp::red;
    ++unanswered_;
    return transport_->send(encode(command));
}

Result<void> FalconDriver::send(std::span<const glm::dvec3> newtons) {
    const bool lives = is_homed() && pose_ && !newtons.empty();
    return command(lives ? falcon_motor_words(*pose_, newtons.front()) : no_force);
}

/// The answer to the newest question: one that came late must not be taken for it, or places would stay a
/// tick behind for ever. Once a newer one has come, an older one that is overdue is lost.
Result<std::optional<FalconReport>> FalconDriver::newest_report(microseconds patience) {
    constexpr std::int64_t overdue_ns = 2'000'000;
    std::int64_t until = clock_() + std::chrono::nanoseconds(patience).count();
    std::optional<FalconReport> newest;
    std::int64_t came_ns = 0;
    std::array<std::byte, UsbPort::packet_bytes> room;
    std::size_t came = 1;
    for (int most = 64; came > 0 && most > 0; --most) {  // whatever babbles must not hold the thread
        const microseconds left((until - clock_()) / 1000);
        const bool waits = unanswered_ > 0 && left.count() > 0;
        TRY_ASSIGN(const auto received, transport_->receive(room, waits ? left : microseconds(0)));
        came = received;
        for (const std::byte byte : std::span(room).first(came))
            if (const auto report = reader_.take(byte)) {
                newest = report;
                came_ns = clock_();
                unanswered_ = std::max(unanswered_ - 1, 0);
                until = std::min(until, came_ns + overdue_ns);
            }
    }
    if (!newest) return newest;
    unanswered_ = 0;
    received_ns_ = came_ns;
    return newest;
}

Result<bool> FalconDriver::receive(DeviceSample& sample, microseconds patience) {
    TRY_ASSIGN(const auto report, newest_report(patience));
    if (report) {
        take(*report, sample);
        sample.kept_ns = clock_() - received_ns_;
        return true;
    }
    if (static_cast<double>(clock_() - received_ns_) * 1e-9 > silent_s)
        return Error{ErrorKind::device, "Novint Falcon: does not answer any more; is its power plugged in?"};
    return false;
}

/// The last two packets of the other process may still be on their way: so more answers are waited for than
/// questions will have been asked.
Result<void> FalconDriver::forget_what_came() {
    constexpr int packets_at_a_time = 2;
    if (auto purged = transport_->purge(); !purged.ok()) return purged;
    reader_.forget();
    unanswered_ = packets_at_a_time;
    received_ns_ = clock_();  // its silence begins now
    return {};
}

void FalconDriver::take(const FalconReport& report, DeviceSample& sample) {
    homed_in_a_row_ = report.homed ? std::min(homed_in_a_row_ + 1, homed_reports) : 0;
    sample.buttons = report.buttons;
    sample.metres.fill(glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
    const auto last = std::exchange(pose_, std::nullopt);
    if (!is_homed()) return;
    FalconAngles angles;
    std::ranges::transform(report.counts, angles.begin(), falcon_angle);
    if (last) pose_ = falcon_pose(angles, last->place);
    if (!pose_) pose_ = falcon_pose(angles);
    impossible_in_a_row_ = pose_ ? 0 : impossible_in_a_row_ + 1;
    if (pose_) sample.metres.front() = pose_->place;
}

std::optional<ZeroForcePacket> FalconDriver::zero_force_packet() const {
    if (!transport_ || !runs_ || transport_->usbfs() < 0) return std::nullopt;
    const auto packet = encode(FalconCommand{});
    return ZeroForcePacket{transport_->usbfs(), {packet.begin(), packet.end()}, usb_endpoint_out, {}};
}

std::string FalconDriver::prompt() const {
    constexpr int no_chance = 200;
    if (!transport_) return {};
    if (is_homed())
        return impossible_in_a_row_ < no_chance ? std::string()
                                                : "the Falcon's encoders tell of a place that it cannot "
                                                  "reach; pull its power plug and put it in "
                                                  "again";
    return "pull the Falcon's grip out, then push it in, until its ring is green";
}

}  // namespace touchable
