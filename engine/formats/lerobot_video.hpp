#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/given_file.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/lerobot_coding.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

/// LeRobot's video of depth: grey of 12 bits as HEVC, metres.
struct LeRobotDepth {
    DepthCoding coding;
    std::filesystem::path info{};    ///< the file that says so; empty: nobody does, and it is LeRobot's usual
    std::filesystem::path colour{};  ///< the video of colour beside it, as seen from its folder; empty: none
    std::optional<Intrinsics> camera{};  ///< that `info` may name; LeRobot's own do not
};

/// As the features say in NAME.info.json beside NAME.mp4, or in meta/info.json of the data set that it lies
/// in. Nothing where there is neither and its pixels (`codec` and `pixel_format`, as FFmpeg calls them) are
/// not as LeRobot has them. Refused: what is said to be such depth and was encoded anew otherwise, and
/// numbers that are no such coding.
Result<std::optional<LeRobotDepth>> find_lerobot_depth(const SourceFile& video, const std::string& codec,
                                                       const std::string& pixel_format);

/// The videos of depth in a data set's folder, by name; none where it is no data set with depth.
Result<std::vector<std::filesystem::path>> lerobot_depth_videos(const std::filesystem::path& folder);

}  // namespace touchable
