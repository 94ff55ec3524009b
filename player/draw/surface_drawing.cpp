#include "player/draw/surface_drawing.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "engine/base/try.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/view_rows.hpp"
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

/// All of an image, from rows of 4 bytes a pixel.
void record_copy(GpuCommands& commands, const GpuBuffer& pixels, int pitch, const GpuImage& image) {
    VkBufferImageCopy region{};
    region.bufferRowLength = static_cast<std::uint32_t>(pitch);
    region.imageSubresource = {image.aspect(), 0, 0, 1};
    region.imageExtent = {image.extent().width, image.extent().height, 1};
    vkCmdCopyBufferToImage(commands.handle(), pixels.handle(), image.handle(),
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    commands.keep(pixels.keep_alive());
}

}  // namespace

SurfaceDrawing::SurfaceDrawing(std::shared_ptr<GpuDevice> device, FingerDrawing fingers)
    : device_(std::move(device)),
      lattices_(device_),
      lighting_(device_),
      dent_patches_(device_),
      fingers_(std::move(fingers)),
      pictures_(device_) {}

Result<std::unique_ptr<SurfaceDrawing>> SurfaceDrawing::create(std::shared_ptr<GpuDevice> device,
                                                               std::string_view painter) {
    if (painter != "auto" && painter != "raster" && painter != "mesh")
        return usage_error(
            "painter " + std::string(painter) + " does not draw on a GPU; auto, raster and mesh do",
            {{Setting::painter}});
    if (!device->facts().draws_triangles)
        return Error{ErrorKind::gpu, device->facts().name + " draws no triangles, which a window needs"};
    TRY_ASSIGN(auto fingers, FingerDrawing::create(device));
    std::unique_ptr<SurfaceDrawing> made(new SurfaceDrawing(device, std::move(fingers)));
    if (draws_by_mesh(painter, device->facts())) {
        TRY_ASSIGN(auto mesh, MeshPipeline::create(*device));
        made->mesh_ = std::move(mesh);
    } else {
        TRY_ASSIGN(auto raster, SurfaceRaster::create(*device));
        made->raster_ = std::move(raster);
        if (device->facts().kind == GpuKind::software && device->facts().unified_memory) {
            made->by_cpu_.emplace(CpuLattices::usual_threads());
            made->decimation_.emplace(CpuLattices::usual_threads());
            made->turned_view_.emplace(CpuLattices::usual_threads());
            made->edges_.emplace(CpuLattices::usual_threads());
        }
    }
    if (!made->by_cpu_) {
        TRY_ASSIGN(auto dents, DentDrawing::create(device));
        made->dents_ = std::move(dents);
    }
    TRY_ASSIGN(auto background, background_program(*device));
    made->background_ = std::move(background);
    return made;
}

Result<void> SurfaceDrawing::show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                  const PlaneView& colour, Lighting lighting, int step) {
    if (by_cpu_) {
        if (auto made = show_by_cpu(field, pair, colour, lighting, step); !made.ok()) return made;
        shown_.by(commands);
        return {};
    }
    if (auto begun = begin_surface(field, colour, lighting); !begun.ok()) return begun;
    // Whoever read the last surface, in the same commands, has done so.
    for (const GpuStage reader : {GpuStage::compute, GpuStage::indirect, GpuStage::graphics})
        commands.barrier(reader, GpuStage::compute);
    if (auto made = lattices_.record(commands, field, pair, lattice_); !made.ok()) return made;
    if (auto made = lattices_.reserve_colours(lattice_); !made.ok()) return made;
    if (auto lit = lighting_.record(commands, field, lattice_, colour, lighting); !lit.ok()) return lit;
    commands.mark("light");
    shown_.by(commands);
    return {};
}

/// Nothing is shown until it is made.
Result<void> SurfaceDrawing::begin_surface(const HeightField& field, const PlaneView& colour,
                                           Lighting lighting) {
    for (GpuMade* const made : {&shown_, &listed_, &edged_, &drawn_}) made->reset();
    are_values_ = lighting == Lighting::plain && !colour.empty();
    return check_colour(colour, field.width(), field.height());
}

