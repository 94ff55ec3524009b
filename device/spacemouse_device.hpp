#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "device/driven_device.hpp"
#include "device/spacemouse_motion.hpp"

namespace touchable {

struct SpaceMouseSettings {
    std::string node;  ///< empty: the first that is connected
    SpaceMousePace pace{};
};

/// Of the keys of "spacemouse[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) what is none.
Result<SpaceMouseSettings> read_spacemouse_settings(std::string_view keys);
Result<std::unique_ptr<HapticDevice>> make_spacemouse_device(std::string_view keys,
                                                             const DrivenSettings& driven);

}  // namespace touchable
