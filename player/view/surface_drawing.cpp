#include "player/view/surface_drawing.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "player/view/light_picture.hpp"
#include "shaders/view_background.frag.spv.h"
#include "shaders/view_screen.vert.spv.h"

namespace touchable {
namespace {

bool draws_by_mesh(std::string_view painter, const GpuFacts& facts) {
    return painter == "mesh" ||
           (painter == "auto" && (facts.kind != GpuKind::software || !facts.int64_atomics));
}

Result<GraphicsProgram> background_program(const GpuDevice& device) {
    GraphicsLook look;
    look.vertex = view_screen_vert_spv;
    look.fragment = view_background_frag_spv;
    look.bindings = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};
    look.depth = DrawDepth::replaced;
    return GraphicsProgram::create(device, "background", look);
}

void record_copy(GpuCommands& commands, const GpuImage& from, const GpuImage& to) {
    VkImageCopy region{};
    region.srcSubresource = {from.aspect(), 0, 0, 1};
    region.dstSubresource = {to.aspect(), 0, 0, 1};
    region.extent = {to.extent().width, to.extent().height, 1};
    vkCmdCopyImage(commands.handle(), from.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle(),
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    commands.keep(from.keep_alive());
}

}  // namespace

SurfaceDrawing::SurfaceDrawing(std::shared_ptr<GpuDevice> device, FingerDrawing fingers)
    : device_(std::move(device)), lattices_(device_), lighting_(device_), fingers_(std::move(fingers)) {}

Result<std::unique_ptr<SurfaceDrawing>> SurfaceDrawing::create(std::shared_ptr<GpuDevice> device,
                                                               std::string_view painter) {
    if (painter != "auto" && painter != "raster" && painter != "mesh")
        return usage_error("--painter " + std::string(painter) +
                           " does not draw on a GPU; auto, raster and mesh do");
    if (!device->facts().draws_triangles)
        return Error{ErrorKind::gpu, device->facts().name + " draws no triangles, which a window needs"};
    auto fingers = FingerDrawing::create(device);
    if (!fingers.ok()) return fingers.error();
    std::unique_ptr<SurfaceDrawing> made(new SurfaceDrawing(device, std::move(*fingers)));
    if (draws_by_mesh(painter, device->facts())) {
        auto mesh = MeshPipeline::create(*device);
        if (!mesh.ok()) return mesh.error();
        made->mesh_ = std::move(*mesh);
    } else {
        auto raster = SurfaceRaster::create(*device);
        if (!raster.ok()) return raster.error();
        made->raster_ = std::move(*raster);
        auto own_view = OwnViewPipeline::create(device);
        if (!own_view.ok()) return own_view.error();
        made->own_view_.emplace(std::move(*own_view));
    }
    auto background = background_program(*device);
    if (!background.ok()) return background.error();
    made->background_ = std::move(*background);
    return made;
}

Result<void> SurfaceDrawing::show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                  const PlaneView& colour, Lighting lighting) {
    is_shown_ = false;
    drawn_.reset();
    // Whoever read the last surface, in the same commands, has done so.
    for (const GpuStage reader : {GpuStage::compute, GpuStage::indirect, GpuStage::graphics})
        commands.barrier(reader, GpuStage::compute);
    if (auto made = lattices_.record(commands, field, pair, lattice_); !made.ok()) return made;
    if (auto made = lattices_.reserve_colours(lattice_); !made.ok()) return made;
    if (auto lit = lighting_.record(commands, field, lattice_, colour, lighting); !lit.ok()) return lit;
    commands.mark("light");
    is_shown_ = true;
    return {};
}

/// What pictures of a size need.
Result<void> SurfaceDrawing::reserve(const ViewCamera& camera) {
    const auto width = static_cast<std::uint32_t>(camera.width),
               height = static_cast<std::uint32_t>(camera.height);
    if (z_ && z_.extent().width == width && z_.extent().height == height) return {};
    z_ = {};
    drawn_.reset();
    const struct {
        GpuImage& image;
        const char* name;
        VkFormat format;
    } needed[] = {{colour_, "surface colour", VK_FORMAT_R8G8B8A8_UNORM},
                  {own_z_, "surface z", GraphicsLook::z_format},
                  {z_, "picture z", GraphicsLook::z_format}};
    auto rows = GpuBuffer::create(*device_, "background", 4 * static_cast<std::size_t>(height),
                                  device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload);
    if (!rows.ok()) return rows.error();
    const auto colours = rows->mapped<PackedColour>();
    for (int y = 0; y < camera.height; ++y)
        colours[static_cast<std::size_t>(y)] = background_colour(y, camera.height);
    rows_ = std::move(*rows);
    for (const auto& each : needed) {
        auto made = GpuImage::create(*device_, each.name, camera.width, camera.height, each.format);
        if (!made.ok()) return made.error();
        each.image = std::move(*made);
    }
    return {};
}

