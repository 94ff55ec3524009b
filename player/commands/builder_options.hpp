#pragma once

#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/session/builder_choice.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// Adds --builder, which may be one of `names`, and --gpu.
void add_builder_options(CLI::App& sub, BuilderChoice& choice, const std::vector<std::string>& names);

/// Refused (ErrorKind::usage) where GPU options are given and nothing of the run uses a GPU.
Result<void> check_gpu_options(const BuilderChoice& choice, bool draws_on_gpu);

}  // namespace touchable
