#include "device/falcon_device.hpp"

#include <array>

#include "device/falcon_loader.hpp"
#include "device/hand_options.hpp"
#include "device/libusb_port.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr DeviceLimits standard_limits = DeviceLimits{8, 1000};
constexpr std::array<HandKey, 3> falcon_keys{{
    {"firmware", "a file", 0, 0, 0, HandKey::Kind::words},
    {"force", "N", 0.1, 10, standard_limits.max_force},
    {"stiffness", "N/mm", 0.01, 10, standard_limits.max_stiffness / 1000},
}};

}  // namespace

Result<FalconSettings> read_falcon_settings(std::string_view keys) {
    const auto given = HandOptions::parse("device 'falcon'", keys, falcon_keys);
    if (!given.ok()) return given.error();
    FalconSettings settings;
    settings.limits = {given->number("force"), given->number("stiffness") * 1000};
    if (given->given("firmware")) {
        TRY_ASSIGN(auto firmware, read_falcon_firmware(given->words("firmware")));
        settings.firmware = std::move(firmware);
    }
    return settings;
}

Result<std::unique_ptr<HapticDevice>> make_falcon_device(std::string_view keys,
                                                         const DrivenSettings& driven) {
    TRY_ASSIGN(auto settings, read_falcon_settings(keys));
    auto driver = std::make_unique<FalconDriver>(std::move(settings), [] { return open_falcon(); });
    return std::unique_ptr<HapticDevice>(std::make_unique<DrivenDevice>(std::move(driver), driven));
}

}  // namespace touchable
