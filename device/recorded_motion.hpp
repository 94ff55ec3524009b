#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.hpp"

namespace touchable {

/// Which of a table's columns are a motion, and in what unit.
struct MotionSettings {
    /// One column: how far the motion goes in, along -Z. Three columns: a position, in any axes.
    std::vector<std::string> columns;
    double scale = 1;  ///< device metres per unit of the columns
    std::optional<double> extent =
        {};  ///< three columns: instead of `scale`, the larger in-plane extent, metres
    std::optional<std::string> time =
        {};                           ///< the column of seconds; `t_s` if neither this nor `rate` is given
    std::optional<double> rate = {};  ///< rows per second, for a table without times
};

/// The motion of a recording, in device metres, one position per tick from its first row's time to its last
/// one's, linear between rows. A single column moves along Z about the recording's own zero. Three columns
/// are turned so that the direction of least variance lies along Z (see `principal_rotation`) and centred in
/// their bounding box. Refuses (ErrorKind::input, with file, line and column) values that are not finite,
/// times that do not increase, fewer than two rows, more than an hour, and motions of more than 10 m.
Result<std::vector<glm::dvec3>> read_motion(const std::string& file, const MotionSettings& settings);

}  // namespace touchable
