// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/woodenhaptics_device.hpp"

#include <cmath>
#include <cstdlib>
#include <glm/matrix.hpp>

#include "engine/base/files.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

// ---- Parameter files

using checked_json::Node;

/// The example parameter file, in a checkout and in an installation.
constexpr std::string_view wooden_example =
    "examples/woodenhaptics.json (installed: share/touchable/examples/woodenhaptics.json)";

/// Either sign; the magnitude must be in range.
double signed_within(const Node& node, double least, double most, const char* right) {
    const double number = node.number();
    if (!(std::abs(number) >= least && std::abs(number) <= most)) node.refuse(right);
    return number;
}

bool yes_or_no(const Node& node) {
    const std::pair<const char*, bool> choices[] = {{"yes", true}, {"no", false}};
    return node.one_of(choices);
}

WoodenJoint read_joint(const Node& node) {
    node.allow_only({"counts_per_turn", "capstan_diameter", "drum_diameter", "torque_constant",
                     "most_amperes", "home_counts"});
    const double capstan =
        node["capstan_diameter"].within(0.001, 0.1, "the diameter on the motor's axle, 0.001 to 0.1 m");
    const double drum =
        node["drum_diameter"].within(0.01, 1, "the diameter that the cable turns, 0.01 to 1 m");
    if (!(capstan < drum)) node["capstan_diameter"].refuse("less than drum_diameter");
    WoodenJoint joint;
    joint.counts_per_turn =
        signed_within(node["counts_per_turn"], 16, 1e6, "16 to 1000000, quadrupled, either sign");
    joint.cable_ratio = capstan / drum;
    joint.torque_constant =
        signed_within(node["torque_constant"], 0.001, 10, "0.001 to 10 N m/A, either sign");
    joint.most_amperes = node["most_amperes"].within(0.01, 30, "0.01 to 30 A");
    joint.home_counts = static_cast<std::int16_t>(node["home_counts"].integer(
        std::numeric_limits<std::int16_t>::min(), std::numeric_limits<std::int16_t>::max()));
    return joint;
}

WoodenParameters read_build(const Node& node) {
    node.allow_only({"touchable_woodenhaptics", "notes", "name", "drive", "homing", "joints", "links",
                     "origin", "reach", "most_force", "most_stiffness"});
    node["touchable_woodenhaptics"].integer(1, 1);
    WoodenParameters build;
    build.name = node["name"].text();
    build.drive = yes_or_no(node["drive"]);
    const std::pair<const char*, WoodenParameters::Homing> homings[] = {
        {"start", WoodenParameters::Homing::start}, {"button", WoodenParameters::Homing::button}};
    build.homing = node["homing"].one_of(homings);
    const auto joints = node["joints"].elements(3, 3, "a list of the three joints");
    const auto links = node["links"].elements(3, 3, "a list of three lengths");
    const auto origin = node["origin"].elements(3, 3, "a list of three lengths");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        build.joints[axis] = read_joint(joints[axis]);
        build.links[axis] = links[axis].within(axis == 0 ? 0 : 0.02, 1, "at most 1 m; a moving link 0.02");
        build.origin[static_cast<int>(axis)] = origin[axis].within(-2, 2, "-2 to 2 m");
    }
    build.reach = node["reach"].within(0.01, 1, "0.01 to 1 m");
    build.limits.max_force = node["most_force"].within(0.1, 50, "0.1 to 50 N");
    build.limits.max_stiffness = node["most_stiffness"].within(10, 1e5, "10 to 100000 N/m");
    return build;
}

// ---- Kinematics

constexpr double most_milliamperes = 32767;  // largest value in a report

struct Bends {
    double sin_base, cos_base, sin_upper, cos_upper, sin_fore, cos_fore;
};

Bends bends_of(const glm::dvec3& angles) {
    return {sine(angles[0]),   cosine(angles[0]), sine(angles[1]),
            cosine(angles[1]), sine(angles[2]),   cosine(angles[2])};
}

/// From the linkage's axes: x to the person, y right, z up.
glm::dvec3 from_linkage(const glm::dvec3& there) {
    return {there.y, there.z, there.x};
}

// ---- Reports

using WoodenWords = std::array<std::int16_t, 7>;

WoodenReport wooden_report(const WoodenWords& words) {
    WoodenReport report{};
    for (std::size_t word = 0; word < words.size(); ++word) {
        const auto bits = static_cast<std::uint16_t>(words[word]);
        report[1 + 2 * word] = static_cast<std::byte>(bits & 0xff);
        report[2 + 2 * word] = static_cast<std::byte>(bits >> 8);
    }
    return report;
}

