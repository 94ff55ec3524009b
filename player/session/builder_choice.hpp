#pragma once

#include <memory>
#include <string>

#include "engine/surface/surface_builder.hpp"
#include "player/session/run_gpu.hpp"

namespace touchable {

/// `--builder` and what goes with it, as typed.
struct BuilderChoice {
    std::string name = "cpu";
    std::string gpu = "auto";   ///< as in choose_gpu; for the vulkan builder and for pictures
    bool gpu_fallback = false;  ///< nobody asked for the GPU: the cpu builder where it will not do after all

    bool names_gpu() const { return gpu != "auto"; }
};

/// The vulkan builder works on `gpu`, which others do not open. Refused (ErrorKind::gpu), saying what is
/// missing, where it was asked for and there is no such GPU; (ErrorKind::usage) the lazy builder with a
/// temporal filter. A GPU that is lost in the middle is no error: the cpu builder goes on, and a warning on
/// stderr says so.
Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu);

}  // namespace touchable
