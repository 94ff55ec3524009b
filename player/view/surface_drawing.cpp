#include "player/view/surface_drawing.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "player/view/light_picture.hpp"
#include "shaders/view_background.frag.spv.h"
#include "shaders/view_pixels.frag.spv.h"
#include "shaders/view_screen.h"
#include "shaders/view_screen.vert.spv.h"

namespace touchable {
namespace {

bool draws_by_mesh(std::string_view painter, const GpuFacts& facts) {
    return painter == "mesh" ||
           (painter == "auto" && (facts.kind != GpuKind::software || !facts.int64_atomics));
}

Result<GraphicsProgram> screen_program(const GpuDevice& device, const char* name,
                                       std::span<const std::uint32_t> fragment, std::size_t buffers,
                                       DrawDepth depth) {
    GraphicsLook look;
    look.vertex = view_screen_vert_spv;
    look.fragment = fragment;
    look.push_bytes = sizeof(ScreenPush);
    look.bindings.assign(buffers, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
    look.depth = depth;
    return GraphicsProgram::create(device, name, look);
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
    }
    auto background = screen_program(*device, "background", view_background_frag_spv, 1, DrawDepth::replaced);
    if (!background.ok()) return background.error();
    made->background_ = std::move(*background);
    auto pixels = screen_program(*device, "pixels", view_pixels_frag_spv, 2, DrawDepth::replaced);
    if (!pixels.ok()) return pixels.error();
    made->pixels_to_picture_ = std::move(*pixels);
    return made;
}

Result<void> SurfaceDrawing::show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                  const PlaneView& colour, Lighting lighting) {
    is_shown_ = false;
    rastered_.reset();
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

void SurfaceDrawing::show_nothing() {
    is_shown_ = false;
    rastered_.reset();
}

/// What pictures of a size need.
Result<void> SurfaceDrawing::reserve(const ViewCamera& camera) {
    const auto width = static_cast<std::uint32_t>(camera.width),
               height = static_cast<std::uint32_t>(camera.height);
    if (!z_ || z_.extent().width != width || z_.extent().height != height) {
        auto z = GpuImage::create(*device_, "picture z", camera.width, camera.height, GraphicsLook::z_format);
        if (!z.ok()) return z.error();
        z_ = std::move(*z);
    }
    if (rows_height_ == camera.height) return {};
    auto rows = GpuBuffer::create(*device_, "background", 4 * static_cast<std::size_t>(height),
                                  device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload);
    if (!rows.ok()) return rows.error();
    const auto colours = rows->mapped<PackedColour>();
    for (int y = 0; y < camera.height; ++y)
        colours[static_cast<std::size_t>(y)] = background_colour(y, camera.height);
    rows_ = std::move(*rows);
    rows_height_ = camera.height;
    return {};
}

Result<void> SurfaceDrawing::reserve_pixels(const ViewCamera& camera) {
    const std::size_t bytes =
        std::size_t{8} * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    if (bytes > device_->facts().limits.max_storage_buffer_range)
        return Error{ErrorKind::gpu, "a picture of " + std::to_string(camera.width) + "x" +
                                         std::to_string(camera.height) +
                                         " pixels is too large for --painter raster on " +
                                         device_->facts().name + "; mesh draws it"};
    const std::size_t large_bytes = SurfaceRaster::large_bytes(lattice_.width, lattice_.height);
    const std::pair<GpuBuffer*, std::size_t> buffers[] = {{&pixels_, bytes}, {&large_, large_bytes}};
    for (const auto& [buffer, needed] : buffers) {
        if (*buffer && buffer->bytes() >= needed) continue;
        auto made = GpuBuffer::create(*device_, buffer == &pixels_ ? "picture pixels" : "large cells", needed,
                                      GpuMemory::device);
        if (!made.ok()) return made.error();
        *buffer = std::move(*made);
    }
    return {};
}

/// The surface into packed pixels, if they are not of this surface from here already.
Result<void> SurfaceDrawing::record_raster(GpuCommands& commands, const ViewCamera& camera) {
    if (rastered_ == camera.clip_from_lattice && rastered_width_ == camera.width &&
        rastered_height_ == camera.height)
        return {};
    rastered_.reset();
    if (auto reserved = reserve_pixels(camera); !reserved.ok()) return reserved;
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    commands.barrier(GpuStage::graphics, GpuStage::transfer);
    raster_->record(commands, lattice_, camera, pixels_, large_);
    commands.mark("raster");
    rastered_ = camera.clip_from_lattice;
    rastered_width_ = camera.width;
    rastered_height_ = camera.height;
    return {};
}

void SurfaceDrawing::record_surface(GpuCommands& commands, const ViewCamera& camera,
                                    const GpuImage& target) const {
    const ScreenPush push{static_cast<std::uint32_t>(camera.width)};
    begin_drawing(commands, {target, &z_, false, VK_ATTACHMENT_LOAD_OP_DONT_CARE});
    if (is_shown_ && raster_) {
        pixels_to_picture_.bind(commands, push, {rows_, pixels_});
        vkCmdDraw(commands.handle(), 3, 1, 0, 0);
    } else {
        background_.bind(commands, push, {rows_});
        vkCmdDraw(commands.handle(), 3, 1, 0, 0);
        if (is_shown_) mesh_->draw(commands, lattice_, camera);
    }
    end_drawing(commands);
    commands.mark("picture");
}

Result<void> SurfaceDrawing::draw(GpuCommands& commands, const ViewCamera& camera,
                                  std::span<const FingerMark> fingers, const MarkSizes& sizes,
                                  const GpuImage& target) {
    if (target.extent().width != static_cast<std::uint32_t>(camera.width) ||
        target.extent().height != static_cast<std::uint32_t>(camera.height))
        return Error{ErrorKind::internal, "a picture is not of its camera's size"};
    if (auto reserved = reserve(camera); !reserved.ok()) return reserved;
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.barrier(GpuStage::compute, GpuStage::indirect);
    if (is_shown_ && raster_)
        if (auto rastered = record_raster(commands, camera); !rastered.ok()) return rastered;
    commands.barrier(GpuStage::compute, GpuStage::graphics);
    record_transition(commands, target, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    record_transition(commands, z_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    record_surface(commands, camera, target);
    if (auto drawn = fingers_.record(commands, fingers, sizes, camera, target, z_); !drawn.ok()) return drawn;
    if (!fingers.empty()) commands.mark("fingers");
    return {};
}

}  // namespace touchable
