#include <algorithm>
#include <bit>
#include <cstdint>

#include "engine/base/try.hpp"
#include "player/draw/gpu_lattice.hpp"
#include "player/draw/gpu_painters.hpp"
#include "player/draw/surface_raster.hpp"

namespace touchable {
namespace {

class RasterPainter final : public SurfacePainter {
public:
    RasterPainter(std::shared_ptr<GpuDevice> device, SurfaceRaster raster)
        : device_(std::move(device)), raster_(std::move(raster)), lattices_(device_) {}

    std::string_view name() const override { return "raster"; }

    std::string gpu_name() const override { return device_->facts().name; }

    Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair,
                                   const PlaneView& colour) override {
        return lattices_.surface_of(field, pair, colour);
    }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        TRY_ASSIGN(auto lattice, lattices_.lattice_of(surface));
        const std::size_t bytes =
            std::size_t{8} * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
        if (bytes > device_->facts().limits.max_storage_buffer_range)
            return Error{ErrorKind::gpu,
                         "a picture of " + std::to_string(camera.width) + "x" +
                             std::to_string(camera.height) +
                             " samples is too large for the painter raster on " + device_->facts().name +
                             "; cpu and mesh draw it",
                         {{Setting::painter, "mesh"}}};
        const std::size_t large_bytes = SurfaceRaster::large_bytes(surface.width, surface.height);
        TRY(reserve(bytes, large_bytes));

        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "raster"));
        if (auto moved = lattices_.record_edges(commands, camera, surface.colours_are_values, lattice);
            !moved.ok())
            return moved.error();
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
    /// Room for a picture and for large cells; what the last one had serves again where it is large enough.
    Result<void> reserve(std::size_t bytes, std::size_t large_bytes) {
        if (!large_ || large_.bytes() < large_bytes) {
            TRY_ASSIGN(auto large,
                       GpuBuffer::create(*device_, "large cells", large_bytes, GpuMemory::device));
            large_ = std::move(large);
        }
        if (pixels_ && pixels_.bytes() >= bytes) return {};
        // Atomics want the GPU's own memory; what the CPU reads it copies.
        const bool unified = device_->facts().unified_memory;
        auto pixels = GpuBuffer::create(*device_, "picture pixels", bytes,
                                        unified ? GpuMemory::shared : GpuMemory::device);
        if (!pixels.ok()) return pixels.error();
        TRY_ASSIGN(
            auto seen,
            unified ? pixels : GpuBuffer::create(*device_, "picture read back", bytes, GpuMemory::readback));
        pixels_ = std::move(*pixels);
        seen_ = std::move(seen);
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

    std::shared_ptr<GpuDevice> device_;
    SurfaceRaster raster_;
    GpuLattices lattices_;
    GpuBuffer pixels_, large_, seen_;  // seen_: the pixels, where the CPU reads them
};

}  // namespace

Result<std::unique_ptr<SurfacePainter>> make_raster_painter(std::shared_ptr<GpuDevice> device) {
    TRY_ASSIGN(auto raster, SurfaceRaster::create(*device));
    return std::unique_ptr<SurfacePainter>(
        std::make_unique<RasterPainter>(std::move(device), std::move(raster)));
}

}  // namespace touchable
