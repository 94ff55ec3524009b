#include "player/view/gpu_lattice.hpp"

#include <algorithm>
#include <cstring>

namespace touchable {

Result<void> LatticeUpload::reserve(GpuBuffer& buffer, const char* name, std::size_t bytes) {
    if (buffer && buffer.bytes() >= bytes) return {};
    const auto memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload;
    auto made = GpuBuffer::create(*device_, name, std::max<std::size_t>(bytes, 16), memory);
    if (!made.ok()) return made.error();
    buffer = std::move(*made);
    return {};
}

namespace {
template <class T>
void put(const std::vector<T>& values, const GpuBuffer& buffer, std::size_t at) {
    if (!values.empty())
        std::memcpy(buffer.mapped<T>().data() + at, values.data(), values.size() * sizeof(T));
}
}  // namespace

Result<GpuLattice> LatticeUpload::upload(const ViewSurface& surface) {
    const ViewTiles& tiles = surface.tiles;
    for (auto done :
         {reserve(lattice_.q, "lattice q", surface.q.size() * 4),
          reserve(lattice_.colours, "lattice colours", surface.colours.size() * 4),
          reserve(lattice_.tiles, "lattice tiles", (tiles.whole.size() + tiles.mixed.size()) * 4)})
        if (!done.ok()) return done.error();
    lattice_.width = surface.width;
    lattice_.height = surface.height;
    lattice_.whole_tiles = static_cast<std::uint32_t>(tiles.whole.size());
    lattice_.mixed_tiles = static_cast<std::uint32_t>(tiles.mixed.size());
    put(surface.q, lattice_.q, 0);
    put(surface.colours, lattice_.colours, 0);
    put(tiles.whole, lattice_.tiles, 0);
    put(tiles.mixed, lattice_.tiles, tiles.whole.size());
    return lattice_;
}

}  // namespace touchable
