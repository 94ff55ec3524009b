#include "tests/view/shown.hpp"

#include <array>
#include <cstddef>
#include <utility>

#include "player/draw/cpu_painting.hpp"
#include "player/draw/drawn_surface.hpp"
#include "shaders/cut_rule.h"

namespace touchable::test {
namespace {

class PlainPainter {
public:
    PlainPainter(const ViewSurface& surface, const ViewCamera& camera)
        : surface_(surface), rows_(rows_of(camera)), is_turned_(!is_own_view(camera)) {
        planes_ = {camera.width, camera.height, {}, {}};
        const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        planes_.z.assign(pixels, 0.0F);
        planes_.colours.assign(pixels, 0);
        if (is_turned_)
            edges_.find(surface.q.data(), surface.width, surface.height, surface.width, CUT_RULE_RATIO,
                        surface.colours_are_values);
    }

    PicturePlanes paint() && {
        for (int y = 0; y + 1 < surface_.height; ++y)
            for (int x = 0; x + 1 < surface_.width; ++x) {
                paint_triangle({{{x, y}, {x + 1, y}, {x + 1, y + 1}}});
                paint_triangle({{{x, y}, {x + 1, y + 1}, {x, y + 1}}});
            }
        return std::move(planes_);
    }

private:
    void paint_triangle(const std::array<std::array<int, 2>, 3>& at) {
        std::array<float, 3> q;
        std::array<FillCorner, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [x, y] = at[k];
            const std::size_t index = surface_.index(x, y);
            q[k] = surface_.q[index];
            const PackedColour c = surface_.colours[index];
            const glm::vec3 colour(c & 255U, c >> 8 & 255U, c >> 16 & 255U);
            if (const SurfaceEdges::Vertex* edge = edges_.at(x, y); edge != nullptr)
                corners[k] = {view_clip(rows_, edge->at_x, edge->at_y, edge->q), colour * edge->light};
            else
                corners[k] = {view_clip(rows_, static_cast<float>(x), static_cast<float>(y), q[k]), colour};
        }
        if (is_turned_ ? triangle_is_cut(q[0], q[1], q[2]) : triangle_has_hole(q[0], q[1], q[2])) return;
        fill_triangle(corners, planes_.width, planes_.height,
                      [&](int x, int y, float z, const glm::vec3& colour) {
                          const std::size_t pixel = planes_.index(x, y);
                          const glm::uvec3 byte(colour + 0.5F);
                          const PackedColour packed = pack_colour(byte.r, byte.g, byte.b);
                          // Where two are equally near, the greater colour: no order of drawing decides.
                          float& nearest = planes_.z[pixel];
                          if (z < nearest || (z == nearest && packed <= planes_.colours[pixel])) return;
                          nearest = z;
                          planes_.colours[pixel] = packed;
                      });
    }

    const ViewSurface& surface_;
    const ViewRows rows_;
    const bool is_turned_;
    SurfaceEdges edges_{1};
    PicturePlanes planes_;
};

}  // namespace

PicturePlanes plain_picture(const ViewSurface& surface, const ViewCamera& camera) {
    return PlainPainter(surface, camera).paint();
}

}  // namespace touchable::test
