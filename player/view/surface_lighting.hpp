#pragma once

#include <map>
#include <memory>
#include <utility>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_program.hpp"
#include "player/view/gpu_lattice.hpp"
#include "player/view/upload_pool.hpp"

namespace touchable {

/// What becomes of a colour at a vertex.
enum class Lighting {
    lit,    ///< in a gentle light that shows relief
    plain,  ///< as it is: of maps, whose colours say something
};

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