/// On a device that computes on the CPU: there its vectors do so for a third of what the kernels cost.
Result<void> SurfaceDrawing::show_by_cpu(const HeightField& field, const FramePair& pair,
                                         const PlaneView& colour, Lighting lighting, int step) {
    if (auto begun = begin_surface(field, colour, lighting); !begun.ok()) return begun;
    const bool is_part = step > 1 && SurfaceUnproject::has_codes(field, pair);
    if (is_part) decimation_->make(field, pair, colour, step);
    if (auto made = is_part ? make_by_cpu(decimation_->field(), decimation_->pair(), decimation_->colour(),
                                          lighting, step)
                            : make_by_cpu(field, pair, colour, lighting, 1);
        !made.ok())
        return made;
    shown_.by_cpu();
    return {};
}

Result<void> SurfaceDrawing::make_by_cpu(const HeightField& field, const FramePair& pair,
                                         const PlaneView& colour, Lighting lighting, int step) {
    if (auto made = lattices_.renew(field, lattice_); !made.ok()) return made;
    lattice_.step = step;
    float* const q = lattice_.q.mapped<float>().data();
    if (SurfaceUnproject::has_codes(field, pair))
        by_cpu_->q_of(field, pair, q, lattice_.pitch);
    else
        put_q(q_of(field), lattice_);
    by_cpu_->light(field, q, lattice_.pitch, colour, lighting, lattice_.colours.mapped<PackedColour>().data(),
                   cut_ratio(step));
    return {};
}

/// What pictures of a size need.
Result<void> SurfaceDrawing::reserve(const ViewCamera& camera) {
    const auto width = static_cast<std::uint32_t>(camera.width),
               height = static_cast<std::uint32_t>(camera.height);
    if (!z_ || z_.extent().width != width || z_.extent().height != height) {
        TRY_ASSIGN(auto z, GpuImage::create(*device_, "picture z", camera.width, camera.height,
                                            GraphicsLook::z_format));
        z_ = std::move(z);
    }
    if (rows_height_ == camera.height) return {};
    TRY_ASSIGN(auto rows,
               GpuBuffer::create(*device_, "background", 4 * static_cast<std::size_t>(height),
                                 device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload));
    const auto colours = rows.mapped<PackedColour>();
    for (int y = 0; y < camera.height; ++y)
        colours[static_cast<std::size_t>(y)] = background_colour(y, camera.height);
    rows_ = std::move(rows);
    rows_height_ = camera.height;
    return {};
}

Result<void> SurfaceDrawing::reserve_pixels(const ViewCamera& camera) {
    const std::size_t pixels = static_cast<std::size_t>(SurfaceRaster::resolve_pitch(camera.width)) *
                               static_cast<std::size_t>(camera.height);
    const GpuMemory memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::device;
    if (8 * pixels > device_->facts().limits.max_storage_buffer_range)
        return Error{ErrorKind::gpu,
                     "a picture of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                         " pixels is too large for the painter raster on " + device_->facts().name +
                         "; mesh draws it",
                     {{Setting::painter, "mesh"}}};
    const struct {
        GpuBuffer& buffer;
        const char* name;
        std::size_t bytes;
        GpuMemory memory;
    } needed[] = {{pixels_, "picture pixels", 8 * pixels, GpuMemory::device},
                  {colours_, "picture colours", 4 * pixels, memory},
                  {z_values_, "picture z", 4 * pixels, memory},
                  {large_, "large cells", SurfaceRaster::large_bytes(lattice_.width, lattice_.height),
                   GpuMemory::device}};
    for (const auto& each : needed) {
        if (each.buffer && each.buffer.bytes() >= each.bytes) continue;
        TRY_ASSIGN(auto made, GpuBuffer::create(*device_, each.name, each.bytes, each.memory));
        each.buffer = std::move(made);
    }
    return {};
}

