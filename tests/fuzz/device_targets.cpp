// What devices, their services and their logs tell, but for HID.
#include <cmath>
#include <span>

#include "device/drivers/inverse3_device.hpp"
#include "device/drivers/network_device.hpp"
#include "device/drivers/recorded_device.hpp"
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
        if (arm.settings) [[maybe_unused]]
            const auto words = in_words(*arm.settings) + altered_forces(*arm.settings);
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

}  // namespace
}  // namespace touchable::fuzz
