#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// Which of a table's columns are a motion, and in what unit.
struct MotionSettings {
    /// One column: how far the motion goes in, along -Z. Three columns: a position, in any axes.
    std::vector<std::string> columns;
    /// Device metres per unit of the columns, not 0; a negative one turns the motion round.
    double scale = 1;
    /// Three columns: instead of `scale`, the motion's larger in-plane extent, device metres.
    std::optional<double> extent = {};
    /// The column of seconds; `t_s` if neither this nor `rate` is given.
    std::optional<std::string> time = {};
    /// Three columns: a place of the scene itself, in scene units and its axes, as it is; `scale` and
    /// `extent` have no say.
    bool in_scene = false;
    /// Rows per second, for a table without times.
    std::optional<double> rate = {};
};

/// The motion of a recording, in device metres, one position per tick from its first row's time to its last
/// one's, linear between rows. A single column moves along Z about the recording's own zero. Three columns
/// are turned so that the direction of least variance lies along Z (see `principal_rotation`) and centred in
/// their bounding box. Refuses (ErrorKind::input, with file, line and column) values that are not finite,
/// times that do not increase, fewer than two rows, more than an hour, and motions of more than 10 m.
Result<std::vector<glm::dvec3>> read_motion(const std::string& file, const MotionSettings& settings);

}  // namespace touchable
