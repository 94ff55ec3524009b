#pragma once

#include <memory>
#include <string_view>

#include "device/driven_device.hpp"
#include "device/falcon_driver.hpp"

namespace touchable {

/// Of the keys of "falcon[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) what is none, and
/// (ErrorKind::input) a file that cannot be firmware.
Result<FalconSettings> read_falcon_settings(std::string_view keys);
Result<std::unique_ptr<HapticDevice>> make_falcon_device(std::string_view keys, const DrivenSettings& driven);

}  // namespace touchable
