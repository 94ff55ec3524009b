#pragma once

#include <memory>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_program.hpp"
#include "player/draw/view_surface.hpp"

namespace touchable {

struct GpuLattice;

/// The kernels cut_tiles and list_tiles: q of a lattice to the tiles worth drawing. The twin of
/// `CpuLattices::tiles_of`: from the same q, the same lists.
class TileLists {
public:
    explicit TileLists(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}

    /// Records the kernels: from the lattice's q to its tiles, once that is written.
    Result<void> record(GpuCommands& commands, const GpuLattice& lattice);
    static std::size_t class_bytes(int width, int height);
    static std::size_t list_bytes(int width, int height);

private:
    std::shared_ptr<GpuDevice> device_;
    GpuProgram cut_, list_;  // made when first needed
};

/// Lists in mapped memory, as kernels and indirect commands read them (shaders/tile_lists.h), and back.
void write_tiles(const ViewTiles& tiles, const GpuBuffer& buffer);
ViewTiles read_tiles(const GpuBuffer& buffer);

}  // namespace touchable
