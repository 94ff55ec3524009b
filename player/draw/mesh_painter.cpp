#include <algorithm>

#include "engine/base/try.hpp"
#include "player/draw/gpu_lattice.hpp"
#include "player/draw/gpu_painters.hpp"
#include "player/draw/mesh_pipeline.hpp"

namespace touchable {
namespace {

/// The whole image, rows packed, once it has been drawn.
void record_copy(GpuCommands& commands, const GpuImage& image, const GpuBuffer& buffer) {
    VkBufferImageCopy region{};
    region.imageSubresource = {image.aspect(), 0, 0, 1};
    region.imageExtent = {image.extent().width, image.extent().height, 1};
    vkCmdCopyImageToBuffer(commands.handle(), image.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           buffer.handle(), 1, &region);
    commands.keep(buffer.keep_alive());
}

class MeshPainter final : public SurfacePainter {
public:
    MeshPainter(std::shared_ptr<GpuDevice> device, MeshPipeline pipeline)
        : device_(std::move(device)), pipeline_(std::move(pipeline)), lattices_(device_) {}

    std::string_view name() const override { return "mesh"; }

    std::string gpu_name() const override { return device_->facts().name; }

    Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair,
                                   const PlaneView& colour) override {
        return lattices_.surface_of(field, pair, colour);
    }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        TRY_ASSIGN(auto lattice, lattices_.lattice_of(surface));
        const std::size_t pixels =
            static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        TRY_ASSIGN(const auto colour, GpuImage::create(*device_, "picture colour", camera.width,
                                                       camera.height, MeshPipeline::colour_format));
        TRY_ASSIGN(const auto z, GpuImage::create(*device_, "picture z", camera.width, camera.height,
                                                  MeshPipeline::z_format));
        TRY_ASSIGN(const auto colour_back,
                   GpuBuffer::create(*device_, "picture colour read back", pixels * 4, GpuMemory::readback));
        TRY_ASSIGN(const auto z_back,
                   GpuBuffer::create(*device_, "picture z read back", pixels * 4, GpuMemory::readback));

        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "mesh"));
        if (auto moved = lattices_.record_edges(commands, camera, surface.colours_are_values, lattice);
            !moved.ok())
            return moved.error();
        commands.barrier(GpuStage::compute, GpuStage::graphics);
        pipeline_.record(commands, lattice, camera, colour, z);
        record_copy(commands, colour, colour_back);
        record_copy(commands, z, z_back);
        TRY_ASSIGN(const auto submission, std::move(commands).submit());
        TRY(submission.wait_for_picture());

        const auto z_read = z_back.mapped<float>();
        const auto colour_read = colour_back.mapped<PackedColour>();
        return PicturePlanes{camera.width, camera.height, std::vector<float>(z_read.begin(), z_read.end()),
                             std::vector<PackedColour>(colour_read.begin(), colour_read.end())};
    }

private:
    std::shared_ptr<GpuDevice> device_;
    MeshPipeline pipeline_;
    GpuLattices lattices_;
};

}  // namespace

Result<std::unique_ptr<SurfacePainter>> make_mesh_painter(std::shared_ptr<GpuDevice> device) {
    TRY_ASSIGN(auto pipeline, MeshPipeline::create(*device));
    return std::unique_ptr<SurfacePainter>(
        std::make_unique<MeshPainter>(std::move(device), std::move(pipeline)));
}

}  // namespace touchable
