// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/falcon_device.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "device/drivers/known_devices.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Packets

constexpr auto falcon_first = std::byte{'<'}, falcon_last = std::byte{'>'};
constexpr std::size_t falcon_state_place = 13;  // lamps and homing out, buttons and homing in
constexpr unsigned homing_bit = 1, homed_bits = 0x70;

constexpr std::byte letter(unsigned bits) {
    return static_cast<std::byte>('A' + bits);
}
constexpr unsigned bits_of(std::byte letter) {
    return std::to_integer<unsigned>(letter) - 'A';
}

/// Lowest four bits first.
void put_word(FalconPacket& packet, std::size_t place, std::int16_t value) {
    const auto bits = static_cast<std::uint16_t>(value);
    for (unsigned digit = 0; digit < 4; ++digit) packet[place + digit] = letter(bits >> 4 * digit & 15U);
}
std::int16_t word_at(const FalconPacket& packet, std::size_t place) {
    unsigned bits = 0;
    for (unsigned digit = 0; digit < 4; ++digit) bits |= bits_of(packet[place + digit]) << 4 * digit;
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(bits));
}

/// The state is seven bits in one letter. The meaning of the letter after it is unknown.
bool may_stand(std::byte byte, std::size_t place) {
    if (place == falcon_packet_bytes - 1) return byte == falcon_last;
    if (byte < letter(0)) return false;
    if (place < falcon_state_place) return byte <= letter(15);
    return place > falcon_state_place || byte <= letter(0x7F);
}

// ---- Kinematics

// Metres, by the letters of Stamper's drawing.
constexpr double upper_arm = 0.060;                          // a: from the motor's axis to the knee
constexpr double shin = 0.1025;                              // b: side of the parallelogram
constexpr double shin_ends = 0.01125 + 0.01125;              // d + e: from its sides to knee and grip
constexpr double grip_out = 0.01443, grip_along = -0.025;    // c, f: of the shin's end at the grip
constexpr double motor_out = 0.040, motor_along = -0.02309;  // r, s: of the motor's axis
constexpr double reach_middle = 0.125;                       // distance from the motors' plane
constexpr double degree = pi / 180;
constexpr double arms_at[3] = {105 * degree, -15 * degree, -135 * degree};  // around z, from x

constexpr double radians_per_count = 2 * pi / (4 * 320) * (14.25 / 110);
constexpr double angle_at_zero = 35 * degree;

constexpr double words_per_newton_metre = -10000;

/// The grip as seen from one arm. In the plane of `out` and `ahead`, the knee is at (upper_arm cos, upper_arm
/// sin) and the grip's joint, `leg` away, at (out, ahead); `along` is across the plane.
struct Leg {
    glm::dvec3 out_axis, along_axis;
    double out = 0, along = 0, ahead = 0;
    double shin_height = 0;  // the parallelogram's, in the plane; NaN: it does not reach across
    double leg() const { return shin_ends + shin_height; }
};

Leg leg_of(std::size_t arm, const glm::dvec3& place) {
    const double c = cosine(arms_at[arm]), s = sine(arms_at[arm]);
    Leg leg;
    leg.out_axis = {c, s, 0};
    leg.along_axis = {-s, c, 0};
    leg.out = glm::dot(leg.out_axis, place) - motor_out + grip_out;
    leg.along = glm::dot(leg.along_axis, place) - motor_along + grip_along;
    leg.ahead = place.z + reach_middle;
    leg.shin_height = std::sqrt(shin * shin - leg.along * leg.along);
    return leg;
}

/// Squared distance from knee to grip minus the leg's square; 0 if the mechanism closes. With its derivatives
/// by the grip's position and by the arm's angle.
struct Gap {
    double size = 0;
    glm::dvec3 over_place{0.0};
    double over_angle = 0;
};

