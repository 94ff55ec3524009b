#pragma once

#include <glm/matrix.hpp>

#include "player/draw/view_camera.hpp"
#include "shaders/view_project.h"

namespace touchable {

/// clip_from_lattice as the shared header wants it.
inline ViewRows rows_of(const ViewCamera& camera) {
    const glm::dmat4 rows = glm::transpose(camera.clip_from_lattice);
    return {glm::vec4(rows[0]), glm::vec4(rows[1]), glm::vec4(rows[2]), glm::vec4(rows[3])};
}

/// Whether a view is from where the clip's camera was, in its direction: from there a vertex is seen in the
/// same place whatever its depth.
inline bool is_own_view(const ViewCamera& camera) {
    const auto [x, y, z, w] = rows_of(camera);
    const bool upright = x.y == 0 && x.w == 0 && y.x == 0 && y.w == 0 && x.x > 0 && y.y > 0;
    return upright && z.x == 0 && z.y == 0 && z.z == 0 && w.x == 0 && w.y == 0 && w.z == 1 && w.w == 0;
}

}  // namespace touchable
