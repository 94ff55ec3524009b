#pragma once

#include <glm/matrix.hpp>

#include "player/view/view_camera.hpp"
#include "shaders/view_project.h"

namespace touchable {

/// clip_from_lattice as the shared header wants it.
inline ViewRows rows_of(const ViewCamera& camera) {
    const glm::dmat4 rows = glm::transpose(camera.clip_from_lattice);
    return {glm::vec4(rows[0]), glm::vec4(rows[1]), glm::vec4(rows[2]), glm::vec4(rows[3])};
}

}  // namespace touchable
