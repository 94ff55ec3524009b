#include "player/draw/gpu_lattice.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "engine/base/try.hpp"
#include "player/draw/cpu_lattice.hpp"
#include "player/draw/decimation.hpp"
#include "player/draw/view_rows.hpp"
#include "shaders/edges.h"
#include "shaders/edges.spv.h"

namespace touchable {
namespace {

/// Rows of 4 bytes a vertex into rows of `pitch` vertices.
template <class T>
void put_rows(const std::vector<T>& values, const GpuLattice& lattice, const GpuBuffer& buffer) {
    const auto width = static_cast<std::size_t>(lattice.width),
               pitch = static_cast<std::size_t>(lattice.pitch);
    T* to = buffer.mapped<T>().data();
    for (std::size_t y = 0; y < static_cast<std::size_t>(lattice.height); ++y)
        std::memcpy(to + y * pitch, values.data() + y * width, width * sizeof(T));
}

}  // namespace

void put_q(const std::vector<float>& q, const GpuLattice& lattice) {
    // Beyond the width there is no vertex.
    std::memset(lattice.q.mapped<std::byte>().data(), 0,
                SurfaceUnproject::q_bytes(lattice.width, lattice.height));
    put_rows(q, lattice, lattice.q);
}

namespace {

std::vector<float> q_from(const GpuLattice& lattice) {
    const auto width = static_cast<std::size_t>(lattice.width),
               pitch = static_cast<std::size_t>(lattice.pitch);
    std::vector<float> q(width * static_cast<std::size_t>(lattice.height));
    for (std::size_t y = 0; y < static_cast<std::size_t>(lattice.height); ++y)
        std::memcpy(q.data() + y * width, lattice.q.mapped<float>().data() + y * pitch,
                    width * sizeof(float));
    return q;
}

}  // namespace

Result<void> GpuLattices::check_size(const char* name, std::size_t bytes) const {
    if (bytes <= device_->facts().limits.max_storage_buffer_range) return {};
    return Error{ErrorKind::gpu, std::string(name) + ": " + std::to_string(bytes) +
                                     " bytes are more than a kernel may read on " + device_->facts().name};
}

void GpuLattices::set_size(const HeightField& field, GpuLattice& lattice) const {
    lattice.vulkan = device_->vulkan();
    lattice.width = field.width();
    lattice.height = field.height();
    lattice.pitch = SurfaceUnproject::pitch(lattice.width);
    lattice.step = 1;
}

Result<void> GpuLattices::reserve(GpuBuffer& buffer, const char* name, std::size_t bytes, GpuMemory memory) {
    if (buffer && buffer.bytes() >= bytes) return {};
    if (auto fits = check_size(name, bytes); !fits.ok()) return fits;
    TRY_ASSIGN(auto made, GpuBuffer::create(*device_, name, bytes, memory));
    buffer = std::move(made);
    return {};
}

Result<void> GpuLattices::reserve_colours(GpuLattice& lattice) {
    return reserve(lattice.colours, "lattice colours",
                   SurfaceUnproject::q_bytes(lattice.width, lattice.height),  // as many of colours
                   device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::device);
}

Result<void> GpuLattices::renew(const HeightField& field, GpuLattice& lattice) {
    set_size(field, lattice);
    const std::size_t bytes = SurfaceUnproject::q_bytes(lattice.width, lattice.height);
    for (GpuBuffer* const buffer : {&lattice.q, &lattice.colours}) {
        *buffer = {};
        if (auto fits = check_size("lattice", bytes); !fits.ok()) return fits;
        TRY_ASSIGN(auto taken, uploads_.take("lattice", bytes));
        *buffer = std::move(taken);
    }
    return {};
}

Result<void> GpuLattices::record_q(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                   const GpuLattice& lattice) {
    if (SurfaceUnproject::has_codes(field, pair)) return unproject_.record(commands, field, pair, lattice.q);
    const std::size_t bytes = SurfaceUnproject::q_bytes(lattice.width, lattice.height);
    TRY_ASSIGN(const auto uploaded, uploads_.take("lattice q", bytes));
    // Beyond the width there is no vertex.
    std::memset(uploaded.mapped<std::byte>().data(), 0, bytes);
    put_rows(q_of(field), lattice, uploaded);
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    commands.copy(uploaded, 0, lattice.q, 0, bytes);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    return {};
}

Result<void> GpuLattices::record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                 GpuLattice& lattice) {
    set_size(field, lattice);
    const GpuMemory memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::device;
    const std::size_t bytes = SurfaceUnproject::q_bytes(lattice.width, lattice.height);
    if (auto done = reserve(lattice.q, "lattice q", bytes, memory); !done.ok()) return done;
    if (auto recorded = record_q(commands, field, pair, lattice); !recorded.ok()) return recorded;
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.mark("unproject");
    return {};
}

