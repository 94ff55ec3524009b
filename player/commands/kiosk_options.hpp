#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/window/play_window.hpp"

namespace touchable {

/// Options of a kiosk, as typed.
struct KioskWords {
    bool kiosk = false;
    std::vector<double> idle;
    std::string texts, bar;
    std::optional<std::filesystem::path> labels, use_log;
    std::string study;
    std::optional<std::filesystem::path> results;
};

/// Names of the options, for their group in the help.
std::vector<const char*> kiosk_option_names();
void add_kiosk_options(CLI::App& sub, KioskWords& words);
/// What they ask for, with all files read. `segments`: the file of --segments. Nothing: it is no kiosk.
Result<std::optional<KioskOptions>> read_kiosk(const KioskWords& words,
                                               const std::optional<std::filesystem::path>& segments);

/// Likewise of a study. `clips`: how many there are to touch.
Result<std::optional<StudyOptions>> read_study(const KioskWords& words, std::size_t clips);

}  // namespace touchable