Gap gap_of(const Leg& leg, double angle) {
    const double c = cosine(angle), s = sine(angle);
    const double out = leg.out - upper_arm * c, ahead = leg.ahead - upper_arm * s;
    Gap gap;
    gap.size = out * out + ahead * ahead - leg.leg() * leg.leg();
    gap.over_place = 2.0 * (out * leg.out_axis + leg.leg() * leg.along / leg.shin_height * leg.along_axis +
                            glm::dvec3(0, 0, ahead));
    gap.over_angle = 2 * upper_arm * (leg.out * s - leg.ahead * c);
    return gap;
}

/// Of all three arms; row k of `over_place` is the derivative of arm k's gap.
struct Gaps {
    glm::dvec3 sizes{0.0}, over_angles{0.0};
    glm::dmat3 over_place{0.0};
};

Gaps gaps_of(const FalconAngles& angles, const glm::dvec3& place) {
    Gaps gaps;
    glm::dmat3 rows(0.0);
    for (std::size_t arm = 0; arm < 3; ++arm) {
        const Gap gap = gap_of(leg_of(arm, place), angles[arm]);
        const auto at = static_cast<glm::length_t>(arm);
        gaps.sizes[at] = gap.size;
        gaps.over_angles[at] = gap.over_angle;
        rows[at] = gap.over_place;
    }
    gaps.over_place = glm::transpose(rows);
    return gaps;
}

/// Two positions close the mechanism; true for the right one: before the motors, knees outward.
bool is_the_arms_own(const FalconAngles& angles, const glm::dvec3& place) {
    const auto own = falcon_angles(place);
    if (!own) return false;
    for (std::size_t arm = 0; arm < 3; ++arm)
        if (std::abs((*own)[arm] - angles[arm]) > 1e-6) return false;
    return true;
}

// ---- The driver

using std::chrono::microseconds;

constexpr std::array<std::int16_t, 3> no_motors{};

// ---- Keys

constexpr DeviceLimits falcon_limits{8, 1000};
constexpr std::array<KeyedValues::Key, 3> falcon_keys{{
    {"firmware", "a file", 0, 0, 0, KeyedValues::Key::Kind::words},
    {"force", "N", 0.1, 10, falcon_limits.max_force},
    {"stiffness", "N/mm", 0.01, 10, falcon_limits.max_stiffness / 1000},
}};

}  // namespace

// ---- Packets

FalconPacket encode(const FalconCommand& command) {
    FalconPacket packet;
    packet.fill(letter(0));
    packet.front() = falcon_first;
    for (std::size_t arm = 0; arm < 3; ++arm) put_word(packet, 1 + 4 * arm, command.motors[arm]);
    packet[falcon_state_place] = letter(homing_bit | static_cast<unsigned>(command.lamp));
    packet.back() = falcon_last;
    return packet;
}

std::optional<FalconReport> FalconReader::take(std::byte byte) {
    if (byte == falcon_first) {
        if (filled_ > 0) ++damaged_;
        packet_[0] = byte;
        filled_ = 1;
        return std::nullopt;
    }
    if (filled_ == 0) return std::nullopt;
    if (!may_stand(byte, filled_)) {
        ++damaged_;
        filled_ = 0;
        return std::nullopt;
    }
    packet_[filled_++] = byte;
    if (filled_ < falcon_packet_bytes) return std::nullopt;
    filled_ = 0;
    FalconReport report;
    for (std::size_t arm = 0; arm < 3; ++arm) report.counts[arm] = word_at(packet_, 1 + 4 * arm);
    const unsigned state = bits_of(packet_[falcon_state_place]);
    report.buttons = static_cast<std::uint8_t>(state & 15U);
    report.homed = (state & homed_bits) == homed_bits;
    return report;
}

// ---- Kinematics

double falcon_angle(std::int16_t count) {
    return angle_at_zero + radians_per_count * count;
}

