#pragma once

#include <memory>
#include <string_view>

#include "device/driven_device.hpp"
#include "device/recorded/replay_driver.hpp"

namespace touchable {

/// Of "FILE[:key=value,...]", which follows "recorded:" (docs/devices.md). Refuses a key that is none
/// (ErrorKind::usage) and a file that is no log (ErrorKind::input).
Result<std::unique_ptr<ReplayDriver>> read_recorded_device(std::string_view text,
                                                           std::unique_ptr<ReplayClock> clock);
Result<std::unique_ptr<HapticDevice>> make_recorded_device(std::string_view text,
                                                           const DrivenSettings& driven);

}  // namespace touchable