Result<void> GpuLattices::record_tiles(GpuCommands& commands, GpuLattice& lattice) {
    const GpuMemory memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::device;
    const int w = lattice.width, h = lattice.height;
    for (const auto& done :
         {reserve(lattice.tiles, "lattice tiles", TileLists::list_bytes(w, h), memory),
          reserve(lattice.classes, "tile classes", TileLists::class_bytes(w, h), GpuMemory::device)})
        if (!done.ok()) return done;
    if (auto recorded = tile_lists_.record(commands, lattice); !recorded.ok()) return recorded;
    commands.mark("tiles");
    return {};
}

Result<void> GpuLattices::record_edges(GpuCommands& commands, const ViewCamera& camera, bool are_values,
                                       GpuLattice& lattice) {
    if (is_own_view(camera)) return {};
    if (!edges_) {
        TRY_ASSIGN(auto made,
                   GpuProgram::create(*device_, "edges", edges_spv,
                                      {sizeof(EdgesPush),
                                       {GpuBindingKind::uniform_texels, GpuBindingKind::storage_buffer},
                                       {EDGES_LANES, 1, 1}}));
        edges_ = std::move(made);
    }
    const GpuMemory memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::device;
    const std::size_t bytes = 2 * SurfaceUnproject::q_bytes(lattice.width, lattice.height);
    if (auto done = reserve(lattice.edges, "lattice edges", bytes, memory); !done.ok()) return done;
    uploaded_.edges = lattice.edges;
    const EdgesPush push{
        static_cast<std::uint32_t>(lattice.width), static_cast<std::uint32_t>(lattice.height),
        static_cast<std::uint32_t>(lattice.pitch), cut_ratio(lattice.step), are_values ? 1U : 0U};
    commands.barrier(GpuStage::graphics, GpuStage::compute);
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.dispatch(edges_, push, {GpuBinding::words(lattice.q), lattice.edges},
                      {groups_for(push.pitch, EDGES_LANES), push.height});
    commands.mark("edges");
    return {};
}

/// Makes a lattice and gives q and tiles of it where the CPU reads them.
Result<GpuLattice> GpuLattices::read_back(const HeightField& field, const FramePair& pair,
                                          GpuLattice& lattice) {
    TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "lattice"));
    TRY(record(commands, field, pair, lattice));
    TRY(record_tiles(commands, lattice));
    GpuLattice seen = lattice;
    if (!device_->facts().unified_memory) {
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        for (GpuBuffer* buffer : {&seen.q, &seen.tiles}) {
            TRY_ASSIGN(auto made, GpuBuffer::create(*device_, buffer->name() + " read back", buffer->bytes(),
                                                    GpuMemory::readback));
            commands.copy(*buffer, 0, made, 0, buffer->bytes());
            *buffer = made;
        }
    }
    TRY_ASSIGN(const auto submission, std::move(commands).submit());
    TRY(submission.wait_for_picture());
    return seen;
}

Result<ViewSurface> GpuLattices::surface_of(const HeightField& field, const FramePair& pair,
                                            const PlaneView& colour) {
    if (!SurfaceUnproject::has_codes(field, pair))
        return CpuLattices(CpuLattices::usual_threads()).surface_of(field, pair, colour);
    auto lattice = std::make_shared<GpuLattice>();
    TRY_ASSIGN(const auto seen, read_back(field, pair, *lattice));
    ViewSurface surface = make_view_surface(field, q_from(seen), read_tiles(seen.tiles), colour);
    surface.on_gpu = std::move(lattice);
    return surface;
}

Result<GpuLattice> GpuLattices::lattice_of(const ViewSurface& surface) {
    GpuLattice lattice = uploaded_;
    const bool is_here = surface.on_gpu && surface.on_gpu->vulkan == device_->vulkan();
    if (is_here) {
        lattice = *surface.on_gpu;
        lattice.colours = uploaded_.colours;
        lattice.edges = uploaded_.edges;
    } else {
        lattice.vulkan = device_->vulkan();
        lattice.width = surface.width;
        lattice.height = surface.height;
        lattice.pitch = SurfaceUnproject::pitch(surface.width);
    }
    const GpuMemory memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload;
    const std::size_t bytes = SurfaceUnproject::q_bytes(surface.width, surface.height);  // as many of colours
    TRY(reserve(lattice.colours, "lattice colours", bytes, memory));
    uploaded_.colours = lattice.colours;
    put_rows(surface.colours, lattice, lattice.colours);
    if (is_here) return lattice;
    const std::size_t list_bytes = TileLists::list_bytes(surface.width, surface.height);
    for (const auto& done : {reserve(lattice.q, "lattice q", bytes, memory),
                             reserve(lattice.tiles, "lattice tiles", list_bytes, memory)})
        if (!done.ok()) return done.error();
    put_rows(surface.q, lattice, lattice.q);
    write_tiles(surface.tiles, lattice.tiles);
    uploaded_ = lattice;
    return lattice;
}

}  // namespace touchable
