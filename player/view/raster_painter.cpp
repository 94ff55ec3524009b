#include <algorithm>
#include <bit>
#include <cstdint>

#include "player/view/gpu_painters.hpp"
#include "player/view/surface_raster.hpp"
#include "player/view/surface_unproject.hpp"

namespace touchable {
namespace {

class RasterPainter final : public SurfacePainter {
public:
    RasterPainter(std::shared_ptr<GpuDevice> device, SurfaceRaster raster)
        : device_(std::move(device)), unproject_(device_), raster_(std::move(raster)), upload_(device_) {}

    std::string_view name() const override { return "raster"; }

    Result<std::vector<float>> q_of(const HeightField& field, const FramePair& pair) override {
        return unproject_.q_of(field, pair);
    }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        const auto lattice = upload_.upload(surface);
        if (!lattice.ok()) return lattice.error();
        const std::size_t bytes =
            std::size_t{8} * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        if (bytes > device_->facts().limits.max_storage_buffer_range)
            return Error{ErrorKind::gpu, "a picture of " + std::to_string(camera.width) + "x" +
                                             std::to_string(camera.height) +
                                             " samples is too large for --painter "
                                             "raster on " +
                                             device_->facts().name + "; cpu and mesh draw it"};
        // Atomics want the GPU's own memory; what the CPU reads it copies.
        const bool unified = device_->facts().unified_memory;
        auto pixels = GpuBuffer::create(*device_, "picture pixels", bytes,
                                        unified ? GpuMemory::shared : GpuMemory::device);
        if (!pixels.ok()) return pixels.error();
        auto large =
            GpuBuffer::create(*device_, "large cells",
                              SurfaceRaster::large_bytes(surface.width, surface.height), GpuMemory::device);
        if (!large.ok()) return large.error();
        GpuBuffer result = *pixels;
        if (!unified) {
            auto readback = GpuBuffer::create(*device_, "picture read back", bytes, GpuMemory::readback);
            if (!readback.ok()) return readback.error();
            result = *readback;
        }

        auto commands = GpuCommands::begin(device_, "raster");
        if (!commands.ok()) return commands.error();
        raster_.record(*commands, *lattice, camera, *pixels, *large);
        if (!unified) {
            commands->barrier(GpuStage::compute, GpuStage::transfer);
            commands->copy(*pixels, 0, result, 0, bytes);
        }
        const auto submission = std::move(*commands).submit();
        if (!submission.ok()) return submission.error();
        if (auto done = submission->wait(); !done.ok()) return done.error();
        return unpacked(result.mapped<std::uint64_t>(), camera);
    }

private:
    static PicturePlanes unpacked(std::span<const std::uint64_t> pixels, const ViewCamera& camera) {
        PicturePlanes planes{camera.width, camera.height, {}, {}};
        planes.z.reserve(pixels.size());
        planes.colours.reserve(pixels.size());
        for (const std::uint64_t pixel : pixels) {
            planes.z.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(pixel >> 32)));
            planes.colours.push_back(static_cast<PackedColour>(pixel));
        }
        return planes;
    }

    std::shared_ptr<GpuDevice> device_;
    SurfaceUnproject unproject_;
    SurfaceRaster raster_;
    LatticeUpload upload_;
};

}  // namespace

Result<std::unique_ptr<SurfacePainter>> make_raster_painter(std::shared_ptr<GpuDevice> device) {
    auto raster = SurfaceRaster::create(*device);
    if (!raster.ok()) return raster.error();
    return std::unique_ptr<SurfacePainter>(
        std::make_unique<RasterPainter>(std::move(device), std::move(*raster)));
}

}  // namespace touchable
