#include "player/draw/mesh_pipeline.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/scene/surface_frame.hpp"
#include "player/draw/view_rows.hpp"
#include "shaders/tile_lists.h"
#include "shaders/view_mesh.frag.spv.h"
#include "shaders/view_mesh.h"
#include "shaders/view_mesh.vert.spv.h"

namespace touchable {
namespace {

static_assert(MESH_TILE == TileGrid::cells);
static_assert(sizeof(MeshPush) == 84);
static_assert(TILE_LISTS_CORNERS == MESH_TILE_CELLS * 6);

Result<GpuBuffer> make_tile_pattern(const GpuDevice& device) {
    std::vector<std::uint16_t> indices;
    for (std::uint32_t y = 0; y < MESH_TILE; ++y)
        for (std::uint32_t x = 0; x < MESH_TILE; ++x) {
            const std::uint32_t a = y * MESH_TILE_SIDE + x, b = a + 1, c = b + MESH_TILE_SIDE, d = c - 1;
            for (const std::uint32_t vertex : {a, b, c, a, c, d})
                indices.push_back(static_cast<std::uint16_t>(vertex));
        }
    auto buffer = GpuBuffer::create(device, "tile pattern", indices.size() * 2, GpuMemory::upload);
    if (buffer.ok()) std::copy(indices.begin(), indices.end(), buffer->mapped<std::uint16_t>().begin());
    return buffer;
}

}  // namespace

Result<MeshPipeline> MeshPipeline::create(const GpuDevice& device) {
    if (!device.facts().draws_triangles)
        return Error{
            ErrorKind::gpu,
            device.facts().name + " draws no triangles, which the painter mesh needs; raster and cpu do not",
            {{Setting::painter, "raster"}}};
    MeshPipeline pipeline;
    for (const bool is_mixed : {false, true}) {
        GraphicsLook look;
        look.vertex = view_mesh_vert_spv;
        look.fragment = view_mesh_frag_spv;
        look.push_bytes = sizeof(MeshPush);
        look.bindings.assign(4, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
        look.constants = {is_mixed ? 1U : 0U};
        look.colour_format = colour_format;
        TRY_ASSIGN(auto made,
                   GraphicsProgram::create(device, is_mixed ? "mixed tiles" : "whole tiles", look));
        (is_mixed ? pipeline.mixed_ : pipeline.whole_) = std::move(made);
    }
    TRY_ASSIGN(auto pattern, make_tile_pattern(device));
    pipeline.pattern_ = std::move(pattern);
    return pipeline;
}

void MeshPipeline::draw(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera) const {
    const bool is_own = is_own_view(camera);
    const MeshPush push{rows_of(camera),
                        static_cast<std::uint32_t>(lattice.width),
                        static_cast<std::uint32_t>(lattice.height),
                        static_cast<std::uint32_t>(lattice.pitch),
                        static_cast<std::uint32_t>(TileGrid::of(lattice.width, lattice.height).tiles_x),
                        is_own ? 0U : 1U};
    const GpuBuffer& edges = is_own ? lattice.q : lattice.edges;
    const VkCommandBuffer drawing = commands.handle();
    whole_.bind(commands, push, {lattice.q, lattice.colours, lattice.tiles, edges});
    vkCmdBindIndexBuffer(drawing, pattern_.handle(), 0, VK_INDEX_TYPE_UINT16);
    commands.keep(pattern_.keep_alive());
    vkCmdDrawIndexedIndirect(drawing, lattice.tiles.handle(), offsetof(TileListsHeader, whole_indices), 1, 0);
    mixed_.bind(commands, push, {lattice.q, lattice.colours, lattice.tiles, edges});
    vkCmdDrawIndirect(drawing, lattice.tiles.handle(), offsetof(TileListsHeader, mixed_vertices), 1, 0);
}

void MeshPipeline::record(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera,
                          const GpuImage& colour, const GpuImage& z) const {
    constexpr VkImageLayout fresh = VK_IMAGE_LAYOUT_UNDEFINED;
    constexpr VkImageLayout source = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    record_transition(commands, colour, fresh, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    record_transition(commands, z, fresh, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    begin_drawing(commands, {colour, &z, false, VK_ATTACHMENT_LOAD_OP_CLEAR});
    draw(commands, lattice, camera);
    end_drawing(commands);
    record_transition(commands, colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, source);
    record_transition(commands, z, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, source);
}

}  // namespace touchable
