#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "device/driven_device.hpp"

namespace touchable {

struct WoodenSettings {
    std::string node;  ///< empty: the first that is connected
    std::filesystem::path file;
    bool homed = false;
};

/// Whether ids are those that WoodenHaptics' firmware has (1234:0006, which other boards of its kind have
/// too).
bool is_woodenhaptics(std::uint16_t vendor, std::uint16_t product);

/// Of the keys of "woodenhaptics:file=FILE[,key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage)
/// what is none, and a file that is not named.
Result<WoodenSettings> read_wooden_settings(std::string_view keys);
/// Error (input) also where the file will not do.
Result<std::unique_ptr<HapticDevice>> make_woodenhaptics_device(std::string_view keys,
                                                                const DrivenSettings& driven);

}  // namespace touchable
