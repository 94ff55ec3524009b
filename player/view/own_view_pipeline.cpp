#include "player/view/own_view_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "player/view/light_picture.hpp"
#include "player/view/view_rows.hpp"
#include "shaders/raster.h"
#include "shaders/view_own.frag.spv.h"
#include "shaders/view_own.h"
#include "shaders/view_screen.vert.spv.h"

namespace touchable {
namespace {

static_assert(sizeof(OwnPush) == 12 && sizeof(OwnPlace) == 16);

/// Of pixels along one side of the picture, among `vertices` that lie where `subpixels_of(n)` says,
/// ascending.
template <class SubpixelsOf>
void find_places(int vertices, SubpixelsOf subpixels_of, std::span<OwnPlace> places) {
    constexpr int half_pixel = VIEW_SUBPIXELS / 2;
    const int pixels = static_cast<int>(places.size());
    std::fill(places.begin(), places.end(), OwnPlace{OWN_NOWHERE, 0, 0, 0});
    int from = subpixels_of(0);
    for (int n = 0; n + 1 < vertices; ++n) {
        const int to = subpixels_of(n + 1);
        // A pixel whose centre is on the cell's first side is the cell's.
        const int first = std::max((from + half_pixel - 1) >> 8, 0);
        const int end = std::min((to + half_pixel - 1) >> 8, pixels);
        for (int p = first; p < end; ++p)
            places[static_cast<std::size_t>(p)] = {
                static_cast<std::uint32_t>(n),
                static_cast<float>(p * VIEW_SUBPIXELS + half_pixel - from) / static_cast<float>(to - from), 0,
                0};
        from = to;
    }
}

}  // namespace

Result<OwnViewPipeline> OwnViewPipeline::create(std::shared_ptr<GpuDevice> device) {
    GraphicsLook look;
    look.vertex = view_screen_vert_spv;
    look.fragment = view_own_frag_spv;
    look.push_bytes = sizeof(OwnPush);
    look.bindings.assign(3, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);
    look.depth = DrawDepth::replaced;
    auto program = GraphicsProgram::create(*device, "own view", look);
    if (!program.ok()) return program.error();
    OwnViewPipeline made(std::move(device));
    made.program_ = std::move(*program);
    return made;
}

bool OwnViewPipeline::draws(const ViewCamera& camera) {
    const auto [x, y, z, w] = rows_of(camera);
    const bool upright = x.y == 0 && x.w == 0 && y.x == 0 && y.w == 0 && x.x > 0 && y.y > 0;
    const bool level = z.x == 0 && z.y == 0 && z.z == 0 && w.x == 0 && w.y == 0 && w.z == 1 && w.w == 0;
    // Clip space is two units wide and high.
    constexpr float largest = 2.0F * RASTER_LARGE_CELL / VIEW_SUBPIXELS;
    return upright && level && x.x * static_cast<float>(camera.width) < largest &&
           y.y * static_cast<float>(camera.height) < largest;
}

Result<void> OwnViewPipeline::draw(GpuCommands& commands, const GpuLattice& lattice,
                                   const ViewCamera& camera) {
    const auto columns = static_cast<std::size_t>(camera.width),
               lines = static_cast<std::size_t>(camera.height);
    const auto buffer = uploads_.take("own view places", (columns + lines) * sizeof(OwnPlace));
    if (!buffer.ok()) return buffer.error();
    const ViewRows rows = rows_of(camera);
    const std::span<OwnPlace> places = buffer->mapped<OwnPlace>();
    find_places(
        lattice.width,
        [&](int i) {
            return view_subpixels(view_row(rows.x, static_cast<float>(i), 0, 0),
                                  static_cast<float>(camera.width));
        },
        places.first(columns));
    find_places(
        lattice.height,
        [&](int j) {
            return view_subpixels(view_row(rows.y, 0, static_cast<float>(j), 0),
                                  static_cast<float>(camera.height));
        },
        places.subspan(columns, lines));
    for (int y = 0; y < camera.height; ++y)
        places[columns + static_cast<std::size_t>(y)].background = background_colour(y, camera.height);

    const OwnPush push{static_cast<std::uint32_t>(lattice.pitch), static_cast<std::uint32_t>(camera.width),
                       rows.z.w};
    program_.bind(commands, push,
                  {DrawBinding::words(lattice.q), DrawBinding::words(lattice.colours), *buffer});
    vkCmdDraw(commands.handle(), 3, 1, 0, 0);
    return {};
}

}  // namespace touchable
