#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "shaders/view_background.frag.spv.h"
#include "shaders/view_screen.vert.spv.h"

// SurfaceDrawing. Caches a picture's inputs: the lattice of the shown surface, its tiles and edges, the
// raster's pixels, the images. GpuCommands::Made says for each whether it is valid for the commands being
// recorded.

namespace touchable {
namespace {

class DeviceDrawing final : public SurfaceDrawing {
public:
    DeviceDrawing(std::shared_ptr<GpuDevice> device, FingerDrawing fingers)
        : device_(std::move(device)),
          lattices_(device_),
          lighting_(device_),
          dent_patches_(device_),
          fingers_(std::move(fingers)),
          pictures_(device_) {}

    /// Creates the resources of the GPU painter with that name.
    Result<void> prepare(std::string_view painter) {
        const GpuFacts& facts = device_->facts();
        const bool is_software = facts.kind == GpuKind::software;
        if (painter == "mesh" || (painter == "auto" && draws_by_mesh(facts))) {
            TRY_ASSIGN(mesh_, MeshPipeline::create(*device_));
        } else {
            TRY_ASSIGN(raster_, SurfaceRaster::create(*device_));
            if (is_software && facts.unified_memory) {
                by_cpu_.emplace(CpuLattices::usual_threads());
                decimation_.emplace(CpuLattices::usual_threads());
                turned_view_.emplace(CpuLattices::usual_threads());
                edges_.emplace(CpuLattices::usual_threads());
            }
        }
        if (!by_cpu_) {
            TRY_ASSIGN(dents_, DentDrawing::create(device_));
            TRY(lattices_.make_programs());
            TRY(lighting_.make_program());
        }
        return assign(background_, GraphicsProgram::create(*device_, "background",
                                                           {.vertex = view_screen_vert_spv,
                                                            .fragment = view_background_frag_spv,
                                                            .bindings = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                                            .depth = DrawDepth::replaced}));
    }

    std::string_view painter() const override { return raster_ ? "raster" : "mesh"; }
    bool thins_vertices() const override { return by_cpu_.has_value(); }
    Result<void> show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                      const PlaneView& colour, Lighting lighting, int step) override {
        if (by_cpu_) {
            TRY(show_by_cpu(field, pair, colour, lighting, step));
            shown_.by(commands);
            return {};
        }
        TRY(begin_surface(field, colour, lighting));
        // Wait until the same commands have finished reading the last surface.
        for (const GpuStage reader : {GpuStage::compute, GpuStage::indirect, GpuStage::graphics})
            commands.barrier(reader, GpuStage::compute);
        TRY(lattices_.record(commands, field, pair, lattice_));
        TRY(lattices_.reserve_colours(lattice_));
        TRY(lighting_.record(commands, field, lattice_, colour, lighting));
        commands.mark("light");
        shown_.by(commands);
        return {};
    }

    /// On software devices: the CPU's vectors take a third of the kernels' time.
    Result<void> show_by_cpu(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                             Lighting lighting, int step) override {
        TRY(begin_surface(field, colour, lighting));
        const bool is_part = step > 1 && SurfaceUnproject::has_codes(field, pair);
        if (is_part) decimation_->make(field, pair, colour, step);
        TRY(is_part ? make_by_cpu(decimation_->field(), decimation_->pair(), decimation_->colour(), lighting,
                                  step)
                    : make_by_cpu(field, pair, colour, lighting, 1));
        shown_.by_cpu();
        return {};
    }

