#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/result.hpp"

namespace touchable {

/// Runs player/plot/plot.py, which needs Python and matplotlib, with these words. Its picture goes to the
/// open or new file `to`. What it says against its input is an input error.
Result<void> run_plot_script(const std::vector<std::string>& words, const std::filesystem::path& to);

}  // namespace touchable
