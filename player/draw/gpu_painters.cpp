// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/scene/frames.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/pictures.hpp"
#include "player/view/drawn_surface.hpp"
#include "shaders/gap_fill.h"
#include "shaders/raster.h"
#include "shaders/raster.spv.h"
#include "shaders/raster_large.spv.h"
#include "shaders/resolve.h"
#include "shaders/resolve.spv.h"
#include "shaders/tile_lists.h"
#include "shaders/view_mesh.frag.spv.h"
#include "shaders/view_mesh.h"
#include "shaders/view_mesh.vert.spv.h"

// Triangles of a lattice by compute (SurfaceRaster) and by the triangle hardware (MeshPipeline), and the two
// painters of single pictures built on them.

namespace touchable {
namespace {

static_assert(RASTER_TILE == TileGrid::cells);
static_assert(std::is_trivially_copyable_v<RasterPush> && sizeof(RasterPush) == 100);
static_assert(MESH_TILE == TileGrid::cells);
static_assert(sizeof(MeshPush) == 88);
static_assert(TILE_LISTS_CORNERS == MESH_TILE_CELLS * 6);

Result<GpuBuffer> make_tile_pattern(const GpuDevice& device) {
    std::vector<std::uint16_t> indices;
    for (std::uint32_t y = 0; y < MESH_TILE; ++y)
        for (std::uint32_t x = 0; x < MESH_TILE; ++x) {
            const std::uint32_t a = y * MESH_TILE_SIDE + x, b = a + 1, c = b + MESH_TILE_SIDE, d = c - 1;
            for (const std::uint32_t vertex : {a, b, c, a, c, d})
                indices.push_back(static_cast<std::uint16_t>(vertex));
        }
    TRY_ASSIGN(auto buffer, GpuBuffer::create(device, "tile pattern", indices.size() * 2, GpuMemory::upload));
    std::copy(indices.begin(), indices.end(), buffer.mapped<std::uint16_t>().begin());
    return buffer;
}

class GpuPainter : public SurfacePainter {
public:
    explicit GpuPainter(std::shared_ptr<GpuDevice> device) : device_(std::move(device)), lattices_(device_) {}

    std::string gpu_name() const final { return device_->facts().name; }

protected:
    std::shared_ptr<GpuDevice> device_;
    GpuLattices lattices_;
};

class MeshPainter final : public GpuPainter {
public:
    MeshPainter(std::shared_ptr<GpuDevice> device, MeshPipeline pipeline)
        : GpuPainter(std::move(device)), pipeline_(std::move(pipeline)) {}

    std::string_view name() const override { return "mesh"; }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        TRY_ASSIGN(auto lattice, lattices_.lattice_of(surface));
        struct {
            std::string name;
            VkFormat format;
            VkImageLayout drawn;
            GpuImage image;
            GpuBuffer back;
        } planes[] = {
            {"picture colour", VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, {}, {}},
            {"picture z", GraphicsLook::z_format, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, {}, {}}};
        auto& [colour, z] = planes;
        const std::size_t bytes = 4 * pixel_count(camera.width, camera.height);
        for (auto& [name, format, drawn, image, back] : planes) {
            TRY_ASSIGN(image, GpuImage::create(*device_, name, camera.width, camera.height, format));
            TRY_ASSIGN(back, GpuBuffer::create(*device_, name + " read back", bytes, GpuMemory::readback));
        }

        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "mesh"));
        TRY(lattices_.record_view(commands, !is_own_view(camera), lattice));
        commands.barrier(GpuStage::compute, GpuStage::graphics);
        for (const auto& each : planes)
            record_transition(commands, each.image, VK_IMAGE_LAYOUT_UNDEFINED, each.drawn);
        begin_drawing(commands, {colour.image, &z.image, false, VK_ATTACHMENT_LOAD_OP_CLEAR});
        pipeline_.draw(commands, lattice, camera);
        end_drawing(commands);
        for (const auto& each : planes) {
            record_transition(commands, each.image, each.drawn, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
            copy_from_image(commands, each.image, each.back);
        }
        TRY_ASSIGN(const auto submission, std::move(commands).submit());
        TRY(submission.wait_for_picture());

        const auto z_read = z.back.mapped<float>();
        const auto colour_read = colour.back.mapped<PackedColour>();
        return PicturePlanes{camera.width, camera.height, std::vector<float>(z_read.begin(), z_read.end()),
                             std::vector<PackedColour>(colour_read.begin(), colour_read.end())};
    }

private:
    MeshPipeline pipeline_;
};

