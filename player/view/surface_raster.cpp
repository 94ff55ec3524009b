#include "player/view/surface_raster.hpp"

#include <cstddef>
#include <type_traits>

#include "engine/frame/surface_frame.hpp"
#include "player/view/view_rows.hpp"
#include "shaders/raster.h"
#include "shaders/raster.spv.h"
#include "shaders/raster_large.spv.h"
#include "shaders/tile_lists.h"
#include "shaders/view_resolve.frag.spv.h"
#include "shaders/view_resolve.h"
#include "shaders/view_screen.vert.spv.h"

namespace touchable {

static_assert(RASTER_TILE == TileGrid::cells);
static_assert(std::is_trivially_copyable_v<RasterPush> && sizeof(RasterPush) == 96);

Result<SurfaceRaster> SurfaceRaster::create(const GpuDevice& device) {
    if (!device.facts().int64_atomics)
        return Error{ErrorKind::gpu,
                     device.facts().name +
                         " has no 64-bit atomics, which --painter raster needs; mesh and cpu do not"};
    SurfaceRaster made;
    const auto storage = GpuBindingKind::storage_buffer, texels = GpuBindingKind::uniform_texels;
    auto raster = GpuProgram::create(
        device, "raster", raster_spv,
        {sizeof(RasterPush), {texels, texels, storage, storage, storage}, {RASTER_LANES, 1, 1}});
    if (!raster.ok()) return raster.error();
    made.raster_ = std::move(*raster);
    auto large = GpuProgram::create(
        device, "raster_large", raster_large_spv,
        {sizeof(RasterPush), {texels, texels, storage, storage}, {RASTER_LARGE_LANES, 1, 1}});
    if (!large.ok()) return large.error();
    made.large_ = std::move(*large);
    if (!device.facts().draws_triangles) return made;
    GraphicsLook look;
    look.vertex = view_screen_vert_spv;
    look.fragment = view_resolve_frag_spv;
    look.push_bytes = sizeof(ResolvePush);
    look.bindings.assign(2, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);
    look.depth = DrawDepth::replaced;
    auto resolve = GraphicsProgram::create(device, "resolve", look);
    if (!resolve.ok()) return resolve.error();
    made.resolve_ = std::move(*resolve);
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
    push.large_capacity = push.width * push.height;

    commands.fill(pixels, 0, 0, std::size_t{8} * push.picture_pitch * push.picture_height);
    // No groups yet in x, one in y and z, no cells.
    commands.fill(large, 0, 0, 4);
    commands.fill(large, 1, 4, 8);
    commands.fill(large, 0, 12, 4);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    const auto q = GpuBinding::words(lattice.q), colours = GpuBinding::words(lattice.colours);
    commands.dispatch_indirect(raster_, push, {q, colours, pixels, large, lattice.tiles}, lattice.tiles,
                               offsetof(TileListsHeader, groups_x));
    commands.barrier(GpuStage::compute, GpuStage::indirect);
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.dispatch_indirect(large_, push, {q, colours, pixels, large}, large);
}

int SurfaceRaster::resolve_pitch(int width) {
    return (width + RESOLVE_STEP - 1) / RESOLVE_STEP * RESOLVE_STEP;
}

void SurfaceRaster::record_resolve(GpuCommands& commands, const GpuBuffer& pixels, int pitch,
                                   const GpuBuffer& background) const {
    const ResolvePush push{static_cast<std::uint32_t>(pitch / RESOLVE_STEP)};
    resolve_.bind(commands, push, {pixels, background});
    vkCmdDraw(commands.handle(), 3, 1, 0, 0);
}

}  // namespace touchable