// ---- The driver

constexpr std::chrono::microseconds while_it_wakes{20'000};
constexpr std::int64_t waking_ns = 500'000'000;

// ---- Keys

constexpr std::array<KeyedValues::Key, 3> wooden_keys{{
    {"file", "its parameter file, such as examples/woodenhaptics.json", 0, 0, 0,
     KeyedValues::Key::Kind::words},
    {"node", "a node such as /dev/hidraw0", 0, 0, 0, KeyedValues::Key::Kind::words},
    {"homed", "(1: it was homed since it got its power)", 0, 1, 0, KeyedValues::Key::Kind::whole},
}};

}  // namespace

// ---- Parameter files

Result<WoodenParameters> parse_wooden_parameters(std::string_view json, std::string_view where) {
    return checked_json::read_checked(json, checked_json::largest_text, where, read_build);
}

Result<WoodenParameters> read_wooden_parameters(const std::filesystem::path& file) {
    const std::string right = "a parameter file such as " + std::string(wooden_example);
    TRY_ASSIGN(const auto text, read_given_file(file, file.string(), right, checked_json::largest_text));
    return parse_wooden_parameters(text, file.string());
}

// ---- Kinematics

glm::dvec3 wooden_angles(const WoodenParameters& build, const std::array<std::int16_t, 3>& counts) {
    glm::dvec3 angles;
    for (std::size_t joint = 0; joint < 3; ++joint) {
        const WoodenJoint& turned = build.joints[joint];
        angles[static_cast<int>(joint)] =
            2 * pi * counts[joint] / turned.counts_per_turn * turned.cable_ratio;
    }
    return angles;
}

glm::dvec3 wooden_place(const WoodenParameters& build, const glm::dvec3& angles) {
    const Bends at = bends_of(angles);
    const auto& [base, upper, fore] = build.links;
    const double out = upper * at.sin_upper + fore * at.sin_fore;
    const double height = base + upper * at.cos_upper - fore * at.cos_fore;
    return from_linkage(glm::dvec3(at.cos_base * out, at.sin_base * out, height) - build.origin);
}

glm::dmat3 wooden_jacobian(const WoodenParameters& build, const glm::dvec3& angles) {
    const Bends at = bends_of(angles);
    const auto& [base, upper, fore] = build.links;
    const double out = upper * at.sin_upper + fore * at.sin_fore;
    const glm::dvec3 by_base(-at.sin_base * out, at.cos_base * out, 0);
    const glm::dvec3 by_upper(at.cos_base * upper * at.cos_upper, at.sin_base * upper * at.cos_upper,
                              -upper * at.sin_upper);
    const glm::dvec3 by_fore(at.cos_base * fore * at.cos_fore, at.sin_base * fore * at.cos_fore,
                             fore * at.sin_fore);
    return {from_linkage(by_base), from_linkage(by_upper), from_linkage(by_fore)};
}

std::array<std::int16_t, 3> wooden_currents(const WoodenParameters& build, const glm::dvec3& angles,
                                            const glm::dvec3& newtons) {
    const glm::dvec3 torques = glm::transpose(wooden_jacobian(build, angles)) * newtons;
    glm::dvec3 milliamperes;
    double share = 1;
    for (std::size_t joint = 0; joint < 3; ++joint) {
        const WoodenJoint& turned = build.joints[joint];
        double& needed = milliamperes[static_cast<int>(joint)];
        needed = 1000 * torques[static_cast<int>(joint)] * turned.cable_ratio / turned.torque_constant;
        const double bears = std::min(1000 * turned.most_amperes, most_milliamperes);
        if (std::abs(needed) > bears) share = std::min(share, bears / std::abs(needed));
    }
    std::array<std::int16_t, 3> currents;
    for (std::size_t joint = 0; joint < 3; ++joint)
        currents[joint] = static_cast<std::int16_t>(milliamperes[static_cast<int>(joint)] * share);
    return currents;
}

// ---- Reports

Result<WoodenReading> decode_wooden_reading(std::span<const std::byte> report) {
    if (report.size() != WoodenReading::bytes)
        return device_error("a report of " + std::to_string(report.size()) +
                            " bytes came; expected the 14 of WoodenHaptics' firmware");
    WoodenWords words;
    for (std::size_t word = 0; word < words.size(); ++word) words[word] = report_word(report, 2 * word);
    return WoodenReading{{words[0], words[1], words[2], words[3], words[4], words[5]}, words[6]};
}

