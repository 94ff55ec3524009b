#include "player/view/view_surface.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "player/view/surface_light.hpp"
#include "shaders/cut_rule.h"

namespace touchable {
namespace {

/// Least and greatest L of a tile's vertices; L grows with the distance from the principal point.
struct RayLengths {
    double least, greatest;
};
RayLengths ray_lengths(const Camera& camera, int x0, int x1, int y0, int y1) {
    const double x = std::clamp<double>(camera.cx, x0, x1), y = std::clamp<double>(camera.cy, y0, y1);
    double greatest = 0;
    for (const int cx : {x0, x1})
        for (const int cy : {y0, y1}) greatest = std::max(greatest, camera.ray_length(cx, cy));
    return {camera.ray_length(x, y), greatest};
}

}  // namespace

std::vector<float> q_of(const HeightField& field) {
    const Scene& scene = field.scene();
    std::vector<float> q;
    q.reserve(static_cast<std::size_t>(field.width()) * static_cast<std::size_t>(field.height()));
    for (int y = 0; y < field.height(); ++y)
        for (int x = 0; x < field.width(); ++x) {
            const FieldVertex vertex = field.vertex(x, y);
            const double depth = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
            q.push_back(vertex.valid ? static_cast<float>(1.0 / depth) : 0.0F);
        }
    return q;
}

ViewTiles classify_tiles(const HeightField& field) {
    const Scene& scene = field.scene();
    const TileGrid grid = field.tiles();
    ViewTiles tiles;
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) {
            const auto depths = field.depths(tx, ty);
            if (!(depths.nearest <= depths.farthest)) continue;
            const int x0 = tx * TileGrid::cells, y0 = ty * TileGrid::cells;
            const int x1 = std::min(x0 + TileGrid::cells, scene.width - 1);
            const int y1 = std::min(y0 + TileGrid::cells, scene.height - 1);
            RayLengths lengths{1, 1};
            if (scene.depth.semantics == DepthSemantics::range)
                lengths = ray_lengths(scene.camera, x0, x1, y0, y1);
            const auto greatest_q = static_cast<float>(lengths.greatest / depths.nearest);
            const auto least_q = static_cast<float>(lengths.least / depths.farthest);
            // A hair inside the rule: these q are rounded, and so are those of the pixels.
            const bool whole =
                !depths.any_invalid && !triangle_is_cut(greatest_q * 1.000001F, least_q, least_q);
            const auto tile = static_cast<std::uint32_t>(ty * grid.tiles_x + tx);
            (whole ? tiles.whole : tiles.mixed).push_back(tile);
        }
    return tiles;
}

ViewSurface make_view_surface(const HeightField& field, const PlaneView& colour) {
    return make_view_surface(field, q_of(field), colour);
}

ViewSurface make_view_surface(const HeightField& field, std::vector<float> q, const PlaneView& colour) {
    ViewSurface surface;
    surface.width = field.width();
    surface.height = field.height();
    surface.q = std::move(q);
    surface.tiles = classify_tiles(field);
    surface.colours = lit_colours(field.scene().camera, surface, colour);
    return surface;
}

glm::dvec3 middle_of(const HeightField& field) {
    std::array<std::vector<double>, 3> coordinates;
    // A hundred thousand pixels tell the middle as well as millions.
    const int step = 1 + std::max(field.width(), field.height()) / 512;
    const Scene& scene = field.scene();
    for (int y = 0; y < field.height(); y += step)
        for (int x = 0; x < field.width(); x += step) {
            const FieldVertex vertex = field.vertex(x, y);
            if (!vertex.valid || vertex.depth >= 0.999 * scene.depth.far) continue;
            const double depth = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
            const glm::dvec3 point = unproject(scene.camera, x, y, depth);
            for (int axis = 0; axis < 3; ++axis)
                coordinates[static_cast<std::size_t>(axis)].push_back(point[axis]);
        }
    if (coordinates[0].empty()) return {0, 0, -scene.depth.far};
    glm::dvec3 middle;
    for (int axis = 0; axis < 3; ++axis) {
        auto& values = coordinates[static_cast<std::size_t>(axis)];
        const auto at = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
        std::nth_element(values.begin(), at, values.end());
        middle[axis] = *at;
    }
    return middle;
}

}  // namespace touchable