class RasterPainter final : public GpuPainter {
public:
    RasterPainter(std::shared_ptr<GpuDevice> device, SurfaceRaster raster)
        : GpuPainter(std::move(device)), raster_(std::move(raster)) {}

    std::string_view name() const override { return "raster"; }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        TRY_ASSIGN(auto lattice, lattices_.lattice_of(surface));
        const std::size_t bytes =
            std::size_t{8} * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        if (bytes > device_->facts().limits.max_storage_buffer_range)
            return gpu_error("a picture of " + std::to_string(camera.width) + "x" +
                                 std::to_string(camera.height) +
                                 " samples is too large for the painter raster on " + device_->facts().name +
                                 "; cpu and mesh draw it",
                             {{Setting::painter, "mesh"}});
        TRY(reserve(bytes, SurfaceRaster::large_bytes(surface.width, surface.height)));

        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "raster"));
        TRY(lattices_.record_view(commands, !is_own_view(camera), lattice));
        commands.barrier(GpuStage::compute, GpuStage::compute);
        raster_.record(commands, lattice, camera, pixels_, camera.width, large_);
        if (seen_.handle() != pixels_.handle()) {
            commands.barrier(GpuStage::compute, GpuStage::transfer);
            commands.copy(pixels_, 0, seen_, 0, bytes);
        }
        TRY_ASSIGN(const auto submission, std::move(commands).submit());
        TRY(submission.wait_for_picture());
        return unpacked(seen_.mapped<std::uint64_t>().first(bytes / 8), camera);
    }

private:
    /// Buffers for a picture and for large cells; those of the last picture are reused if they are large
    /// enough.
    Result<void> reserve(std::size_t bytes, std::size_t large_bytes) {
        if (!large_ || large_.bytes() < large_bytes) {
            TRY_ASSIGN(large_, GpuBuffer::create(*device_, "large cells", large_bytes, GpuMemory::device));
        }
        if (pixels_ && pixels_.bytes() >= bytes) return {};
        // Atomics need the GPU's own memory; the result is copied for the CPU.
        const bool unified = device_->facts().unified_memory;
        TRY_ASSIGN(auto pixels, GpuBuffer::create(*device_, "picture pixels", bytes,
                                                  unified ? GpuMemory::shared : GpuMemory::device));
        if (unified) {
            seen_ = pixels;
        } else {
            TRY_ASSIGN(seen_, GpuBuffer::create(*device_, "picture read back", bytes, GpuMemory::readback));
        }
        pixels_ = std::move(pixels);
        return {};
    }

    static PicturePlanes unpacked(std::span<const std::uint64_t> pixels, const ViewCamera& camera) {
        PicturePlanes planes{camera.width, camera.height, {}, {}};
        planes.z.resize(pixels.size());
        planes.colours.resize(pixels.size());
        for (std::size_t k = 0; k < pixels.size(); ++k) {
            planes.z[k] = std::bit_cast<float>(static_cast<std::uint32_t>(pixels[k] >> 32));
            planes.colours[k] = static_cast<PackedColour>(pixels[k]);
        }
        return planes;
    }

    SurfaceRaster raster_;
    GpuBuffer pixels_, large_, seen_;  // seen_: CPU-readable pixels
};

}  // namespace

Result<MeshPipeline> MeshPipeline::create(const GpuDevice& device) {
    if (!device.facts().draws_triangles)
        return Error{
            ErrorKind::gpu,
            device.facts().name + " draws no triangles, which the painter mesh needs; raster and cpu do not",
            {{Setting::painter, "raster"}}};
    MeshPipeline pipeline;
    for (const auto& [program, name, constants] :
         {std::tuple{&pipeline.whole_, "whole tiles", std::vector{0U, 0U}},
          {&pipeline.mixed_, "mixed tiles", {1U, 0U}},
          {&pipeline.gaps_, "gaps", {1U, 1U}}})
        TRY(assign(*program,
                   GraphicsProgram::create(device, name,
                                           {.vertex = view_mesh_vert_spv,
                                            .fragment = view_mesh_frag_spv,
                                            .push_bytes = sizeof(MeshPush),
                                            .bindings = std::vector(4, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER),
                                            .constants = constants})));
    TRY_ASSIGN(pipeline.pattern_, make_tile_pattern(device));
    return pipeline;
}

