#include "device/woodenhaptics_driver.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::chrono::microseconds while_it_wakes{20'000};
constexpr std::int64_t waking_ns = 500'000'000;

}  // namespace

WoodenHapticsDriver::WoodenHapticsDriver(const WoodenParameters& build, bool is_homed, Open open,
                                         DriverClock clock)
    : build_(build), is_homed_(is_homed), open_(std::move(open)), clock_(std::move(clock)) {}

std::string WoodenHapticsDriver::name() const {
    return build_.name + (build_.drive ? "" : " (exerts no force: \"drive\" is \"no\" in its file)");
}

DeviceCapabilities WoodenHapticsDriver::capabilities() const {
    return {.axes_sensed = 3,
            .axes_driven = build_.drive ? 3 : 0,
            .reach = glm::dvec3(build_.reach),
            .rate_hz = 1000,
            .buttons = 0,
            .own_watchdog = true,
            .answers = true};
}

Result<void> WoodenHapticsDriver::connect(const GivenUp& given_up) {
    TRY_ASSIGN(auto opened, open_());
    transport_ = std::move(opened);
    homed_ = Homed::no;
    pressed_ = 0;
    // A board that has just been plugged in loses reports.
    auto woken = await_reading(
        given_up, [] { return true; }, "does not answer with reports of 14 bytes; is its firmware another?");
    if (!woken.ok()) return woken;
    if (was_held_) return {};
    if (build_.homing == WoodenParameters::Homing::button) {
        was_held_ = true;
        if (is_homed_ && reading_.info == 0) homed_ = Homed::yes;
        return {};
    }
    if (auto told = set_counters(); !told.ok()) return told;
    auto homed = await_reading(
        given_up, [this] { return is_at_home(); },
        "does not take the counters of its home pose; is its firmware another?");
    if (!homed.ok()) return homed;
    was_held_ = true;
    homed_ = Homed::yes;
    return {};
}

/// Asks, with no current, until a reading came that is right.
Result<void> WoodenHapticsDriver::await_reading(const GivenUp& given_up,
                                                const std::function<bool()>& is_right,
                                                const char* otherwise) {
    const std::int64_t since = clock_();
    while (!given_up()) {
        if (auto asked = transport_->send(encode_wooden_currents({})); !asked.ok()) return asked;
        TRY_ASSIGN(const auto came, read_newest(while_it_wakes));
        if (came && is_right()) return {};
        if (clock_() - since > waking_ns) return Error{ErrorKind::device, build_.name + ": " + otherwise};
    }
    return Error{ErrorKind::interrupted, build_.name + ": given up"};
}

void WoodenHapticsDriver::disconnect() noexcept {
    if (!transport_) return;
    try {
        const auto unpowered = encode_wooden_currents({});
        for (int again = 0; again < 2; ++again)
            [[maybe_unused]] const auto sent = transport_->send(unpowered);
    } catch (...) {
    }
    transport_.reset();
}

Result<void> WoodenHapticsDriver::set_counters() {
    std::array<std::int16_t, 6> counters{};
    for (std::size_t joint = 0; joint < 3; ++joint) counters[joint] = build_.joints[joint].home_counts;
    homed_ = Homed::counters_sent;
    return transport_->send(encode_wooden_counters(counters));
}

Result<void> WoodenHapticsDriver::send(std::span<const glm::dvec3> newtons) {
    // The board remembers its button until its counters are set.
    if (homed_ != Homed::yes && pressed_ >= sure_of_button) return set_counters();
    const bool lives = build_.drive && has_place();
    return transport_->send(encode_wooden_currents(lives ? wooden_currents(build_, angles(), newtons[0])
                                                         : std::array<std::int16_t, 3>{}));
}

Result<bool> WoodenHapticsDriver::receive(DeviceSample& sample, std::chrono::microseconds patience) {
    TRY_ASSIGN(const auto came, read_newest(patience));
    if (!came) {
        if (clock_() - read_ns_ > silent_ns)
            return Error{ErrorKind::device,
                         build_.name + ": has said nothing for a second; is its board still powered?"};
        return false;
    }
    look_at_button();
    sample.metres[0] =
        has_place() ? wooden_place(build_, angles()) : glm::dvec3(std::numeric_limits<double>::quiet_NaN());
    sample.buttons = 0;
    return true;
}

/// A pressed button means that the angles are about to be others; one that is no longer pressed after the
/// counters were sent, that they are.
void WoodenHapticsDriver::look_at_button() {
    if (pressed_ >= sure_of_button && homed_ == Homed::yes) homed_ = Homed::no;
    if (reading_.info == 0 && homed_ == Homed::counters_sent) homed_ = is_at_home() ? Homed::yes : Homed::no;
}

bool WoodenHapticsDriver::has_place() const {
    return homed_ == Homed::yes && reading_.info == 0;
}

/// All that has come by now; the newest counts.
Result<bool> WoodenHapticsDriver::read_newest(std::chrono::microseconds patience) {
    std::array<std::byte, 65> room;
    bool any = false;
    for (int most = 64; most > 0; --most) {
        TRY_ASSIGN(const auto came, transport_->receive(room, any ? std::chrono::microseconds(0) : patience));
        if (came == 0) break;
        patience = std::chrono::microseconds(0);
        const auto reading = decode_wooden_reading(std::span(room).first(came));
        if (!reading.ok() || reading->info < 0 || reading->info > 1) {
            ++left_out_;
            continue;
        }
        pressed_ = reading->info == 1 ? pressed_ + 1 : 0;
        reading_ = *reading;
        read_ns_ = clock_();
        any = true;
    }
    return any;
}

Result<void> WoodenHapticsDriver::forget_what_came() {
    std::array<std::byte, 65> room;
    read_ns_ = clock_();  // its silence begins now
    return transport_->drop_what_came(room);
}

bool WoodenHapticsDriver::is_at_home() const {
    for (std::size_t joint = 0; joint < 3; ++joint)
        if (std::abs(reading_.encoders[joint] - build_.joints[joint].home_counts) > home_slack) return false;
    return true;
}

glm::dvec3 WoodenHapticsDriver::angles() const {
    return wooden_angles(build_, {reading_.encoders[0], reading_.encoders[1], reading_.encoders[2]});
}

std::optional<ZeroForcePacket> WoodenHapticsDriver::zero_force_packet() const {
    if (!transport_ || transport_->spare_descriptor() < 0) return std::nullopt;
    const auto unpowered = encode_wooden_currents({});
    return ZeroForcePacket{transport_->spare_descriptor(), {unpowered.begin(), unpowered.end()}, {}, {}};
}

std::string WoodenHapticsDriver::prompt() const {
    if (homed_ == Homed::yes) return {};
    if (build_.homing == WoodenParameters::Homing::start)
        return "it was away: put the handle in its home pose, and press the button of its board or start "
               "anew";
    return "put the handle in its home pose, and press the button of its board";
}

}  // namespace touchable
