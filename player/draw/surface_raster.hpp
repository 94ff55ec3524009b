#pragma once

#include <cstddef>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_program.hpp"
#include "player/draw/gpu_lattice.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// The kernels raster and raster_large: triangles by compute, for devices that have 64-bit atomics.
class SurfaceRaster {
public:
    /// Fails (ErrorKind::gpu) on a device without 64-bit atomics.
    static Result<SurfaceRaster> create(const GpuDevice& device);

    /// Records the drawing of a lattice into `pixels`, which are cleared first: 64 bits for each pixel of the
    /// camera, row-major, `pitch` from one row to the next, as shaders/raster.h says. `large` has
    /// `large_bytes` at least. A view that is not the clip's own needs the lattice's edges.
    void record(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera,
                const GpuBuffer& pixels, int pitch, const GpuBuffer& large) const;
    static std::size_t large_bytes(int width, int height);

    /// Records what comes next, once a barrier is recorded after that: from pixels with rows of
    /// `resolve_pitch` to their colours (PackedColour) and z, rows as long. `background`: a colour for each
    /// row.
    void record_resolve(GpuCommands& commands, const ViewCamera& camera, const GpuBuffer& pixels,
                        const GpuBuffer& background, const GpuBuffer& colours, const GpuBuffer& z) const;
    static int resolve_pitch(int width);

private:
    bool on_cpu_ = false;
    GpuProgram raster_, large_, resolve_;
};

}  // namespace touchable
