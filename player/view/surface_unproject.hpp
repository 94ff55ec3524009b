#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "engine/gpu/gpu_buffer.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_program.hpp"
#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// What a pair of frames is to the kernel unproject: its planes in the GPU's memory.
struct GpuFramePlanes {
    GpuBuffer codes, validity, heights;  ///< heights: any buffer where the frame has none
};

/// The kernel unproject: codes of a pair of frames at a blend to q, for the eye. The twin of `q_of`: the same
/// pixels are 0, the others agree to 8 units in the last place of a float (1e-6), of the depth before height
/// is taken off.
class SurfaceUnproject {
public:
    explicit SurfaceUnproject(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}

    /// q of every pixel, row-major, as `q_of` has it, which also does what frames without codes (lazy, exact)
    /// need. `pair` is what `field` was made of.
    Result<std::vector<float>> q_of(const HeightField& field, const FramePair& pair);

    /// Records the kernel. `next` is `prev` again, and `blend` 0, where there is one frame. `q` has room for
    /// the pixels in whole eights.
    Result<void> record(GpuCommands& commands, const Scene& scene, const SurfaceFrame& prev,
                        const SurfaceFrame& next, double blend, const GpuFramePlanes& prev_planes,
                        const GpuFramePlanes& next_planes, const GpuBuffer& q);
    Result<GpuFramePlanes> upload(const SurfaceFrame& frame) const;
    static std::size_t q_bytes(int width, int height);

private:
    Result<GpuProgram> program_for(std::size_t bits);

    std::shared_ptr<GpuDevice> device_;
    std::array<GpuProgram, 16> programs_;  // by the bits of UnprojectConstants; made when first needed
};

}  // namespace touchable