    Result<void> draw(GpuCommands& commands, const ViewCamera& camera, std::span<const FingerMark> fingers,
                      const MarkSizes& sizes, const GpuImage& target) override {
        if (!target.is_of_size(camera.width, camera.height))
            return internal_error("a picture is not of its camera's size");
        TRY(reserve(camera));
        if (raster_ && shown_.is_there_for(commands)) {
            TRY(draw_surface(commands, camera));
            record_copies(commands, camera, target);
        } else {
            TRY(record_mesh(commands, camera, target));
        }
        commands.mark("picture");
        TRY(record_dents(commands, camera, fingers, sizes, target));
        TRY(fingers_.record(commands, fingers, sizes, camera, target, z_));
        if (!fingers.empty()) commands.mark("fingers");
        return {};
    }

private:
    /// Invalidates everything until the new surface is made.
    Result<void> begin_surface(const HeightField& field, const PlaneView& colour, Lighting lighting) {
        for (GpuCommands::Made* const made : {&shown_, &listed_, &edged_, &drawn_}) made->reset();
        lattice_.fills_gaps = fills_gaps(colour, lighting);
        return check_colour(colour, field.width(), field.height());
    }

    Result<void> make_by_cpu(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                             Lighting lighting, int step) {
        TRY(lattices_.renew(field, lattice_));
        lattice_.step = step;
        float* const q = lattice_.q.mapped<float>().data();
        if (SurfaceUnproject::has_codes(field, pair))
            by_cpu_->q_of(field, pair, q, lattice_.pitch);
        else
            put_q(field, lattice_, lattice_.q);
        by_cpu_->light(field, q, lattice_.pitch, colour, lighting,
                       lattice_.colours.mapped<PackedColour>().data(), cut_ratio(step));
        return {};
    }

    /// Resources for pictures of the camera's size.
    Result<void> reserve(const ViewCamera& camera) {
        if (!z_ || !z_.is_of_size(camera.width, camera.height))
            TRY(assign(z_, GpuImage::create(*device_, "picture z", camera.width, camera.height,
                                            GraphicsLook::z_format)));
        if (rows_height_ == camera.height) return {};
        TRY_ASSIGN(auto rows, GpuBuffer::create(
                                  *device_, "background", 4 * static_cast<std::size_t>(camera.height),
                                  device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload));
        const auto colours = rows.mapped<PackedColour>();
        for (int y = 0; y < camera.height; ++y)
            colours[static_cast<std::size_t>(y)] = background_colour(y, camera.height);
        rows_ = std::move(rows);
        rows_height_ = camera.height;
        return {};
    }

    Result<void> reserve_pixels(const ViewCamera& camera) {
        const std::size_t pixels = pixel_count(SurfaceRaster::resolve_pitch(camera.width), camera.height);
        const GpuMemory memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::device;
        if (8 * pixels > device_->facts().limits.max_storage_buffer_range)
            return gpu_error("a picture of " + size_text(camera.width, camera.height) +
                                 " pixels is too large for the painter raster on " + device_->facts().name +
                                 "; mesh draws it",
                             {{Setting::painter, "mesh"}});
        TRY(pixels_.reserve(*device_, "picture pixels", 8 * pixels, GpuMemory::device));
        TRY(colours_.reserve(*device_, "picture colours", 4 * pixels, memory));
        TRY(z_values_.reserve(*device_, "picture z", 4 * pixels, memory));
        return large_.reserve(*device_, "large cells",
                              SurfaceRaster::large_bytes(lattice_.width, lattice_.height), GpuMemory::device);
    }

