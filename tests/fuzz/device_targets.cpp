// SPDX-License-Identifier: Apache-2.0
// Messages of devices and their services, and logs, except HID.

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>

#include "device/drivers/falcon_device.hpp"
#include "device/drivers/hid_transport.hpp"
#include "device/drivers/inverse3_device.hpp"
#include "device/drivers/network_device.hpp"
#include "device/drivers/recorded_device.hpp"
#include "device/drivers/spacemouse_device.hpp"
#include "device/drivers/woodenhaptics_device.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_haply_message(std::string_view bytes) {
    if (const auto version = decode_inverse3_version(bytes); is_taken(version)) [[maybe_unused]]
        const bool known = is_taken(inverse3_dialect(*version));
    if (const auto scale = decode_force_scale(bytes)) require(std::isfinite(*scale), "a scale is not finite");
    const auto message = decode_inverse3_message(bytes);
    if (!is_taken(message)) return false;
    for (const Inverse3Arm& arm : message->arms) {
        require(arm.id.size() <= 64, "an arm's name is longer than 64 bytes");
        require(!arm.place || std::isfinite(arm.place->x + arm.place->y + arm.place->z),
                "a place is not finite");
        require(arm.settings.find('\n') == std::string::npos, "settings are more than a line");
    }
    return true;
}

bool parse_device_log(std::string_view bytes) {
    const auto log = DeviceLog::read(file_of(bytes, "log.csv").string());
    if (!is_taken(log)) return false;
    require(log->ticks() >= 1 && log->fingers() >= 1, "a log of nothing is taken");
    for (std::size_t tick = 0; tick < log->ticks(); ++tick) {
        require(tick == 0 || log->seconds(tick) > log->seconds(tick - 1), "time goes back");
        [[maybe_unused]] const auto sample = log->sample(tick);
    }
    return true;
}

bool parse_network_packet(std::string_view bytes) {
    const auto packet = decode_network_packet(std::as_bytes(std::span(bytes)));
    if (!is_taken(packet)) return false;
    require(encode(*packet).size() == bytes.size(), "a packet is not as long as it says");
    return true;
}

const Registered haply_message_target{
    {.name = "haply_message", .parse = parse_haply_message, .cuts_are_refused = true}};
const Registered device_log_target{{.name = "device_log", .parse = parse_device_log}};
const Registered network_packet_target{
    {.name = "network_packet", .parse = parse_network_packet, .cuts_are_refused = true, .most_bytes = 512}};

// Bytes of a Novint Falcon: its reports, and its answers while its firmware is loaded.

/// The consequences of a report, up to the motors.
void require_bearable(const FalconReport& report) {
    require(report.buttons < 16, "a grip has more than four buttons");
    FalconAngles angles{};
    for (std::size_t arm = 0; arm < 3; ++arm) angles[arm] = falcon_angle(report.counts[arm]);
    const auto pose = falcon_pose(angles);
    if (!pose) return;
    require(glm::length(pose->place) <= falcon_edge + 1e-9, "a grip is beyond its reach");
    for (const glm::dvec3 force : {glm::dvec3(0, 0, 9), glm::dvec3(1e6, -1e6, 1e-6)})
        for (const std::int16_t word : falcon_motor_words(*pose, force))
            require(std::abs(word) <= falcon_largest_word, "a motor gets more than it may");
}

bool parse_falcon_reports(std::string_view bytes) {
    FalconReader reader;
    std::size_t reports = 0;
    for (const std::byte byte : std::as_bytes(std::span(bytes)))
        if (const auto report = reader.take(byte)) {
            ++reports;
            require_bearable(*report);
        }
    const auto begins = std::count(bytes.begin(), bytes.end(), '<');
    require(std::cmp_less_equal(reports, std::min(begins, std::count(bytes.begin(), bytes.end(), '>'))),
            "more reports than begin and end");
    require(reader.damaged() >= 0 && reader.damaged() <= std::ssize(bytes), "more is damaged than came");
    return reports > 0;
}

