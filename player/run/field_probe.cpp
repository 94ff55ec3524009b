#include "player/run/field_probe.hpp"

#include <algorithm>

#include "haptics_cpu/surface_lattice.hpp"
#include "haptics_cpu/world_space.hpp"

namespace touchable {

std::optional<double> FieldProbe::depth_under(double x, double y) const {
    const double right = field_.width() - 1, bottom = field_.height() - 1;
    if (!(x >= 0 && y >= 0 && x <= right && y <= bottom)) return std::nullopt;
    const Place at = face_under(x, y);
    // At the picture's last column and row the place is its cell's near edge; there is no cell beyond.
    for (const int di : {0, 1})
        for (const int dj : {0, 1}) {
            if ((di == 1 && at.a == 0) || (dj == 1 && at.b == 0)) continue;
            if (!field_.vertex(at.i + di, at.j + dj).valid) return std::nullopt;
        }
    return 1.0 / surface_w(WorldSpace(field_), at);
}

glm::dvec3 FieldProbe::unproject(double x, double y, double planar_depth) const {
    return touchable::unproject(field_.scene().camera, x, y, planar_depth);
}

glm::dvec3 FieldProbe::project(const glm::dvec3& point) const {
    const auto image = touchable::project(field_.scene().camera, point);
    return image ? glm::dvec3{image->x, image->y, image->planar_depth} : glm::dvec3(0.0);
}

}  // namespace touchable
