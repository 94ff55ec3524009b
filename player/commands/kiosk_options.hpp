#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.hpp"
#include "player/window/play_window.hpp"

namespace touchable {

/// Options of a kiosk, as typed.
struct KioskWords {
    bool kiosk = false;
    std::vector<double> idle;
    std::string texts;
    std::optional<std::filesystem::path> labels, use_log;
};

/// Names of the options, for their group in the help.
std::vector<const char*> kiosk_option_names();
void add_kiosk_options(CLI::App& sub, KioskWords& words);
/// What they ask for, with all files read. `segments`: the file of --segments. Nothing: it is no kiosk.
Result<std::optional<KioskOptions>> read_kiosk(const KioskWords& words,
                                               const std::optional<std::filesystem::path>& segments);

}  // namespace touchable