    /// Draws into memory that no commands read: earlier recorded pictures keep theirs.
    Result<void> draw_by_cpu(const GpuCommands& commands, const ViewCamera& camera) {
        const int pitch = SurfaceRaster::resolve_pitch(camera.width);
        const std::size_t bytes = 4 * pixel_count(pitch, camera.height);
        for (auto& [buffer, name] :
             {std::pair<GpuBuffer&, const char*>{colours_, "picture colours"}, {z_values_, "picture z"}}) {
            buffer = {};
            TRY_ASSIGN(buffer, pictures_.lease(name, bytes));
        }
        const auto background = rows_.mapped<PackedColour>(), colours = colours_.mapped<PackedColour>();
        const auto z = z_values_.mapped<float>();
        const ViewCamera seen = decimated(camera, lattice_.step);
        const MappedLattice lattice{lattice_.q.mapped<float>().data(),
                                    lattice_.colours.mapped<PackedColour>().data(),
                                    lattice_.width,
                                    lattice_.height,
                                    lattice_.pitch,
                                    lattice_.step,
                                    lattice_.fills_gaps};
        if (OwnViewPicture::draws(seen)) {
            own_view_.draw(lattice, seen, background, pitch, colours, z);
            return {};
        }
        find_edges(commands, seen);
        turned_view_->draw(lattice, *edges_, seen, background, pitch, colours, z);
        if (!is_own_view(seen)) silhouettes_.smooth(colours, z, camera.width, camera.height, pitch);
        return {};
    }

    /// Finds the edges of the surface for a camera's view, once per surface.
    void find_edges(const GpuCommands& commands, const ViewCamera& camera) {
        if (is_own_view(camera)) {
            edges_->clear();
            edged_.reset();
        } else if (!edged_.is_there_for(commands)) {
            edges_->find(edge_lattice(lattice_.q.mapped<float>().data(), lattice_.width, lattice_.height,
                                      lattice_.pitch, lattice_.step, lattice_.focal_length));
            edged_.by(commands);
        }
    }

    /// Records what is drawn of the surface, once for the clip's own view or for turned ones.
    Result<void> list_triangles(GpuCommands& commands, const ViewCamera& camera) {
        const bool is_turned = !is_own_view(camera);
        if (listed_.is_there_for(commands) && is_listed_turned_ == is_turned) return {};
        TRY(lattices_.record_view(commands, is_turned, lattice_));
        listed_.by(commands);
        is_listed_turned_ = is_turned;
        return {};
    }

    /// Makes colours and z of the surface, unless they are already those of this surface and camera.
    Result<void> draw_surface(GpuCommands& commands, const ViewCamera& camera) {
        if (drawn_.is_there_for(commands) && drawn_from_.clip_from_lattice == camera.clip_from_lattice &&
            drawn_from_.width == camera.width && drawn_from_.height == camera.height)
            return {};
        drawn_.reset();
        if (by_cpu_) {
            TRY(draw_by_cpu(commands, camera));
        } else {
            TRY(reserve_pixels(camera));
            TRY(record_raster(commands, camera));
        }
        drawn_.by(commands);
        drawn_from_ = camera;
        return {};
    }

    Result<void> record_raster(GpuCommands& commands, const ViewCamera& camera) {
        TRY(list_triangles(commands, camera));
        commands.barrier(GpuStage::compute, GpuStage::compute);
        commands.barrier(GpuStage::compute, GpuStage::indirect);
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        commands.barrier(GpuStage::transfer, GpuStage::compute);
        raster_->record(commands, lattice_, camera, pixels_, SurfaceRaster::resolve_pitch(camera.width),
                        large_);
        commands.mark("raster");
        commands.barrier(GpuStage::compute, GpuStage::compute);
        raster_->record_resolve(commands, camera, pixels_, rows_, colours_, z_values_);
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        commands.mark("resolve");
        return {};
    }

