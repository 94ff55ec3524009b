#include <algorithm>
#include <array>
#include <initializer_list>

#include "player/view/cpu_lattice.hpp"
#include "player/view/surface_edges.hpp"
#include "player/view/surface_painter.hpp"
#include "player/view/triangle_fill.hpp"
#include "player/view/view_rows.hpp"
#include "shaders/cut_rule.h"

namespace touchable {
namespace {

class CpuPainter final : public SurfacePainter {
public:
    std::string_view name() const override { return "cpu"; }

    Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair,
                                   const PlaneView& colour) override {
        return lattices_.surface_of(field, pair, colour);
    }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        PicturePlanes planes{camera.width, camera.height, {}, {}};
        const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        planes.z.assign(pixels, 0.0F);
        planes.colours.assign(pixels, 0);
        const TileGrid grid = TileGrid::of(surface.width, surface.height);
        const ViewRows rows = rows_of(camera);
        edges_.clear();
        is_turned_ = !is_own_view(camera);
        if (is_turned_)
            edges_.find(surface.q.data(), surface.width, surface.height, surface.width, CUT_RULE_RATIO,
                        surface.colours_are_values);
        for (const auto* tiles : {&surface.tiles.whole, &surface.tiles.mixed})
            for (const std::uint32_t tile : *tiles)
                paint_tile(surface, rows, static_cast<int>(tile) % grid.tiles_x,
                           static_cast<int>(tile) / grid.tiles_x, planes);
        return planes;
    }

private:
    void paint_tile(const ViewSurface& surface, const ViewRows& rows, int tx, int ty, PicturePlanes& planes) {
        const int x0 = tx * TileGrid::cells, y0 = ty * TileGrid::cells;
        for (int y = y0; y < std::min(y0 + TileGrid::cells, surface.height - 1); ++y)
            for (int x = x0; x < std::min(x0 + TileGrid::cells, surface.width - 1); ++x) {
                paint_triangle(surface, rows, {{{x, y}, {x + 1, y}, {x + 1, y + 1}}}, planes);
                paint_triangle(surface, rows, {{{x, y}, {x + 1, y + 1}, {x, y + 1}}}, planes);
            }
    }

    void paint_triangle(const ViewSurface& surface, const ViewRows& rows,
                        const std::array<std::array<int, 2>, 3>& at, PicturePlanes& planes) {
        std::array<float, 3> q;
        std::array<FillCorner, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [x, y] = at[k];
            const std::size_t index = surface.index(x, y);
            q[k] = surface.q[index];
            const PackedColour c = surface.colours[index];
            const glm::vec3 colour(c & 255U, c >> 8 & 255U, c >> 16 & 255U);
            if (const SurfaceEdges::Vertex* edge = edges_.at(x, y); edge != nullptr)
                corners[k] = {view_clip(rows, edge->at_x, edge->at_y, edge->q), colour * edge->light};
            else
                corners[k] = {view_clip(rows, static_cast<float>(x), static_cast<float>(y), q[k]), colour};
        }
        if (is_turned_ ? triangle_is_cut(q[0], q[1], q[2]) : triangle_has_hole(q[0], q[1], q[2])) return;
        fill_triangle(
            corners, planes.width, planes.height, [&](int x, int y, float z, const glm::vec3& colour) {
                const std::size_t pixel = planes.index(x, y);
                const glm::uvec3 byte(colour + 0.5F);
                const PackedColour packed = pack_colour(byte.r, byte.g, byte.b);
                // Where two are equally near, the greater colour: no order of drawing decides.
                if (z < planes.z[pixel] || (z == planes.z[pixel] && packed <= planes.colours[pixel])) return;
                planes.z[pixel] = z;
                planes.colours[pixel] = packed;
            });
    }

    CpuLattices lattices_{CpuLattices::usual_threads()};
    SurfaceEdges edges_{1};  // of what is painted
    bool is_turned_ = false;
};

}  // namespace

std::unique_ptr<SurfacePainter> make_cpu_painter() {
    return std::make_unique<CpuPainter>();
}

}  // namespace touchable
