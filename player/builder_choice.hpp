#pragma once

#include <string>
#include <vector>

#include "engine/surface/surface_builder.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `--builder` and what goes with it, as typed.
struct BuilderChoice {
    std::string name = "cpu";
    std::string gpu = "auto";   ///< as in choose_gpu; for the vulkan builder
    bool gpu_fallback = false;  ///< the cpu builder where there is no usable GPU
};

/// Adds --builder, which may be one of `names`, --gpu and --gpu-fallback.
void add_builder_options(CLI::App& sub, BuilderChoice& choice, const std::vector<std::string>& names);

/// Refused (ErrorKind::gpu), saying what is missing, where the vulkan builder is asked for, there is no such
/// GPU and none is asked to go on without. A GPU that is lost in the middle is no error: the cpu builder goes
/// on, and a warning on stderr says so.
Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene);

}  // namespace touchable
