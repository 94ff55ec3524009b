#pragma once

#include <cstdint>
#include <memory>

#include "engine/gpu/gpu_buffer.hpp"
#include "player/view/view_surface.hpp"

namespace touchable {

/// A lattice in the GPU's memory, as painters there read it.
struct GpuLattice {
    int width = 0, height = 0;
    GpuBuffer q;        ///< floats, row-major
    GpuBuffer colours;  ///< PackedColour, row-major
    GpuBuffer tiles;    ///< ViewTiles: the whole ones, then the mixed ones
    std::uint32_t whole_tiles = 0, mixed_tiles = 0;
};

/// Puts surfaces where the GPU reads them, one at a time into the same buffers: who uploads the next has
/// waited for what reads the last.
class LatticeUpload {
public:
    explicit LatticeUpload(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}
    Result<GpuLattice> upload(const ViewSurface& surface);

private:
    Result<void> reserve(GpuBuffer& buffer, const char* name, std::size_t bytes);

    std::shared_ptr<GpuDevice> device_;
    GpuLattice lattice_;
};

}  // namespace touchable
