#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/result.hpp"

namespace touchable {

/// The file of a recording in a folder as ROS 2 makes it, with metadata.yaml and a .db3 or an .mcap; nothing
/// where it is no such folder. Refused: one with several files, and one whose file is packed as a whole.
Result<std::optional<std::filesystem::path>> ros2_recording_in(const std::filesystem::path& folder);

}  // namespace touchable
