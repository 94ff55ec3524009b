// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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

// SurfaceDrawing: on a GPU, and by the CPU's vectors with fingers drawn on a GPU. A GPU's drawing caches a
// picture's inputs: the lattice of the shown surface, its tiles and edges, the raster's pixels, the images.
// GpuCommands::Made says for each whether it is valid for the commands being recorded.

namespace touchable {
namespace {

/// Makes z for pictures of that size, unless it is there.
Result<void> reserve_z(const GpuDevice& device, int width, int height, GpuImage& z) {
    if (z && z.is_of_size(width, height)) return {};
    return assign(z, GpuImage::create(device, "picture z", width, height, GraphicsLook::z_format));
}

Error not_of_its_size() {
    return internal_error("a picture is not of its camera's size");
}

class CpuDrawingOnDevice final : public SurfaceDrawing {
public:
    CpuDrawingOnDevice(std::shared_ptr<GpuDevice> device, FingerDrawing fingers)
        : device_(std::move(device)), pictures_(device_), fingers_(std::move(fingers)) {}

    std::string_view painter() const override { return "cpu"; }
    bool thins_vertices() const override { return true; }

    Result<void> show(GpuCommands&, const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting, int step) override {
        TRY(check_colour(colour, field.width(), field.height()));
        painted_.reset();
        surface_.show(field, pair, colour, lighting, step);
        return {};
    }

