#pragma once

#include <map>
#include <memory>
#include <utility>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_program.hpp"
#include "player/draw/gpu_lattice.hpp"
#include "player/draw/surface_light.hpp"
#include "player/draw/upload_pool.hpp"

namespace touchable {

/// Refused (ErrorKind::internal): colours that are not RGB of 8 bits and of that size, nor empty.
Result<void> check_colour(const PlaneView& colour, int width, int height);

/// The kernel light: q and colours to lit colours. The twin of `lit_colours`, to 2 of 255.
class SurfaceLighting {
public:
    explicit SurfaceLighting(std::shared_ptr<GpuDevice> device) : device_(device), uploads_(device) {}

    /// Records the kernel, from the lattice's q, once that is written and a barrier recorded after, to its
    /// colours. `field` is what q is of. `colour`: RGB of 8 bits, of the field's size, uploaded; or empty for
    /// clay, which is always lit.
    Result<void> record(GpuCommands& commands, const HeightField& field, const GpuLattice& lattice,
                        const PlaneView& colour, Lighting lighting);

private:
    Result<GpuBuffer> uploaded(const PlaneView& colour, int pitch);
    Result<GpuProgram> program_for(bool has_colour, bool is_lit);

    std::shared_ptr<GpuDevice> device_;
    UploadPool uploads_;
    std::map<std::pair<bool, bool>, GpuProgram> programs_;  // made when first needed
};

}  // namespace touchable