Result<void> SurfaceDrawing::reserve_pixels(const ViewCamera& camera) {
    const std::size_t pixels = static_cast<std::size_t>(SurfaceRaster::resolve_pitch(camera.width)) *
                               static_cast<std::size_t>(camera.height);
    const GpuLimits& limits = device_->facts().limits;
    if (8 * pixels > limits.max_storage_buffer_range || pixels / 2 > limits.max_texel_buffer_elements)
        return Error{ErrorKind::gpu, "a picture of " + std::to_string(camera.width) + "x" +
                                         std::to_string(camera.height) +
                                         " pixels is too large for --painter raster on " +
                                         device_->facts().name + "; mesh draws it"};
    const struct {
        GpuBuffer& buffer;
        const char* name;
        std::size_t bytes;
    } needed[] = {{pixels_, "picture pixels", 8 * pixels},
                  {large_, "large cells", SurfaceRaster::large_bytes(lattice_.width, lattice_.height)}};
    for (const auto& each : needed) {
        if (each.buffer && each.buffer.bytes() >= each.bytes) continue;
        auto made = GpuBuffer::create(*device_, each.name, each.bytes, GpuMemory::device);
        if (!made.ok()) return made.error();
        each.buffer = std::move(*made);
    }
    return {};
}

/// Surface and background, or what is there of them, between begin_drawing and end_drawing.
Result<void> SurfaceDrawing::draw_surface(GpuCommands& commands, const ViewCamera& camera) {
    if (is_shown_ && raster_) {
        if (OwnViewPipeline::draws(camera)) return own_view_->draw(commands, lattice_, camera);
        raster_->record_resolve(commands, pixels_, SurfaceRaster::resolve_pitch(camera.width), rows_);
        return {};
    }
    background_.bind(commands, {rows_});
    vkCmdDraw(commands.handle(), 3, 1, 0, 0);
    if (is_shown_) mesh_->draw(commands, lattice_, camera);
    return {};
}

/// Colour and z of the surface, if they are not of this surface from here already.
Result<void> SurfaceDrawing::record_surface(GpuCommands& commands, const ViewCamera& camera) {
    if (drawn_ == camera.clip_from_lattice) return {};
    drawn_.reset();
    commands.barrier(GpuStage::compute, GpuStage::indirect);
    if (is_shown_ && raster_ && !OwnViewPipeline::draws(camera)) {
        if (auto reserved = reserve_pixels(camera); !reserved.ok()) return reserved;
        commands.barrier(GpuStage::compute, GpuStage::compute);
        // Whoever has read the last pixels has done so.
        commands.barrier(GpuStage::graphics, GpuStage::transfer);
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        raster_->record(commands, lattice_, camera, pixels_, SurfaceRaster::resolve_pitch(camera.width),
                        large_);
        commands.mark("raster");
    }
    commands.barrier(GpuStage::compute, GpuStage::graphics);
    constexpr VkImageLayout fresh = VK_IMAGE_LAYOUT_UNDEFINED;
    constexpr VkImageLayout source = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    record_transition(commands, colour_, fresh, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    record_transition(commands, own_z_, fresh, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    begin_drawing(commands, {colour_, &own_z_, false, VK_ATTACHMENT_LOAD_OP_DONT_CARE});
    const auto drawn = draw_surface(commands, camera);
    end_drawing(commands);
    if (!drawn.ok()) return drawn;
    record_transition(commands, colour_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, source);
    record_transition(commands, own_z_, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, source);
    commands.mark("surface");
    drawn_ = camera.clip_from_lattice;
    return {};
}

/// The surface to where fingers are drawn over it.
void SurfaceDrawing::record_copies(GpuCommands& commands, const GpuImage& target) const {
    const struct {
        const GpuImage &from, &to;
        VkImageLayout then;
    } copies[] = {{colour_, target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                  {own_z_, z_, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL}};
    for (const auto& [from, to, then] : copies) {
        record_transition(commands, to, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        record_copy(commands, from, to);
        record_transition(commands, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, then);
    }
}

Result<void> SurfaceDrawing::draw(GpuCommands& commands, const ViewCamera& camera,
                                  std::span<const FingerMark> fingers, const MarkSizes& sizes,
                                  const GpuImage& target) {
    if (target.extent().width != static_cast<std::uint32_t>(camera.width) ||
        target.extent().height != static_cast<std::uint32_t>(camera.height))
        return Error{ErrorKind::internal, "a picture is not of its camera's size"};
    if (auto reserved = reserve(camera); !reserved.ok()) return reserved;
    if (auto drawn = record_surface(commands, camera); !drawn.ok()) return drawn;
    record_copies(commands, target);
    commands.mark("picture");
    if (auto drawn = fingers_.record(commands, fingers, sizes, camera, target, z_); !drawn.ok()) return drawn;
    if (!fingers.empty()) commands.mark("fingers");
    return {};
}

}  // namespace touchable