/// Of a surface, once.
Result<void> SurfaceDrawing::list_tiles(GpuCommands& commands) {
    if (listed_.is_there_for(commands)) return {};
    if (auto tiles = lattices_.record_tiles(commands, lattice_); !tiles.ok()) return tiles;
    listed_.by(commands);
    return {};
}

bool SurfaceDrawing::is_drawn(const GpuCommands& commands, const ViewCamera& camera) const {
    return drawn_.is_there_for(commands) && drawn_from_ == camera.clip_from_lattice &&
           drawn_width_ == camera.width && drawn_height_ == camera.height;
}

/// Colours and z of the surface, if they are not of this surface from here already.
Result<void> SurfaceDrawing::draw_surface(GpuCommands& commands, const ViewCamera& camera) {
    if (is_drawn(commands, camera)) return {};
    drawn_.reset();
    if (by_cpu_) {
        if (auto drawn = draw_by_cpu(commands, camera); !drawn.ok()) return drawn;
    } else {
        if (auto reserved = reserve_pixels(camera); !reserved.ok()) return reserved;
        if (auto rastered = record_raster(commands, camera); !rastered.ok()) return rastered;
    }
    drawn_.by(commands);
    drawn_from_ = camera.clip_from_lattice;
    drawn_width_ = camera.width;
    drawn_height_ = camera.height;
    return {};
}

/// Into memory that nobody reads any more: pictures that were recorded before keep theirs.
Result<void> SurfaceDrawing::draw_by_cpu(const GpuCommands& commands, const ViewCamera& camera) {
    const int pitch = SurfaceRaster::resolve_pitch(camera.width);
    const std::size_t bytes = 4 * static_cast<std::size_t>(pitch) * static_cast<std::size_t>(camera.height);
    for (auto& [buffer, name] :
         {std::pair<GpuBuffer&, const char*>{colours_, "picture colours"}, {z_values_, "picture z"}}) {
        buffer = {};
        TRY_ASSIGN(auto taken, pictures_.take(name, bytes));
        buffer = std::move(taken);
    }
    const auto background = rows_.mapped<PackedColour>(), colours = colours_.mapped<PackedColour>();
    const auto z = z_values_.mapped<float>();
    const ViewCamera seen = decimated(camera, lattice_.step);
    const MappedLattice lattice{lattice_.q.mapped<float>().data(),
                                lattice_.colours.mapped<PackedColour>().data(),
                                lattice_.width,
                                lattice_.height,
                                lattice_.pitch,
                                lattice_.step};
    if (OwnViewPicture::draws(seen))
        own_view_.draw(lattice, seen, background, pitch, colours, z);
    else
        turned_view_->draw(lattice, edges_of(commands, seen), seen, background, pitch, colours, z);
    return {};
}

/// Of the surface as a camera is shown it; found once for each.
const SurfaceEdges& SurfaceDrawing::edges_of(const GpuCommands& commands, const ViewCamera& camera) {
    if (is_own_view(camera)) {
        edges_->clear();
        edged_.reset();
    } else if (!edged_.is_there_for(commands)) {
        edges_->find(lattice_.q.mapped<float>().data(), lattice_.width, lattice_.height, lattice_.pitch,
                     cut_ratio(lattice_.step), are_values_);
        edged_.by(commands);
    }
    return *edges_;
}

/// Likewise, on the device.
Result<void> SurfaceDrawing::record_edges(GpuCommands& commands, const ViewCamera& camera) {
    if (edged_.is_there_for(commands) || is_own_view(camera)) return {};
    if (auto found = lattices_.record_edges(commands, camera, are_values_, lattice_); !found.ok())
        return found;
    edged_.by(commands);
    return {};
}

