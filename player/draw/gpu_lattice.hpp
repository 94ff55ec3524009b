#pragma once

#include <memory>

#include "engine/gpu/gpu_buffer.hpp"
#include "player/draw/surface_unproject.hpp"
#include "player/draw/tile_lists.hpp"
#include "player/draw/view_camera.hpp"
#include "player/draw/view_surface.hpp"

namespace touchable {

/// A lattice in a GPU's memory, as painters there read it.
struct GpuLattice {
    std::shared_ptr<VulkanDevice> vulkan;  ///< whose memory it is
    int width = 0, height = 0;
    int pitch = 0;      ///< vertices from one row of q and colours to the next
    int step = 1;       ///< of the clip's pixels, from vertex to vertex (Decimation)
    GpuBuffer q;        ///< floats, row-major
    GpuBuffer colours;  ///< PackedColour, row-major
    GpuBuffer tiles;    ///< which ones to draw: shaders/tile_lists.h
    GpuBuffer classes;  ///< of each tile, between the kernels that find them
    GpuBuffer edges;    ///< where vertices at edges are drawn: shaders/edges.h; for turned views
};

/// Rows of a lattice's width into its q, which is mapped.
void put_q(const std::vector<float>& q, const GpuLattice& lattice);

/// Makes lattices on a device: from codes by kernels, or from what the CPU made.
class GpuLattices {
public:
    explicit GpuLattices(std::shared_ptr<GpuDevice> device)
        : device_(std::move(device)), unproject_(device_), tile_lists_(device_), uploads_(device_) {}

    /// Records what makes q of a pair of frames; by the CPU where they have no codes
    /// (SurfaceUnproject::has_codes). Buffers of `lattice` that are large enough serve again: whoever
    /// reads them has been recorded before, and a barrier after it.
    Result<void> record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                        GpuLattice& lattice);
    /// And tiles, once q is written.
    Result<void> record_tiles(GpuCommands& commands, GpuLattice& lattice);

    /// And where vertices at edges are drawn, once q is written: the twin of SurfaceEdges, the same bits. For
    /// the clip's own view nothing. `are_values`: as there.
    Result<void> record_edges(GpuCommands& commands, const ViewCamera& camera, bool are_values,
                              GpuLattice& lattice);

    /// `make_view_surface`, with q and tiles by `record`, which stay on the GPU beside; where the frames have
    /// no codes, that of CpuLattices.
    Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair, const PlaneView& colour);

    /// A surface where painters on this device read it: only colours are uploaded where the rest is there.
    /// One at a time into the same buffers: who asks for the next has waited for what reads the last.
    Result<GpuLattice> lattice_of(const ViewSurface& surface);

    /// Room for colours of a lattice, if it has none that are large enough.
    Result<void> reserve_colours(GpuLattice& lattice);

    /// q and colours for a field that the CPU writes, whoever still reads the last ones.
    Result<void> renew(const HeightField& field, GpuLattice& lattice);

private:
    Result<void> record_q(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                          const GpuLattice& lattice);
    Result<void> check_size(const char* name, std::size_t bytes) const;
    void set_size(const HeightField& field, GpuLattice& lattice) const;
    Result<void> reserve(GpuBuffer& buffer, const char* name, std::size_t bytes, GpuMemory memory);
    Result<GpuLattice> read_back(const HeightField& field, const FramePair& pair, GpuLattice& lattice);

    std::shared_ptr<GpuDevice> device_;
    SurfaceUnproject unproject_;
    TileLists tile_lists_;
    UploadPool uploads_;
    GpuProgram edges_;  // made when first needed
    GpuLattice uploaded_;
};

}  // namespace touchable
