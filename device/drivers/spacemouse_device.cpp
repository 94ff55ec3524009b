// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/spacemouse_device.hpp"

#include <iterator>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::size_t three_axes = 6;
constexpr std::size_t most_button_bytes = 4;
constexpr std::chrono::microseconds spacemouse_turn{1000};  // sampling rate of a moving finger: 1 kHz

Error report_too_short(std::span<const std::byte> bytes, std::size_t right) {
    return device_error("a SpaceMouse's report " + std::to_string(std::to_integer<int>(bytes[0])) + " has " +
                        std::to_string(bytes.size()) + " bytes; must be " + std::to_string(right) +
                        " or more");
}

constexpr SpaceMousePace standard_pace;
constexpr std::array<KeyedValues::Key, 3> spacemouse_keys{{
    {"node", "a node such as /dev/hidraw0", 0, 0, 0, KeyedValues::Key::Kind::words},
    {"speed", "m/s", 0.001, 1, standard_pace.speed},
    {"reach", "m", 0.01, 1, standard_pace.reach},
}};

}  // namespace

bool is_spacemouse(std::uint16_t vendor, std::uint16_t product) {
    constexpr std::uint16_t ordinary_mice[] = {0xc650, 0xc651, 0xc654, 0xc655, 0xc656, 0xc657, 0xc658};
    if (vendor == 0x046d) return product >= 0xc603 && product <= 0xc63f;
    return vendor == 0x256f && std::ranges::find(ordinary_mice, product) == std::end(ordinary_mice);
}

Result<SpaceMouseReport> decode_spacemouse_report(std::span<const std::byte> bytes) {
    if (bytes.empty()) return device_error("a SpaceMouse's report has no bytes");
    SpaceMouseReport report;
    enum Kind { translation = 1, rotation = 2, buttons = 3 };
    const int kind = std::to_integer<int>(bytes[0]);
    const std::size_t least = kind == buttons                           ? 2
                              : kind == translation || kind == rotation ? 1 + three_axes
                                                                        : 1;
    if (bytes.size() < least) return report_too_short(bytes, least);
    if (kind == translation)
        report.translation = glm::ivec3(report_word(bytes, 1), report_word(bytes, 3), report_word(bytes, 5));
    if (kind != buttons) return report;
    report.buttons = 0;
    for (std::size_t byte = 0; byte < std::min(bytes.size() - 1, most_button_bytes); ++byte)
        *report.buttons |= std::to_integer<std::uint32_t>(bytes[1 + byte]) << (8 * byte);
    return report;
}

Result<void> SpaceMouseDriver::connect() {
    TRY_ASSIGN(transport_, open_());
    motion_.emplace(pace_, clock_());
    buttons_ = 0;
    return {};
}

void SpaceMouseDriver::take(std::span<const std::byte> bytes) {
    const auto report = decode_spacemouse_report(bytes);
    if (!report) {
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

Result<SpaceMouseSettings> read_spacemouse_settings(std::string_view keys) {
    TRY_ASSIGN(const auto given, KeyedValues::parse("device 'spacemouse'", keys, spacemouse_keys));
    return SpaceMouseSettings{given.words("node"), {given.number("speed"), given.number("reach")}};
}

Result<std::unique_ptr<DeviceDriver>> make_spacemouse_driver(std::string_view keys) {
    TRY_ASSIGN(const auto settings, read_spacemouse_settings(keys));
    auto open = [node = settings.node] {
        return open_hid(node, is_spacemouse,
                        {ErrorKind::device,
                         "no SpaceMouse is connected (USB 046d:c6xx or 256f): plug one in, or name its node",
                         {{Setting::device, "spacemouse:node=/dev/hidraw0"}}});
    };
    return std::make_unique<SpaceMouseDriver>(settings.pace, std::move(open));
}

}  // namespace touchable