    Result<void> draw(GpuCommands& commands, const ViewCamera& camera, std::span<const FingerMark> fingers,
                      const MarkSizes& sizes, const GpuImage& target) override {
        const int times = static_cast<int>(target.extent().width) / camera.width;
        ViewCamera seen = camera;  // of the target's size
        seen.width *= times;
        seen.height *= times;
        seen.focal *= times;
        if ((times != 1 && times != 2 && times != 4) || !target.is_of_size(seen.width, seen.height))
            return not_of_its_size();
        TRY(reserve_z(*device_, seen.width, seen.height, z_));
        TRY(paint(camera, times));
        TRY_ASSIGN(const auto colours, finished(camera, times, dents_.shape(fingers, sizes, camera)));
        copy_to_image(commands, colours, 0, target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        copy_to_image(commands, z_values_, 0, z_, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
        commands.mark("picture");
        TRY(fingers_.record(commands, fingers, sizes, seen, target, z_));
        if (!fingers.empty()) commands.mark("fingers");
        return {};
    }

private:
    /// What `bare_` and `z_values_` show.
    struct Painted {
        glm::dmat4 clip_from_lattice;
        int width, height, times;
        bool operator==(const Painted&) const = default;
    };

    // Memory for uploads is written once and in order: the CPU may read it slowly.

    Result<void> paint(const ViewCamera& camera, int times) {
        const Painted wanted{camera.clip_from_lattice, camera.width, camera.height, times};
        if (painted_ == wanted) return {};
        painted_.reset();
        z_values_ = plain_ = {};
        bare_.resize(pixel_count(camera.width, camera.height));
        bare_z_.resize(bare_.size());
        surface_.paint(camera, bare_, bare_z_);
        TRY_ASSIGN(z_values_, pictures_.lease("picture z",
                                              4 * pixel_count(camera.width * times, camera.height * times)));
        float* to = z_values_.mapped<float>().data();
        std::vector<float> row(static_cast<std::size_t>(camera.width * times));
        for (int y = 0; y < camera.height; ++y) {
            const float* const from = bare_z_.data() + pixel_place(0, y, camera.width);
            for (int x = 0; x < camera.width; ++x) std::fill_n(row.data() + x * times, times, from[x]);
            for (int n = 0; n < times; ++n) to = std::ranges::copy(row, to).out;
        }
        painted_ = wanted;
        return {};
    }

    /// The picture, with dents if there are some, stretched.
    Result<GpuBuffer> finished(const ViewCamera& camera, int times, bool is_dented) {
        if (plain_ && !is_dented) return plain_;
        if (is_dented) {
            dented_ = bare_;
            dents_.draw({bare_, bare_z_, camera.width, camera.height}, dented_);
        }
        const std::vector<PackedColour>& picture = is_dented ? dented_ : bare_;
        const auto factor = static_cast<std::size_t>(times);
        TRY_ASSIGN(auto made, pictures_.lease("picture", 4 * factor * factor * picture.size()));
        const auto to = made.mapped<PackedColour>();
        if (times == 1) {
            std::ranges::copy(picture, to.begin());
        } else if (times == 2) {
            double_picture(picture, camera.width, camera.height, to);
        } else {
            halves_.resize(4 * picture.size());
            double_picture(picture, camera.width, camera.height, halves_);
            double_picture(halves_, 2 * camera.width, 2 * camera.height, to);
        }
        if (!is_dented) plain_ = made;
        return made;
    }

    std::shared_ptr<GpuDevice> device_;
    CpuSurface surface_;
    UploadPool pictures_;
    DentPatches dents_;
    FingerDrawing fingers_;
    std::optional<Painted> painted_;
    std::vector<PackedColour> bare_, dented_, halves_;  // surface and background
    std::vector<float> bare_z_;
    GpuBuffer plain_, z_values_;  // without dents, and z; stretched
    GpuImage z_;
};

class DeviceDrawing final : public SurfaceDrawing {
public:
    DeviceDrawing(std::shared_ptr<GpuDevice> device, FingerDrawing fingers)
        : device_(std::move(device)), lattices_(device_), lighting_(device_), fingers_(std::move(fingers)) {}

    /// Creates the resources of the painter with that name.
    Result<void> prepare(std::string_view painter) {
        if (painter == "mesh") {
            TRY_ASSIGN(mesh_, MeshPipeline::create(*device_));
        } else {
            TRY_ASSIGN(raster_, SurfaceRaster::create(*device_));
        }
        TRY_ASSIGN(dents_, DentDrawing::create(device_));
        TRY(lattices_.make_programs());
        TRY(lighting_.make_program());
        return assign(background_, GraphicsProgram::create(*device_, "background",
                                                           {.vertex = view_screen_vert_spv,
                                                            .fragment = view_background_frag_spv,
                                                            .bindings = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                                            .depth = DrawDepth::replaced}));
    }

    std::string_view painter() const override { return raster_ ? "raster" : "mesh"; }
    bool thins_vertices() const override { return false; }
    Result<void> show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                      const PlaneView& colour, Lighting lighting, int /*step*/) override {
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

    Result<void> draw(GpuCommands& commands, const ViewCamera& camera, std::span<const FingerMark> fingers,
                      const MarkSizes& sizes, const GpuImage& target) override {
        if (!target.is_of_size(camera.width, camera.height)) return not_of_its_size();
        TRY(reserve(camera));
        if (raster_ && shown_.is_there_for(commands)) {
            TRY(draw_surface(commands, camera));
            record_copies(commands, camera, target);
        } else {
            TRY(record_mesh(commands, camera, target));
        }
        commands.mark("picture");
        TRY(dents_->record(commands, fingers, sizes, camera, target, z_));
        TRY(fingers_.record(commands, fingers, sizes, camera, target, z_));
        if (!fingers.empty()) commands.mark("fingers");
        return {};
    }

private:
    /// Invalidates everything until the new surface is made.
    Result<void> begin_surface(const HeightField& field, const PlaneView& colour, Lighting lighting) {
        for (GpuCommands::Made* const made : {&shown_, &listed_, &drawn_}) made->reset();
        lattice_.fills_gaps = fills_gaps(colour, lighting);
        return check_colour(colour, field.width(), field.height());
    }

    /// Resources for pictures of the camera's size.
    Result<void> reserve(const ViewCamera& camera) {
        TRY(reserve_z(*device_, camera.width, camera.height, z_));
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
        if (8 * pixels > device_->facts().limits.max_storage_buffer_range)
            return gpu_error("a picture of " + size_text(camera.width, camera.height) +
                                 " pixels is too large for the painter raster on " + device_->facts().name +
                                 "; mesh draws it",
                             {{Setting::painter, "mesh"}});
        TRY(pixels_.reserve(*device_, "picture pixels", 8 * pixels, GpuMemory::device));
        TRY(colours_.reserve(*device_, "picture colours", 4 * pixels, GpuMemory::device));
        TRY(z_values_.reserve(*device_, "picture z", 4 * pixels, GpuMemory::device));
        return large_.reserve(*device_, "large cells",
                              SurfaceRaster::large_bytes(lattice_.width, lattice_.height), GpuMemory::device);
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
        TRY(reserve_pixels(camera));
        TRY(record_raster(commands, camera));
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
    std::optional<MeshPipeline> mesh_;  // one of the two is set
    GpuLattices lattices_;
    SurfaceLighting lighting_;
    std::optional<DentDrawing> dents_;
    FingerDrawing fingers_;
    GraphicsProgram background_;

    GpuLattice lattice_;
    GpuCommands::Made shown_;       // the surface
    GpuCommands::Made listed_;      // what is drawn of it
    bool is_listed_turned_ = false;
    GpuBuffer pixels_, large_;      // for the raster
    GpuBuffer colours_, z_values_;  // surface and background, copied into images
    GpuCommands::Made drawn_;       // colours_ and z_values_
    ViewCamera drawn_from_;         // their camera
    GpuBuffer rows_;                // colours of the background
    int rows_height_ = 0;
    GpuImage z_;
};

}  // namespace

Result<std::unique_ptr<SurfaceDrawing>> SurfaceDrawing::create(std::shared_ptr<GpuDevice> device,
                                                               std::string_view painter) {
    const std::string named(painter == "auto" ? usual_painter(device->facts()) : painter);
    if (named != "cpu" && named != "raster" && named != "mesh")
        return usage_error("painter " + named + " is not known; auto, cpu, raster and mesh are",
                           {{Setting::painter}});
    if (!device->facts().draws_triangles)
        return gpu_error(device->facts().name + " draws no triangles, which a window needs");
    TRY_ASSIGN(auto fingers, FingerDrawing::create(device));
    if (named == "cpu") return std::make_unique<CpuDrawingOnDevice>(std::move(device), std::move(fingers));
    auto made = std::make_unique<DeviceDrawing>(std::move(device), std::move(fingers));
    TRY(made->prepare(named));
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
