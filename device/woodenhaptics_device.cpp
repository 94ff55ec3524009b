#include "device/woodenhaptics_device.hpp"

#include <array>

#include "device/hand_options.hpp"
#include "device/hid_node.hpp"
#include "device/hid_transport.hpp"
#include "device/woodenhaptics_driver.hpp"
#include "device/woodenhaptics_parameters.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::array<HandKey, 3> wooden_keys{{
    {"file", "its parameter file, such as examples/woodenhaptics.json", 0, 0, 0, HandKey::Kind::words},
    {"node", "a node such as /dev/hidraw0", 0, 0, 0, HandKey::Kind::words},
    {"homed", "(1: it was homed since it got its power)", 0, 1, 0, HandKey::Kind::whole},
}};

Result<std::unique_ptr<ReportTransport>> open_woodenhaptics(const std::string& node) {
    std::string at = node;
    if (at.empty()) {
        const auto found = find_hid_node(is_woodenhaptics);
        if (!found)
            return Error{ErrorKind::device,
                         "no WoodenHaptics is connected (USB 1234:0006): plug one in, or name its node",
                         {{Setting::device, "woodenhaptics:file=FILE,node=/dev/hidraw0"}}};
        at = found->node;
    }
    TRY_ASSIGN(auto opened, HidTransport::open(at));
    return std::unique_ptr<ReportTransport>(std::move(opened));
}

}  // namespace

bool is_woodenhaptics(std::uint16_t vendor, std::uint16_t product) {
    return vendor == 0x1234 && product == 0x0006;
}

Result<WoodenSettings> read_wooden_settings(std::string_view keys) {
    const auto given = HandOptions::parse("device 'woodenhaptics'", keys, wooden_keys);
    if (!given.ok()) return given.error();
    if (!given->given("file"))
        return usage_error(
            "device 'woodenhaptics': no file is named that says how it is built; right would be "
            "woodenhaptics:file=FILE, with a copy of " +
            std::string(wooden_example));
    return WoodenSettings{given->words("node"), given->words("file"), given->number("homed") == 1};
}

Result<std::unique_ptr<HapticDevice>> make_woodenhaptics_device(std::string_view keys,
                                                                const DrivenSettings& driven) {
    TRY_ASSIGN(const auto settings, read_wooden_settings(keys));
    TRY_ASSIGN(const auto build, read_wooden_parameters(settings.file));
    auto open = [node = settings.node] { return open_woodenhaptics(node); };
    return std::unique_ptr<HapticDevice>(std::make_unique<DrivenDevice>(
        std::make_unique<WoodenHapticsDriver>(build, settings.homed, std::move(open)), driven));
}

}  // namespace touchable