/// The motor's axis, the knee and the grip's joint form a triangle with known sides.
std::optional<FalconAngles> falcon_angles(const glm::dvec3& place) {
    FalconAngles angles{};
    for (std::size_t arm = 0; arm < 3; ++arm) {
        const Leg leg = leg_of(arm, place);
        const double away = std::sqrt(leg.out * leg.out + leg.ahead * leg.ahead);
        const double at_motor =
            (away * away + upper_arm * upper_arm - leg.leg() * leg.leg()) / (2 * upper_arm * away);
        if (!(std::abs(at_motor) <= 1)) return std::nullopt;
        angles[arm] = arctangent2(leg.ahead, leg.out) - (pi / 2 - arcsine(at_motor));
    }
    return angles;
}

std::optional<FalconPose> falcon_pose(const FalconAngles& angles, const glm::dvec3& start) {
    constexpr int most_steps = 50;
    constexpr double longest_step = 0.02, converged = 1e-11;
    glm::dvec3 place = start;
    for (int step = 0; step < most_steps; ++step) {
        const Gaps gaps = gaps_of(angles, place);
        const glm::dvec3 move = -(glm::inverse(gaps.over_place) * gaps.sizes);
        const double length = glm::length(move);
        if (!std::isfinite(length)) return std::nullopt;
        place += length > longest_step ? move * (longest_step / length) : move;
        if (length > converged) continue;
        if (glm::length(place) > falcon_edge || !is_the_arms_own(angles, place)) return std::nullopt;
        FalconPose pose{place, glm::dmat3(0.0)};
        const Gaps closed = gaps_of(angles, place);
        const glm::dmat3 over_gaps = glm::inverse(closed.over_place);
        for (glm::length_t arm = 0; arm < 3; ++arm)
            pose.metres_per_radian[arm] = -over_gaps[arm] * closed.over_angles[arm];
        return pose;
    }
    return std::nullopt;
}

std::array<std::int16_t, 3> falcon_motor_words(const FalconPose& pose, const glm::dvec3& newtons) {
    const glm::dvec3 words = words_per_newton_metre * (glm::transpose(pose.metres_per_radian) * newtons);
    const double largest = std::max({std::abs(words.x), std::abs(words.y), std::abs(words.z)});
    if (!std::isfinite(largest)) return {};
    const double shortened = largest > falcon_largest_word ? falcon_largest_word / largest : 1.0;
    std::array<std::int16_t, 3> sent{};
    for (glm::length_t arm = 0; arm < 3; ++arm)
        sent[static_cast<std::size_t>(arm)] = static_cast<std::int16_t>(std::round(words[arm] * shortened));
    return sent;
}

// ---- The driver

Result<void> FalconDriver::connect() {
    disconnect();
    TRY_ASSIGN(auto port, plug_());
    transport_ = std::make_unique<FtdiTransport>(std::move(port), clock_);
    TRY_ASSIGN(auto answered, answers());
    if (!answered) TRY(load());
    runs_ = true;
    return command(no_motors);
}

/// Sends zeros twice: the first packet may follow a truncated one and be lost with it.
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

/// Whether firmware runs on the device. Firmware that has just started may ignore the first requests.
Result<bool> FalconDriver::answers() {
    constexpr int most_questions = 10;
    TRY(begin_falcon_run(*transport_));
    reader_.forget();
    unanswered_ = 0;
    for (int question = 0; question < most_questions; ++question) {
        if (stop_requested()) return interrupted_error();
        TRY(command(no_motors));
        TRY_ASSIGN(const auto report, newest_report(settings_.patience.question));
        if (report) return true;
    }
    return false;
}

/// Real devices are known to need several attempts.
Result<void> FalconDriver::load() {
    constexpr int most_goes = 4;
    if (settings_.firmware.empty())
        return device_error(
            "Novint Falcon: has no firmware, which it loses with its power; name the file, which an owner "
            "finds as docs/devices.md says",
            {{Setting::device, "falcon:firmware=FILE"}});
    Error last;
    for (int go = 0; go < most_goes; ++go) {
        const auto loaded = load_falcon_firmware(*transport_, settings_.firmware, settings_.patience);
        if (!loaded && loaded.error().kind == ErrorKind::interrupted) return loaded;
        if (!loaded) {
            last = loaded.error();
            continue;
        }
        TRY_ASSIGN(const auto answered, answers());
        if (answered) return {};
        last = {ErrorKind::device,
                "Novint Falcon: took its firmware but does not answer; is the file its firmware?"};
    }
    last.message += " (" + std::to_string(most_goes) + " goes)";
    return last;
}