/// A converter whose packets are an input's, each with its length before it. Waits take no time: the clock
/// goes on where it has none.
class ToldPort final : public UsbPort {
public:
    ToldPort(std::string_view told, std::int64_t& now_ns) : told_(told), now_ns_(now_ns) {}
    Result<void> command(const FtdiCommand&) override { return {}; }
    Result<void> write(std::span<const std::byte>) override { return {}; }
    Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds patience) override {
        now_ns_ += 1000;
        // Bytes that are discarded unread would be lost to the conversation.
        if (patience.count() <= 0 || told_.rest().empty()) {
            now_ns_ += std::chrono::nanoseconds(patience).count();
            return std::size_t{0};
        }
        const std::size_t size = std::min<std::size_t>(told_.byte(), std::min(room.size(), packet_bytes));
        for (std::size_t k = 0; k < size; ++k) room[k] = static_cast<std::byte>(told_.byte());
        return size;
    }

private:
    Taken told_;
    std::int64_t& now_ns_;
};

constexpr const char* other_size = "a firmware of another size than it has";

bool parse_falcon_loading(std::string_view bytes) {
    const auto image = read_falcon_firmware(file_of(bytes, "firmware.bin").string());
    if (is_taken(image)) require(image->size() == bytes.size(), other_size);
    std::int64_t now_ns = 0;
    FtdiTransport transport(std::make_unique<ToldPort>(bytes, now_ns), [&now_ns] { return now_ns; });
    std::array<std::byte, 70> firmware;  // two blocks
    for (std::size_t k = 0; k < firmware.size(); ++k) firmware[k] = static_cast<std::byte>(k);
    const auto loaded = load_falcon_firmware(transport, firmware, {});
    require(loaded || loaded.error().kind == ErrorKind::device, "what a device says is no device's error");
    return is_taken(loaded);
}

const Registered falcon_report_target{
    {.name = "falcon_report", .parse = parse_falcon_reports, .most_bytes = 256, .most_live_mebibytes = 1}};
const Registered falcon_loading_target{{.name = "falcon_loading",
                                        .parse = parse_falcon_loading,
                                        .cuts_are_refused = true,
                                        .most_bytes = 2048,
                                        .most_live_mebibytes = 1}};

// HID devices: their reports, what Linux says of them, and the file that tells how one is built.

bool parse_hid_report(std::string_view bytes) {
    const auto report = std::as_bytes(std::span(bytes));
    const auto puck = decode_spacemouse_report(report);
    const bool is_pucks = is_taken(puck);
    const auto board = decode_wooden_reading(report);
    const bool is_boards = is_taken(board);
    require(is_boards == (bytes.size() == 14), "a reading is not of 14 bytes");
    return is_pucks || is_boards;
}

bool parse_hid_uevent(std::string_view bytes) {
    const auto node = read_hid_uevent(bytes);
    if (node) require(node->name.find('\n') == std::string::npos, "a name is more than a line");
    return node.has_value();
}

bool parse_wooden_file(std::string_view bytes) {
    const auto build = parse_wooden_parameters(bytes, "wooden.json");
    if (!is_taken(build)) return false;
    for (const std::int16_t count : {-32768, -1, 0, 6000, 32767}) {
        const glm::dvec3 angles = wooden_angles(*build, {count, count, count});
        const glm::dvec3 place = wooden_place(*build, angles);
        require(std::isfinite(place.x + place.y + place.z), "a place is not finite");
        const auto currents = wooden_currents(*build, angles, {1e6, -1e6, build->limits.max_force});
        for (std::size_t joint = 0; joint < 3; ++joint)
            require(std::abs(currents[joint]) <= 1000 * build->joints[joint].most_amperes,
                    "a current is more than its motor bears");
    }
    return true;
}

const Registered hid_report_target{{.name = "hid_report", .parse = parse_hid_report, .most_bytes = 65}};
const Registered hid_uevent_target{{.name = "hid_uevent", .parse = parse_hid_uevent, .most_bytes = 512}};
const Registered wooden_file_target{{.name = "wooden_file",
                                     .parse = parse_wooden_file,
                                     .cuts_are_refused = true,
                                     .needless_bytes = 1,
                                     .changes = 300}};

}  // namespace
}  // namespace touchable::fuzz
