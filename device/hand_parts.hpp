// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of hands: their view of the surface under them, and recorded motions.

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "device/hand.hpp"

namespace touchable {

// ---- The ground

/// A rectangle of the picture, pixels, edges included.
struct HandArea {
    glm::dvec2 least;
    glm::dvec2 greatest;

    bool contains(const glm::dvec2& p) const {
        return p.x >= least.x && p.x <= greatest.x && p.y >= least.y && p.y <= greatest.y;
    }
};

/// The middle of a picture, `fraction` (0..1] of its width and height.
HandArea middle_of(const SurfaceProbe& probe, double fraction);

struct SurfacePoint {
    glm::dvec2 pixel;
    double depth;  ///< planar, scene units, > 0
};

/// The surface at `pixel`, or, walking outward in square rings of whole pixels inside `box`, at the nearest
/// pixel of the first ring that has any. Nothing if the box shows no surface at all, or work is to stop.
std::optional<SurfacePoint> nearest_surface(const SurfaceProbe& probe, const glm::dvec2& pixel,
                                            const HandArea& box);

/// Planar depth of the device's centre, scene units, for a hand that has not seen a surface yet. If the
/// centre is not in front of the camera: 0.16 m of device space.
double device_depth(const Workspace& workspace);

/// Planar depth, scene units, of nearest_surface's point; device_depth's if there is none.
double start_depth(const SurfaceProbe& probe, const glm::dvec2& pixel, const HandArea& box,
                   const Workspace& workspace);

/// The ground around a gliding finger.
struct LocalRelief {
    enum class Kind {
        smooth,
        rough,  ///< it rises steeply within reach, as at a step: a proxy there may be held
        broken  ///< the surface ends within reach, at a cliff up or down or at a hole
    };
    Kind kind;
    double highest;  ///< least planar depth within reach, scene units
};

/// Relief at `pixel` of the box, where a finger assumes the surface at planar depth `depth`, so that it can
/// be lifted over a step before it gets there. Looks `reach` device metres, > 0, to every side, and only at
/// pixels of `box`, which no finger leaves.
LocalRelief local_relief(const SurfaceProbe& probe, const glm::dvec2& pixel, double depth, double reach,
                         double metres_per_scene_unit, const HandArea& box);

/// Device metres that one pixel spans at `depth`, across and down.
glm::dvec2 pixel_size(const SurfaceProbe& probe, const glm::dvec2& pixel, double depth,
                      double metres_per_scene_unit);

// ---- Recorded motions

/// The rotation (proper: determinant +1) that lays the direction of greatest variance of `points` along X,
/// the next along Y and that of least variance along Z. The largest component (the first of equals) of each
/// of the first two directions is positive before the rotation, which fixes the signs. Computed by Jacobi's
/// method, with + - * / sqrt alone.
glm::dmat3 principal_rotation(std::span<const glm::dvec3> points);

/// The columns of a table that form a motion, and their unit.
struct MotionSettings {
    /// One column: how far the motion goes in, along -Z. Three columns: a position, in any axes.
    std::vector<std::string> columns;
    /// Device metres per unit of the columns, not 0; a negative scale reverses the motion.
    double scale = 1;
    /// Three columns: instead of `scale`, the motion's larger in-plane extent, device metres.
    std::optional<double> extent = {};
    /// The column of seconds; `t_s` if neither this nor `rate` is given.
    std::optional<std::string> time = {};
    /// Three columns: a position in the scene's own units and axes, used unchanged, without `scale` and
    /// `extent`.
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

/// Makes a hand from "FILE[:key=value,...]" (the keys are in docs/touch.md). A file's name may hold ':': the
/// options begin after the last one that is followed by a '='. Refuses impossible options (ErrorKind::usage)
/// and files that cannot be used (ErrorKind::input, with line and column).
Result<std::unique_ptr<Hand>> make_recorded_hand(std::string_view description, int fingers,
                                                 const Workspace& workspace, const SurfaceProbe& probe);

}  // namespace touchable
