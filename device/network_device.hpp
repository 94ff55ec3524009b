#pragma once

#include <memory>
#include <string_view>

#include "device/driven_device.hpp"
#include "device/network_driver.hpp"

namespace touchable {

/// Of the keys of "network[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) what is none.
Result<NetworkSettings> read_network_settings(std::string_view keys);
Result<std::unique_ptr<HapticDevice>> make_network_device(std::string_view keys,
                                                          const DrivenSettings& driven);

}  // namespace touchable
