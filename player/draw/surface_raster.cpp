#include "player/draw/surface_raster.hpp"

#include <cstddef>
#include <type_traits>

#include "engine/base/try.hpp"
#include "engine/scene/surface_frame.hpp"
#include "player/draw/view_rows.hpp"
#include "shaders/raster.h"
#include "shaders/raster.spv.h"
#include "shaders/raster_large.spv.h"
#include "shaders/resolve.h"
#include "shaders/resolve.spv.h"
#include "shaders/tile_lists.h"

namespace touchable {

static_assert(RASTER_TILE == TileGrid::cells);
static_assert(std::is_trivially_copyable_v<RasterPush> && sizeof(RasterPush) == 96);

Result<SurfaceRaster> SurfaceRaster::create(const GpuDevice& device) {
    if (!device.facts().int64_atomics)
        return Error{ErrorKind::gpu,
                     device.facts().name +
                         " has no 64-bit atomics, which the painter raster needs; mesh and cpu do not",
                     {{Setting::painter, "mesh"}}};
    SurfaceRaster made;
    const auto storage = GpuBindingKind::storage_buffer, texels = GpuBindingKind::uniform_texels;
    TRY_ASSIGN(auto raster, GpuProgram::create(device, "raster", raster_spv,
                                               {sizeof(RasterPush),
                                                {texels, texels, storage, storage, storage, storage},
                                                {RASTER_LANES, 1, 1}}));
    made.raster_ = std::move(raster);
    TRY_ASSIGN(auto large, GpuProgram::create(device, "raster_large", raster_large_spv,
                                              {sizeof(RasterPush),
                                               {texels, texels, storage, storage, storage},
                                               {RASTER_LARGE_LANES, 1, 1}}));
    made.large_ = std::move(large);
    TRY_ASSIGN(auto resolve,
               GpuProgram::create(
                   device, "resolve", resolve_spv,
                   {sizeof(ResolvePush), {texels, storage, storage, storage}, {RESOLVE_LANES, 1, 1}}));
    made.resolve_ = std::move(resolve);
    made.on_cpu_ = device.facts().kind == GpuKind::software;
    return made;
}

std::size_t SurfaceRaster::large_bytes(int width, int height) {
    return 4 * (RASTER_LARGE_HEADER + static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

void SurfaceRaster::record(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera,
                           const GpuBuffer& pixels, int pitch, const GpuBuffer& large) const {
    RasterPush push{};
    push.rows = rows_of(camera);
    push.width = static_cast<std::uint32_t>(lattice.width);
    push.height = static_cast<std::uint32_t>(lattice.height);
    push.pitch = static_cast<std::uint32_t>(lattice.pitch);
    push.tiles_x = static_cast<std::uint32_t>(TileGrid::of(lattice.width, lattice.height).tiles_x);
    push.picture_width = static_cast<std::uint32_t>(camera.width);
    push.picture_height = static_cast<std::uint32_t>(camera.height);
    push.picture_pitch = static_cast<std::uint32_t>(pitch);
    push.is_turned = is_own_view(camera) ? 0 : 1;

    commands.fill(pixels, 0, 0, std::size_t{8} * push.picture_pitch * push.picture_height);
    // No groups yet in x, one in y and z, no cells.
    commands.fill(large, 0, 0, 4);
    commands.fill(large, 1, 4, 8);
    commands.fill(large, 0, 12, 4);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    const auto q = GpuBinding::words(lattice.q), colours = GpuBinding::words(lattice.colours);
    const GpuBuffer& edges = push.is_turned != 0 ? lattice.edges : lattice.q;
    commands.dispatch_indirect(raster_, push, {q, colours, pixels, large, edges, lattice.tiles},
                               lattice.tiles, offsetof(TileListsHeader, groups_x));
    commands.barrier(GpuStage::compute, GpuStage::indirect);
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.dispatch_indirect(large_, push, {q, colours, pixels, large, edges}, large);
}

int SurfaceRaster::resolve_pitch(int width) {
    return (width + RESOLVE_STEP - 1) / RESOLVE_STEP * RESOLVE_STEP;
}

void SurfaceRaster::record_resolve(GpuCommands& commands, const ViewCamera& camera, const GpuBuffer& pixels,
                                   const GpuBuffer& background, const GpuBuffer& colours,
                                   const GpuBuffer& z) const {
    ResolvePush push{};
    push.steps = static_cast<std::uint32_t>(resolve_pitch(camera.width) / RESOLVE_STEP);
    push.height = static_cast<std::uint32_t>(camera.height);
    // Few lanes that march whole rows on a CPU, many with a step each elsewhere.
    push.segments = on_cpu_ ? 1 : push.steps;
    push.segment_steps = on_cpu_ ? push.steps : 1;
    commands.dispatch(resolve_, push, {pixels, background, colours, z},
                      {groups_for(push.height * push.segments, RESOLVE_LANES)});
}

}  // namespace touchable
