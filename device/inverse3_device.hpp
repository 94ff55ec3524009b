#pragma once

#include <memory>
#include <string_view>

#include "device/driven_device.hpp"
#include "device/inverse3_driver.hpp"

namespace touchable {

/// Of the keys of "inverse3[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) what is none.
Result<Inverse3Choice> read_inverse3_choice(std::string_view keys);
Result<std::unique_ptr<HapticDevice>> make_inverse3_device(std::string_view keys,
                                                           const DrivenSettings& driven);

}  // namespace touchable
