#pragma once

#include <glm/vec3.hpp>

#include "engine/scene/scene.hpp"

namespace touchable::test {

enum class OnTable { table, ball, can, sponge, egg, coaster };

/// Where a pixel's ray meets the scene of engine/content/blender/scenes/table.py.
struct TableHit {
    double depth = 1e9;  ///< metres along the axis
    OnTable thing = OnTable::table;
    bool is_plain = true;  ///< not on a round edge, which has no formula here
};

TableHit table_hit(const Camera& camera, double x, double y);

}  // namespace touchable::test
