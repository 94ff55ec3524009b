// SPDX-License-Identifier: Apache-2.0
#include "tests/view/shown.hpp"

#include "player/draw/light_picture.hpp"

#include <array>
#include <cstddef>
#include <utility>

#include "player/draw/cpu_painting.hpp"
#include "player/view/drawn_surface.hpp"
#include "shaders/cut_rule.h"
#include "shaders/gap_fill.h"

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
            edges_.find(edge_lattice(surface.q.data(), surface.width, surface.height, surface.width, 1,
                                     surface.focal_length));
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
            q[k] = is_turned_ ? edges_.eroded_q()[index] : surface_.q[index];
            if (!is_turned_ && surface_.fills_gaps && q[k] == 0) q[k] = HOLE_Q;
            const PackedColour c = surface_.colours[index];
            const glm::vec3 colour(c & 255U, c >> 8 & 255U, c >> 16 & 255U);
            if (const SurfaceEdges::Vertex* edge = edges_.at(x, y); edge != nullptr)
                corners[k] = {view_clip(rows_, edge->at_x, edge->at_y, edge->q), colour};
            else
                corners[k] = {view_clip(rows_, static_cast<float>(x), static_cast<float>(y), std::fabs(q[k])),
                              colour};
        }
        float scale_of_z = 1;
        if (is_turned_ ? triangle_is_cut(q[0], q[1], q[2]) : triangle_has_hole(q[0], q[1], q[2])) {
            const bool is_gap = is_turned_ && surface_.fills_gaps && q[0] * q[1] * q[2] != 0;
            if (!is_gap) return;
            scale_of_z = GAP_Z;
            const MappedLattice lattice{edges_.eroded_q(), surface_.colours.data(), surface_.width,
                                        surface_.height};
            const glm::vec3 colour =
                gap_fill(lattice, {at[0][0], at[0][1]}, {surface_.width, surface_.height});
            for (FillCorner& corner : corners) corner.value = colour;
        }
        fill_triangle(corners, planes_.width, planes_.height,
                      [&](int x, int y, float z_before, const glm::vec3& colour) {
                          const float z = z_before * scale_of_z;
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

PicturePlanes before_background(PicturePlanes planes) {
    for (int y = 0; y < planes.height; ++y)
        for (int x = 0; x < planes.width; ++x)
            if (const std::size_t at = planes.index(x, y); !(planes.z[at] > 0))
                planes.colours[at] = background_colour(y, planes.height);
    return planes;
}

}  // namespace touchable::test