    /// Copies the raster's output into images, in layouts for drawing.
    void record_copies(GpuCommands& commands, const ViewCamera& camera, const GpuImage& target) const {
        const int pitch = SurfaceRaster::resolve_pitch(camera.width);
        copy_to_image(commands, colours_, pitch, target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        copy_to_image(commands, z_values_, pitch, z_, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    }

    /// Draws the fingers' dents over the drawn surface.
    Result<void> record_dents(GpuCommands& commands, const ViewCamera& camera,
                              std::span<const FingerMark> fingers, const MarkSizes& sizes,
                              const GpuImage& target) {
        if (dents_) return dents_->record(commands, fingers, sizes, camera, target, z_);
        if (!shown_.is_there_for(commands)) return {};
        const FlatPicture flat{colours_.mapped<PackedColour>(), z_values_.mapped<float>(), camera.width,
                               camera.height, SurfaceRaster::resolve_pitch(camera.width)};
        return dent_patches_.record(commands, fingers, sizes, camera, flat, target);
    }

    /// Draws background, and the surface if there is one.
    Result<void> record_mesh(GpuCommands& commands, const ViewCamera& camera, const GpuImage& target) {
        const bool is_shown = shown_.is_there_for(commands);
        if (is_shown) TRY(list_triangles(commands, camera));
        commands.barrier(GpuStage::compute, GpuStage::graphics);
        commands.barrier(GpuStage::compute, GpuStage::indirect);
        record_transition(commands, target, VK_IMAGE_LAYOUT_UNDEFINED,
                          VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        record_transition(commands, z_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
        begin_drawing(commands, {target, &z_, false, VK_ATTACHMENT_LOAD_OP_DONT_CARE});
        background_.bind(commands, {rows_});
        vkCmdDraw(commands.handle(), 3, 1, 0, 0);
        if (is_shown) mesh_->draw(commands, lattice_, camera);
        end_drawing(commands);
        return {};
    }

    std::shared_ptr<GpuDevice> device_;
    std::optional<SurfaceRaster> raster_;
    std::optional<MeshPipeline> mesh_;          // one of the two is set
    OwnViewPicture own_view_;                   // replaces the raster on a software device, if it supports
                                                // the view
    std::optional<LatticeRaster> turned_view_;  // for other views there
    std::optional<SurfaceEdges> edges_;         // for turned_view_
    Silhouettes silhouettes_;                   // of its pictures
    GpuLattices lattices_;
    SurfaceLighting lighting_;
    std::optional<CpuLattices> by_cpu_;     // replaces lattices_ and lighting_ on a software device
    std::optional<Decimation> decimation_;  // for by_cpu_
    std::optional<DentDrawing> dents_;
    DentPatches dent_patches_;  // replaces dents_ if the CPU draws the surface
    FingerDrawing fingers_;
    GraphicsProgram background_;

    GpuLattice lattice_;
    GpuCommands::Made shown_;       // the surface
    GpuCommands::Made listed_;      // what is drawn of it
    bool is_listed_turned_ = false;
    GpuCommands::Made edged_;       // its edges, if the CPU draws
    GpuBuffer pixels_, large_;      // for the raster
    GpuBuffer colours_, z_values_;  // surface and background, copied into images
    UploadPool pictures_;           // colours_ and z_values_, if the CPU writes them
    GpuCommands::Made drawn_;       // colours_ and z_values_
    ViewCamera drawn_from_;         // their camera
    GpuBuffer rows_;                // colours of the background
    int rows_height_ = 0;
    GpuImage z_;
};

}  // namespace

Result<std::unique_ptr<SurfaceDrawing>> SurfaceDrawing::create(std::shared_ptr<GpuDevice> device,
                                                               std::string_view painter) {
    if (painter != "auto" && painter != "raster" && painter != "mesh")
        return usage_error(
            "painter " + std::string(painter) + " does not draw on a GPU; auto, raster and mesh do",
            {{Setting::painter}});
    if (!device->facts().draws_triangles)
        return gpu_error(device->facts().name + " draws no triangles, which a window needs");
    TRY_ASSIGN(auto fingers, FingerDrawing::create(device));
    auto made = std::make_unique<DeviceDrawing>(std::move(device), std::move(fingers));
    TRY(made->prepare(painter));
    return made;
}

int SurfaceDrawing::step_for(double pixels_per_vertex) {
    constexpr double most_apart = 1.5;  // pixels
    constexpr int most = 8;
    int step = 1;
    while (step < most && pixels_per_vertex * 2 * step <= most_apart) step *= 2;
    return step;
}

}  // namespace touchable