Result<void> FalconDriver::send(std::span<const glm::dvec3> newtons) {
    const bool lives = is_homed() && pose_ && !newtons.empty();
    return command(lives ? falcon_motor_words(*pose_, newtons.front()) : no_motors);
}

/// Answer to the newest request: taking a late answer for it would leave positions a tick behind for ever.
/// After an answer, others that are missing for 2 ms more count as lost.
Result<std::optional<FalconReport>> FalconDriver::newest_report(microseconds patience) {
    constexpr std::int64_t overdue_ns = 2'000'000;
    std::int64_t until = clock_() + std::chrono::nanoseconds(patience).count();
    std::optional<FalconReport> newest;
    std::int64_t came_ns = 0;
    std::array<std::byte, UsbPort::packet_bytes> room;
    std::size_t came = 1;
    for (int most = 64; came > 0 && most > 0; --most) {  // bounded: endless data must not hold the thread
        const microseconds left((until - clock_()) / 1000);
        const bool waits = unanswered_ > 0 && left.count() > 0;
        TRY_ASSIGN(came, transport_->receive(room, waits ? left : microseconds(0)));
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
        return device_error("Novint Falcon: does not answer any more; is its power plugged in?");
    return false;
}

/// Two packets of the watchdog's process may still be under way: count them, so that their answers are not
/// taken for those to later requests.
Result<void> FalconDriver::forget_what_came() {
    constexpr int packets_at_a_time = 2;
    TRY(transport_->purge());
    reader_.forget();
    unanswered_ = packets_at_a_time;
    received_ns_ = clock_();  // the silence timeout starts anew
    return {};
}

void FalconDriver::take(const FalconReport& report, DeviceSample& sample) {
    homed_in_a_row_ = report.homed ? std::min(homed_in_a_row_ + 1, homed_reports) : 0;
    sample.buttons = report.buttons;
    sample.metres.fill(no_place);
    const auto last = std::exchange(pose_, std::nullopt);
    if (!is_homed()) return;
    FalconAngles angles;
    std::ranges::transform(report.counts, angles.begin(), falcon_angle);
    if (last) pose_ = falcon_pose(angles, last->place);
    if (!pose_) pose_ = falcon_pose(angles);
    impossible_in_a_row_ = pose_ ? 0 : impossible_in_a_row_ + 1;
    if (pose_) sample.metres.front() = pose_->place;
}

std::string FalconDriver::prompt() const {
    constexpr int no_chance = 200;
    if (!transport_) return {};
    if (is_homed())
        return impossible_in_a_row_ < no_chance ? std::string()
                                                : "the Falcon's encoders tell of a place that it cannot "
                                                  "reach; pull its power plug and put it in again";
    return "pull the Falcon's grip out, then push it in, until its ring is green";
}

// ---- Keys

Result<FalconSettings> read_falcon_settings(std::string_view keys) {
    TRY_ASSIGN(const auto given, KeyedValues::parse("device 'falcon'", keys, falcon_keys));
    FalconSettings settings;
    settings.limits = {given.number("force"), given.number("stiffness") * 1000};
    if (given.given("firmware"))
        TRY(assign(settings.firmware, read_falcon_firmware(given.words("firmware"))));
    return settings;
}

Result<std::unique_ptr<DeviceDriver>> make_falcon_driver(std::string_view keys) {
    TRY_ASSIGN(auto settings, read_falcon_settings(keys));
    return std::make_unique<FalconDriver>(std::move(settings), [] { return open_falcon(ConnectedSystem()); });
}

}  // namespace touchable
