#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "device/driven_device.hpp"

namespace touchable {

/// A kind of device that a person can hold, by its name on the command line.
struct DeviceKind {
    std::string_view name;
    std::string_view words;  ///< what it is, for people
    std::string_view keys;   ///< that it needs, as ":file=FILE"; empty: none
    Result<std::unique_ptr<HapticDevice>> (*make)(std::string_view keys, const DrivenSettings& driven);
};

/// Every kind that a person can hold. (A simulated one is held by a hand, and the window's pointer is its
/// own.)
std::span<const DeviceKind> device_kinds();

/// Of "NAME[:key=value,...]", not opened yet. Refuses (ErrorKind::usage) an unknown name or key with the
/// legal ones.
Result<std::unique_ptr<HapticDevice>> make_device(const std::string& description,
                                                  const DrivenSettings& driven);

}  // namespace touchable
