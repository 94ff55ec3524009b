#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>

#include "engine/gpu/gpu_buffer.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_program.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/upload_pool.hpp"
#include "shaders/unproject.h"

namespace touchable {

/// What the arithmetic of shaders/unproject.h needs of a pair of frames that have codes; how lanes share rows
/// is left open. `pair` is what `field` was made of.
struct UnprojectTerms {
    UnprojectPush push;
    UnprojectConstants constants;
};
UnprojectTerms unproject_terms(const HeightField& field, const FramePair& pair);

/// The kernel unproject: codes of a pair of frames at a blend to q, for the eye. The twin of `q_of`: the same
/// pixels are 0, the others agree to 8 units in the last place of a float (1e-6), of the depth before height
/// is taken off.
class SurfaceUnproject {
public:
    explicit SurfaceUnproject(std::shared_ptr<GpuDevice> device) : device_(device), uploads_(device) {}

    /// Whether the frames behind a field have codes to begin with; lazy and exact ones have not.
    static bool has_codes(const HeightField& field, const FramePair& pair);

    /// Records the kernel. `pair` is what `field` was made of; frames that the Vulkan builder made on this
    /// device are read where they are, others are uploaded. They stay as they are until it has run. `q` gets
    /// rows of `pitch` floats, 0 beyond the width.
    Result<void> record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                        const GpuBuffer& q);
    static int pitch(int width);
    static std::size_t q_bytes(int width, int height);

private:
    using Constants = std::array<std::uint32_t, 7>;
    struct Planes {
        GpuBuffer codes, validity, heights;  // heights: any buffer where the frame has none
    };
    Result<Planes> planes_of(const SurfaceFrame& frame);
    Result<GpuBuffer> uploaded_rows(const char* name, const std::uint16_t* values, int width, int height);
    Result<GpuProgram> program_for(const Constants& constants);

    std::shared_ptr<GpuDevice> device_;
    UploadPool uploads_;
    std::map<Constants, GpuProgram> programs_;  // made when first needed
};

}  // namespace touchable
