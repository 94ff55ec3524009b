#include "engine/surface/mesh.hpp"

#include <limits>

namespace touchable {
namespace {

constexpr std::uint32_t no_vertex = std::numeric_limits<std::uint32_t>::max();

/// Vertex number of each pixel of a row, `no_vertex` where it is invalid.
void add_row(const SurfaceFrame& frame, const Scene& scene, int y, Mesh& mesh,
             std::vector<std::uint32_t>& row) {
    const double height_per_code =
        largest_height(scene.height_coding, scene.depth) / scene.height_coding.code_max;
    for (int x = 0; x < frame.width; ++x) {
        const DepthSample sample = frame.vertices->at(x, y);
        std::uint32_t& vertex = row[static_cast<std::size_t>(x)];
        if (!sample.valid) {
            vertex = no_vertex;
            continue;
        }
        vertex = static_cast<std::uint32_t>(mesh.positions.size());
        const auto pixel = frame.index(x, y);
        const double depth =
            frame.heights.empty() ? sample.depth : sample.depth - height_per_code * frame.heights[pixel];
        const double planar = planar_depth(scene.camera, frame.coding.semantics, x, y, depth);
        mesh.positions.push_back(unproject(scene.camera, x, y, planar));
        mesh.pixels.push_back(static_cast<std::uint32_t>(pixel));
    }
}

void add_cells(const std::vector<std::uint32_t>& upper, const std::vector<std::uint32_t>& lower, Mesh& mesh) {
    for (std::size_t x = 0; x + 1 < upper.size(); ++x) {
        const std::uint32_t top_left = upper[x], top_right = upper[x + 1];
        const std::uint32_t bottom_left = lower[x], bottom_right = lower[x + 1];
        if (top_left == no_vertex || top_right == no_vertex || bottom_left == no_vertex ||
            bottom_right == no_vertex)
            continue;
        mesh.triangles.push_back({top_left, bottom_left, bottom_right});
        mesh.triangles.push_back({top_left, bottom_right, top_right});
    }
}

}  // namespace

Mesh make_mesh(const SurfaceFrame& frame, const Scene& scene) {
    Mesh mesh;
    mesh.width = frame.width;
    mesh.height = frame.height;
    std::vector<std::uint32_t> upper(static_cast<std::size_t>(frame.width)), lower(upper);
    for (int y = 0; y < frame.height; ++y) {
        add_row(frame, scene, y, mesh, lower);
        if (y > 0) add_cells(upper, lower, mesh);
        upper.swap(lower);
    }
    return mesh;
}

}  // namespace touchable