Result<void> SurfaceDrawing::record_raster(GpuCommands& commands, const ViewCamera& camera) {
    if (auto listed = list_tiles(commands); !listed.ok()) return listed;
    if (auto found = record_edges(commands, camera); !found.ok()) return found;
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.barrier(GpuStage::compute, GpuStage::indirect);
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    raster_->record(commands, lattice_, camera, pixels_, SurfaceRaster::resolve_pitch(camera.width), large_);
    commands.mark("raster");
    commands.barrier(GpuStage::compute, GpuStage::compute);
    raster_->record_resolve(commands, camera, pixels_, rows_, colours_, z_values_);
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    commands.mark("resolve");
    return {};
}

/// What the raster has drawn, into images that are ready for it.
void SurfaceDrawing::record_copies(GpuCommands& commands, const ViewCamera& camera,
                                   const GpuImage& target) const {
    const int pitch = SurfaceRaster::resolve_pitch(camera.width);
    const struct {
        const GpuImage& image;
        const GpuBuffer& pixels;
        VkImageLayout then;
    } copies[] = {{target, colours_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                  {z_, z_values_, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL}};
    for (const auto& [image, pixels, then] : copies) {
        record_transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        record_copy(commands, pixels, pitch, image);
        record_transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, then);
    }
}

/// What gives way under fingers, over the surface that is drawn.
Result<void> SurfaceDrawing::record_dents(GpuCommands& commands, const ViewCamera& camera,
                                          std::span<const FingerMark> fingers, const MarkSizes& sizes,
                                          const GpuImage& target) {
    if (dents_) return dents_->record(commands, fingers, sizes, camera, target, z_);
    if (!shown_.is_there_for(commands)) return {};
    const FlatPicture flat{colours_.mapped<PackedColour>(), z_values_.mapped<float>(), camera.width,
                           camera.height, SurfaceRaster::resolve_pitch(camera.width)};
    return dent_patches_.record(commands, fingers, sizes, camera, flat, target);
}

/// Background, and the surface if there is one.
Result<void> SurfaceDrawing::record_mesh(GpuCommands& commands, const ViewCamera& camera,
                                         const GpuImage& target) {
    const bool is_shown = shown_.is_there_for(commands);
    if (is_shown) {
        if (auto listed = list_tiles(commands); !listed.ok()) return listed;
        if (auto found = record_edges(commands, camera); !found.ok()) return found;
    }
    commands.barrier(GpuStage::compute, GpuStage::graphics);
    commands.barrier(GpuStage::compute, GpuStage::indirect);
    record_transition(commands, target, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    record_transition(commands, z_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    begin_drawing(commands, {target, &z_, false, VK_ATTACHMENT_LOAD_OP_DONT_CARE});
    background_.bind(commands, {rows_});
    vkCmdDraw(commands.handle(), 3, 1, 0, 0);
    if (is_shown) mesh_->draw(commands, lattice_, camera);
    end_drawing(commands);
    return {};
}

Result<void> SurfaceDrawing::draw(GpuCommands& commands, const ViewCamera& camera,
                                  std::span<const FingerMark> fingers, const MarkSizes& sizes,
                                  const GpuImage& target) {
    if (target.extent().width != static_cast<std::uint32_t>(camera.width) ||
        target.extent().height != static_cast<std::uint32_t>(camera.height))
        return Error{ErrorKind::internal, "a picture is not of its camera's size"};
    if (auto reserved = reserve(camera); !reserved.ok()) return reserved;
    if (raster_ && shown_.is_there_for(commands)) {
        if (auto drawn = draw_surface(commands, camera); !drawn.ok()) return drawn;
        record_copies(commands, camera, target);
    } else if (auto drawn = record_mesh(commands, camera, target); !drawn.ok()) {
        return drawn;
    }
    commands.mark("picture");
    if (auto dented = record_dents(commands, camera, fingers, sizes, target); !dented.ok()) return dented;
    if (auto drawn = fingers_.record(commands, fingers, sizes, camera, target, z_); !drawn.ok()) return drawn;
    if (!fingers.empty()) commands.mark("fingers");
    return {};
}

}  // namespace touchable