WoodenReport encode_wooden_currents(const std::array<std::int16_t, 3>& milliamperes) {
    return wooden_report({milliamperes[0], milliamperes[1], milliamperes[2], 0, 0, 0, 0});
}

WoodenReport encode_wooden_counters(const std::array<std::int16_t, 6>& counters) {
    // The last three counters take the place of the currents.
    return wooden_report({counters[3], counters[4], counters[5], 1, counters[0], counters[1], counters[2]});
}

// ---- The driver

Result<void> WoodenHapticsDriver::connect() {
    TRY_ASSIGN(transport_, open_());
    homed_ = Homed::no;
    pressed_ = 0;
    // A board that has just been plugged in loses reports.
    TRY(await_reading([] { return true; },
                      "does not answer with reports of 14 bytes; is its firmware another?"));
    if (was_held_) return {};
    if (build_.homing == WoodenParameters::Homing::button) {
        was_held_ = true;
        if (is_homed_ && reading_.info == 0) homed_ = Homed::yes;
        return {};
    }
    TRY(set_counters());
    TRY(await_reading([this] { return is_at_home(); },
                      "does not take the counters of its home pose; is its firmware another?"));
    was_held_ = true;
    homed_ = Homed::yes;
    return {};
}

/// Requests readings, with no current, until one is right.
Result<void> WoodenHapticsDriver::await_reading(const std::function<bool()>& is_right,
                                                const char* otherwise) {
    const std::int64_t since = clock_();
    while (!stop_requested()) {
        TRY(transport_->send(encode_wooden_currents({})));
        TRY_ASSIGN(const auto came, read_newest(while_it_wakes));
        if (came && is_right()) return {};
        if (clock_() - since > waking_ns) return device_error(build_.name + ": " + otherwise);
    }
    return interrupted_error();
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

Result<bool> WoodenHapticsDriver::receive(DeviceSample& sample, std::chrono::microseconds patience) {
    TRY_ASSIGN(const auto came, read_newest(patience));
    if (!came) {
        if (clock_() - read_ns_ > silent_ns)
            return device_error(build_.name + ": has said nothing for a second; is its board still powered?");
        return false;
    }
    look_at_button();
    sample.metres[0] = has_place() ? wooden_place(build_, angles()) : no_place;
    sample.buttons = 0;
    return true;
}

/// Reads all reports that have come; the newest counts.
Result<bool> WoodenHapticsDriver::read_newest(std::chrono::microseconds patience) {
    std::array<std::byte, 65> room;
    bool any = false;
    for (int most = 64; most > 0; --most) {
        TRY_ASSIGN(const auto came, transport_->receive(room, any ? std::chrono::microseconds(0) : patience));
        if (came == 0) break;
        patience = std::chrono::microseconds(0);
        const auto reading = decode_wooden_reading(std::span(room).first(came));
        if (!reading || reading->info < 0 || reading->info > 1) {
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

// ---- Keys

bool is_woodenhaptics(std::uint16_t vendor, std::uint16_t product) {
    return vendor == 0x1234 && product == 0x0006;
}

Result<WoodenSettings> read_wooden_settings(std::string_view keys) {
    TRY_ASSIGN(const auto given, KeyedValues::parse("device 'woodenhaptics'", keys, wooden_keys));
    if (!given.given("file"))
        return usage_error(
            "device 'woodenhaptics': no file is named that says how it is built; use "
            "woodenhaptics:file=FILE, with a copy of " +
            std::string(wooden_example));
    return WoodenSettings{given.words("node"), given.words("file"), given.number("homed") == 1};
}

Result<std::unique_ptr<DeviceDriver>> make_woodenhaptics_driver(std::string_view keys) {
    TRY_ASSIGN(const auto settings, read_wooden_settings(keys));
    TRY_ASSIGN(const auto build, read_wooden_parameters(settings.file));
    auto open = [node = settings.node] {
        return open_hid(node, is_woodenhaptics,
                        {ErrorKind::device,
                         "no WoodenHaptics is connected (USB 1234:0006): plug one in, or name its node",
                         {{Setting::device, "woodenhaptics:file=FILE,node=/dev/hidraw0"}}});
    };
    return std::make_unique<WoodenHapticsDriver>(build, settings.homed, std::move(open));
}

}  // namespace touchable