void MeshPipeline::draw(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera) const {
    const bool is_own = is_own_view(camera);
    MeshPush push{rows_of(camera),
                  static_cast<std::uint32_t>(lattice.width),
                  static_cast<std::uint32_t>(lattice.height),
                  static_cast<std::uint32_t>(lattice.pitch),
                  static_cast<std::uint32_t>(TileGrid::of(lattice.width, lattice.height).tiles_x),
                  is_own ? 0U : 1U,
                  0};
    // Clip space is two units wide.
    if (is_own) push.beyond = 2.0F / (push.rows.x.x * static_cast<float>(camera.width * VIEW_SUBPIXELS));
    const GpuBuffer &q = lattice.drawn_q, &edges = is_own ? q : lattice.edges, &tiles = lattice.tiles;
    const VkCommandBuffer drawing = commands.handle();
    whole_.bind(commands, push, {q, lattice.colours, tiles, edges});
    vkCmdBindIndexBuffer(drawing, pattern_.handle(), 0, VK_INDEX_TYPE_UINT16);
    commands.keep(pattern_.keep_alive());
    vkCmdDrawIndexedIndirect(drawing, tiles.handle(), offsetof(TileListsHeader, whole_indices), 1, 0);
    mixed_.bind(commands, push, {q, lattice.colours, tiles, edges});
    vkCmdDrawIndirect(drawing, tiles.handle(), offsetof(TileListsHeader, mixed_vertices), 1, 0);
    if (is_own || !lattice.fills_gaps) return;
    gaps_.bind(commands, push, {q, lattice.colours, tiles, edges});
    scale_z(commands, {static_cast<std::uint32_t>(camera.width), static_cast<std::uint32_t>(camera.height)},
            GAP_Z);
    vkCmdDrawIndirect(drawing, tiles.handle(), offsetof(TileListsHeader, mixed_vertices), 1, 0);
}

Result<SurfaceRaster> SurfaceRaster::create(const GpuDevice& device) {
    if (!device.facts().int64_atomics)
        return gpu_error(device.facts().name +
                             " has no 64-bit atomics, which the painter raster needs; mesh and cpu do not",
                         {{Setting::painter, "mesh"}});
    SurfaceRaster made;
    const auto storage = GpuBindingKind::storage_buffer, texels = GpuBindingKind::uniform_texels;
    TRY_ASSIGN(made.raster_, GpuProgram::create(device, "raster", raster_spv,
                                                {sizeof(RasterPush),
                                                 {texels, texels, storage, storage, storage, storage},
                                                 {RASTER_LANES, 1, 1}}));
    TRY_ASSIGN(made.large_, GpuProgram::create(device, "raster_large", raster_large_spv,
                                               {sizeof(RasterPush),
                                                {texels, texels, storage, storage, storage},
                                                {RASTER_LARGE_LANES, 1, 1}}));
    TRY_ASSIGN(made.resolve_,
               GpuProgram::create(
                   device, "resolve", resolve_spv,
                   {sizeof(ResolvePush), {texels, storage, storage, storage}, {RESOLVE_LANES, 1, 1}}));
    return made;
}

std::size_t SurfaceRaster::large_bytes(int width, int height) {
    return 4 * (RASTER_LARGE_HEADER + pixel_count(width, height));
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
    const bool is_own = is_own_view(camera);
    push.is_turned = is_own ? 0 : 1;
    push.fills_gaps = !is_own && lattice.fills_gaps ? 1 : 0;

    commands.fill(pixels, 0, 0, std::size_t{8} * push.picture_pitch * push.picture_height);
    // x is 0 groups so far, y and z are 1; 0 cells.
    commands.fill(large, 0, 0, 4);
    commands.fill(large, 1, 4, 8);
    commands.fill(large, 0, 12, 4);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    const auto q = GpuBinding::words(lattice.drawn_q), colours = GpuBinding::words(lattice.colours);
    const GpuBuffer &edges = is_own ? lattice.drawn_q : lattice.edges, &tiles = lattice.tiles;
    commands.dispatch_indirect(raster_, push, {q, colours, pixels, large, edges, tiles}, tiles,
                               offsetof(TileListsHeader, groups_x));
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
    commands.dispatch(resolve_, push, {pixels, background, colours, z},
                      {groups_for(push.height * push.steps, RESOLVE_LANES)});
}

Result<std::unique_ptr<SurfacePainter>> make_raster_painter(std::shared_ptr<GpuDevice> device) {
    TRY_ASSIGN(auto raster, SurfaceRaster::create(*device));
    return std::make_unique<RasterPainter>(std::move(device), std::move(raster));
}

Result<std::unique_ptr<SurfacePainter>> make_mesh_painter(std::shared_ptr<GpuDevice> device) {
    TRY_ASSIGN(auto pipeline, MeshPipeline::create(*device));
    return std::make_unique<MeshPainter>(std::move(device), std::move(pipeline));
}

}  // namespace touchable
