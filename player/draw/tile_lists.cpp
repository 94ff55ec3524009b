#include "player/draw/tile_lists.hpp"

#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine/base/try.hpp"
#include "player/draw/gpu_lattice.hpp"
#include "shaders/cut_tiles.spv.h"
#include "shaders/list_tiles.spv.h"
#include "shaders/tile_lists.h"

namespace touchable {
namespace {

constexpr std::size_t header_words = sizeof(TileListsHeader) / 4;
static_assert(CUT_TILES_CELLS == TileGrid::cells);
static_assert(offsetof(TileListsHeader, mixed_vertices) - offsetof(TileListsHeader, whole_indices) ==
                  sizeof(VkDrawIndexedIndirectCommand) &&
              sizeof(TileListsHeader) - offsetof(TileListsHeader, mixed_vertices) ==
                  sizeof(VkDrawIndirectCommand));

std::size_t tiles_in(int width, int height) {
    const TileGrid grid = TileGrid::of(width, height);
    return static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y);
}

}  // namespace

std::size_t TileLists::class_bytes(int width, int height) {
    return 4 * tiles_in(width, height);
}

std::size_t TileLists::list_bytes(int width, int height) {
    return 4 * (header_words + tiles_in(width, height));
}

Result<void> TileLists::record(GpuCommands& commands, const GpuLattice& lattice) {
    constexpr GpuBindingKind buffer = GpuBindingKind::storage_buffer, texels = GpuBindingKind::uniform_texels;
    if (!list_) {
        TRY_ASSIGN(auto cut,
                   GpuProgram::create(*device_, "cut_tiles", cut_tiles_spv,
                                      {sizeof(CutTilesPush), {texels, buffer}, {CUT_TILES_LANES, 1, 1}}));
        TRY_ASSIGN(auto list,
                   GpuProgram::create(*device_, "list_tiles", list_tiles_spv,
                                      {sizeof(CutTilesPush), {buffer, buffer}, {LIST_TILES_LANES, 1, 1}}));
        cut_ = std::move(cut);
        list_ = std::move(list);
    }
    CutTilesPush push{};
    push.width = static_cast<std::uint32_t>(lattice.width);
    push.height = static_cast<std::uint32_t>(lattice.height);
    push.pitch = static_cast<std::uint32_t>(lattice.pitch / 4);
    push.tiles_x = static_cast<std::uint32_t>(TileGrid::of(lattice.width, lattice.height).tiles_x);
    push.tiles = static_cast<std::uint32_t>(tiles_in(lattice.width, lattice.height));
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.dispatch(cut_, push, {lattice.q, lattice.classes}, {groups_for(push.tiles, CUT_TILES_LANES)});
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.dispatch(list_, push, {lattice.classes, lattice.tiles}, {1});
    return {};
}

void write_tiles(const ViewTiles& tiles, const GpuBuffer& buffer) {
    const TileListsHeader header = tile_lists_header(static_cast<std::uint32_t>(tiles.whole.size()),
                                                     static_cast<std::uint32_t>(tiles.mixed.size()));
    buffer.mapped<TileListsHeader>()[0] = header;
    const auto list = buffer.mapped<std::uint32_t>().subspan(header_words);
    std::copy(tiles.mixed.begin(), tiles.mixed.end(),
              std::copy(tiles.whole.begin(), tiles.whole.end(), list.begin()));
}

ViewTiles read_tiles(const GpuBuffer& buffer) {
    const TileListsHeader& header = buffer.mapped<TileListsHeader>()[0];
    const auto list = buffer.mapped<std::uint32_t>().subspan(header_words);
    const auto whole = list.first(header.whole_tiles);
    const auto mixed = list.subspan(header.whole_tiles, header.mixed_tiles);
    return {{whole.begin(), whole.end()}, {mixed.begin(), mixed.end()}};
}

}  // namespace touchable
