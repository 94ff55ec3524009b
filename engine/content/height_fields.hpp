#pragma once

// The height fields' surfaces (docs/content.md).

#include "engine/content/families.hpp"

namespace touchable {

/// The three height fields: Z = -1000 + 1000 b(X/1000, Y/1000, t) in scene units (millimetres).
enum class Relief { bumps, rough, moving };

/// Surface over a world position: Z (scene units) and its first and second derivatives by X and Y (per unit).
struct ReliefPoint {
    double z, zx, zy, zxx, zxy, zyy;
};
ReliefPoint relief_at(Relief relief, double x, double y, double t);

}  // namespace touchable
