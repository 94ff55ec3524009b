#include "player/draw/view_surface.hpp"

#include <algorithm>
#include <utility>

#include "player/draw/drawn_vertex.hpp"
#include "player/draw/surface_light.hpp"

namespace touchable {

std::vector<float> q_of(const HeightField& field) {
    const Scene& scene = field.scene();
    std::vector<float> q;
    q.reserve(static_cast<std::size_t>(field.width()) * static_cast<std::size_t>(field.height()));
    for (int y = 0; y < field.height(); ++y)
        for (int x = 0; x < field.width(); ++x) {
            const FieldVertex vertex = drawn_vertex(field, x, y);
            const double depth = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
            q.push_back(vertex.valid ? static_cast<float>(1.0 / depth) : 0.0F);
        }
    return q;
}

ViewSurface make_view_surface(const HeightField& field, std::vector<float> q, ViewTiles tiles,
                              const PlaneView& colour) {
    ViewSurface surface;
    surface.width = field.width();
    surface.height = field.height();
    surface.q = std::move(q);
    surface.tiles = std::move(tiles);
    surface.colours = lit_colours(field.scene().camera, surface, colour);
    return surface;
}

Subject subject_of(const HeightField& field) {
    Subject subject{{0, 0, -field.scene().depth.far}, {}};
    // A hundred thousand pixels tell the middle as well as millions.
    const int step = 1 + std::max(field.width(), field.height()) / 512;
    const Scene& scene = field.scene();
    for (int y = 0; y < field.height(); y += step)
        for (int x = 0; x < field.width(); x += step) {
            const FieldVertex vertex = drawn_vertex(field, x, y);
            if (!vertex.valid || vertex.depth >= 0.999 * scene.depth.far) continue;
            const double depth = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
            subject.points.push_back(unproject(scene.camera, x, y, depth));
        }
    if (subject.points.empty()) return subject;
    std::vector<double> values(subject.points.size());
    for (int axis = 0; axis < 3; ++axis) {
        std::transform(subject.points.begin(), subject.points.end(), values.begin(),
                       [axis](const glm::dvec3& point) { return point[axis]; });
        const auto at = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
        std::nth_element(values.begin(), at, values.end());
        subject.middle[axis] = *at;
    }
    return subject;
}

}  // namespace touchable
