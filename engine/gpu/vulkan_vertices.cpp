#include "engine/gpu/vulkan_vertices.hpp"

#include "engine/base/try.hpp"

namespace touchable {

Result<SharedPlane> SharedPlane::create(const GpuDevice& device, const std::string& name, std::size_t bytes,
                                        bool copied) {
    TRY_ASSIGN(auto gpu,
               GpuBuffer::create(device, name, bytes, copied ? GpuMemory::device : GpuMemory::shared));
    if (!copied) return SharedPlane{gpu, gpu};
    TRY_ASSIGN(auto host, GpuBuffer::create(device, name + " read back", bytes, GpuMemory::readback));
    return SharedPlane{gpu, host};
}

Result<std::unique_ptr<VulkanVertices>> VulkanVertices::create(const GpuDevice& device,
                                                               const SurfaceFrame& frame, int width,
                                                               int height, bool copied) {
    std::unique_ptr<VulkanVertices> made(new VulkanVertices(device, frame, width, height));
    const auto rows = static_cast<std::size_t>(height), columns = static_cast<std::size_t>(width);
    const TileGrid grid = TileGrid::of(width, height);
    const std::tuple<SharedPlane&, const char*, std::size_t> planes[] = {
        {made->codes, "codes", rows * ((columns + 7) / 8) * 16},
        {made->validity, "validity", rows * ((columns + 31) / 32) * sizeof(std::uint32_t)},
        {made->tiles, "tiles",
         static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y) *
             sizeof(TileBounds)}};
    for (const auto& [plane, name, bytes] : planes) {
        TRY_ASSIGN(auto created, SharedPlane::create(device, name, bytes, copied));
        plane = created;
    }
    return made;
}

bool VulkanVertices::serves(const GpuDevice& device, int width, int height, bool copied) const {
    return codes.is_copied() == copied && is_on(device) && width_ == width && height_ == height;
}

}  // namespace touchable
