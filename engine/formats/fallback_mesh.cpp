#include "engine/formats/fallback_mesh.hpp"

#include <algorithm>
#include <limits>
#include <optional>

namespace touchable {
namespace {

constexpr int most_cells = 96;
/// Of the distance between two vertices across the line of sight, at the nearer one: what is steeper is taken
/// for an edge.
constexpr double steepest = 4;

/// Pixels from 0 to the last, evenly.
std::vector<int> grid(int pixels, int longer_side) {
    const int cells = std::clamp(most_cells * pixels / longer_side, 1, std::max(1, pixels - 1));
    std::vector<int> places;
    for (int k = 0; k <= cells; ++k) places.push_back(k * (pixels - 1) / cells);
    return places;
}

class MeshOfFrame {
public:
    MeshOfFrame(const RawFrame& frame, const Scene& scene) : depth_(frame.depth), scene_(scene) {}
    FallbackMesh made();

private:
    using Corner = std::array<std::uint32_t, 3>;

    void add_vertex(int x, int y);
    void add_triangle(Corner corners);
    bool is_edge(std::uint32_t a, std::uint32_t b) const;
    std::uint32_t add_behind(std::uint32_t vertex, std::uint32_t deeper);
    void add_rectangle();
    /// Along -Z, scene units; nothing in a hole.
    std::optional<double> planar(int x, int y) const;
    void add_position(int x, int y, double planar);

    const PlaneView& depth_;
    const Scene& scene_;
    FallbackMesh mesh_;
    std::vector<bool> is_hole_;
};

std::optional<double> MeshOfFrame::planar(int x, int y) const {
    const DepthCoding& coding = scene_.depth;
    if (coding.kind == DepthCodingKind::hue) return std::nullopt;
    const int code = depth_.sample(x, y);
    if (!coding.is_valid(static_cast<std::uint16_t>(code))) return std::nullopt;
    return planar_depth(scene_.camera, coding.semantics, x, y,
                        coding.depth(static_cast<std::uint16_t>(code)));
}

void MeshOfFrame::add_position(int x, int y, double planar) {
    const glm::dvec3 point = scene_.metres_per_unit * unproject(scene_.camera, x, y, planar);
    mesh_.positions.push_back(
        {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)});
    mesh_.texture_places.push_back(
        {static_cast<float>((x + 0.5) / scene_.width), static_cast<float>((y + 0.5) / scene_.height)});
}

void MeshOfFrame::add_vertex(int x, int y) {
    const auto there = planar(x, y);
    is_hole_.push_back(!there);
    add_position(x, y, there.value_or(scene_.depth.far));
}

/// Whether one lies far behind the other.
bool MeshOfFrame::is_edge(std::uint32_t a, std::uint32_t b) const {
    const auto &from = mesh_.positions[a], &to = mesh_.positions[b];
    const double nearer = std::min(-from[2], -to[2]), deeper = to[2] - from[2];
    const double across_x = nearer * (to[0] / to[2] - from[0] / from[2]),
                 across_y = nearer * (to[1] / to[2] - from[1] / from[2]);
    return deeper * deeper > steepest * steepest * (across_x * across_x + across_y * across_y);
}

/// Another vertex where the camera sees this one, but as deep as that other.
std::uint32_t MeshOfFrame::add_behind(std::uint32_t vertex, std::uint32_t deeper) {
    std::array<float, 3> position = mesh_.positions[vertex];
    const float farther = mesh_.positions[deeper][2] / position[2];
    for (float& each : position) each *= farther;
    mesh_.positions.push_back(position);
    mesh_.texture_places.push_back(std::array(mesh_.texture_places[vertex]));
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

/// Where no corner is in a hole. Corners that lie far before another are as deep as that, so that from the
/// clip's own camera nothing is missing between two surfaces.
void MeshOfFrame::add_triangle(Corner corners) {
    for (const std::uint32_t corner : corners)
        if (is_hole_[corner]) return;
    const std::uint32_t deepest = *std::min_element(
        corners.begin(), corners.end(),
        [this](std::uint32_t a, std::uint32_t b) { return mesh_.positions[a][2] < mesh_.positions[b][2]; });
    for (std::uint32_t& corner : corners)
        if (corner != deepest && is_edge(corner, deepest)) corner = add_behind(corner, deepest);
    mesh_.triangles.push_back(corners);
}

void MeshOfFrame::add_rectangle() {
    mesh_ = {};
    for (const int y : {0, scene_.height - 1})
        for (const int x : {0, scene_.width - 1}) add_position(x, y, scene_.depth.far);
    mesh_.triangles = {{0, 2, 3}, {0, 3, 1}};
}

FallbackMesh MeshOfFrame::made() {
    const int longer_side = std::max(scene_.width, scene_.height);
    const std::vector<int> columns = grid(scene_.width, longer_side), rows = grid(scene_.height, longer_side);
    for (const int y : rows)
        for (const int x : columns) add_vertex(x, y);
    const auto width = static_cast<std::uint32_t>(columns.size());
    for (std::uint32_t row = 0; row + 1 < rows.size(); ++row)
        for (std::uint32_t column = 0; column + 1 < width; ++column) {
            const std::uint32_t top = row * width + column, bottom = top + width;
            add_triangle({top, bottom, bottom + 1});
            add_triangle({top, bottom + 1, top + 1});
        }
    if (mesh_.triangles.empty()) add_rectangle();
    return std::move(mesh_);
}

}  // namespace

FallbackMesh fallback_mesh(const RawFrame& frame, const Scene& scene) {
    return MeshOfFrame(frame, scene).made();
}

}  // namespace touchable
