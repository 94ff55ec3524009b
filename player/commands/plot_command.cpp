// SPDX-License-Identifier: Apache-2.0
#include "player/commands/commands.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "engine/base/child_process.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t largest_picture = std::size_t{256} << 20;

/// Debian's matplotlib belongs to this Python; without it the first in PATH.
const char* python() {
    constexpr const char* system = "/usr/bin/python3";
    return access(system, X_OK) == 0 ? system : "python3";
}

/// Runs player/plot/plot.py, which needs Python and matplotlib, with these words. Returns its picture. Its
/// complaints about the input become input errors.
Result<std::string> run_plot_script(const std::vector<std::string>& words) {
    const fs::path script = folder_from_program(TOUCHABLE_PLOT_FROM_PROGRAM) / "plot.py";
    if (access(script.c_str(), R_OK) != 0)
        return input_error(script.string() +
                           " does not exist; `plot` needs it where touchable is installed or was built");
    std::vector<std::string> command{python(), "-B", script.string()};  // -B: writes no cache files
    command.insert(command.end(), words.begin(), words.end());
    TRY_ASSIGN(const auto child, error_at("Python", ChildProcess::start(std::move(command))));
    if (!child)
        return input_error(
            "Python cannot be started (No such file or directory); Debian: python3-matplotlib");
    auto picture = child->all_output(largest_picture);
    if (picture || picture.error().kind == ErrorKind::interrupted) return picture;
    const std::string& why = picture.error().message;
    constexpr std::string_view bad_input = "ended with status 3: ";
    if (const auto at = why.find("ModuleNotFoundError"); at != std::string::npos)
        return input_error("Python lacks what `plot` needs (" + why.substr(at) +
                           "); Debian: python3-matplotlib");
    return why.starts_with(bad_input) ? input_error(why.substr(bad_input.size()))
                                      : internal_error("the plot failed: " + why);
}

struct PlotOptions {
    fs::path forces, picture;
    std::optional<fs::path> over;
    Existing existing = Existing::keep;
};

/// Refuses files that would block the script or fill its memory.
Result<void> check_given(const std::vector<NamedFile>& inputs) {
    constexpr std::uint64_t largest = std::uint64_t{256} << 20;  // same as compare's
    for (const NamedFile& input : inputs) {
        const std::string named = input.name + " " + input.path.string();
        TRY_ASSIGN(const auto given, GivenFile::open(input.path, named, "a file that touch or export wrote"));
        if (given.size() > largest) return input_error(named + ": is larger than " + in_bytes(largest));
    }
    return {};
}

Result<void> plot(const PlotOptions& options) {
    std::vector<NamedFile> inputs{{"the forces file", options.forces}};
    std::vector<std::string> words{options.forces.string()};
    if (options.over) {
        for (const char* name : {"scene.json", "codes.png", "valid.png"})
            inputs.push_back({"--over", *options.over / name});
        words.push_back(options.over->string());
    }
    TRY(check_outputs({{{"the picture", options.picture}}, options.existing}, inputs));
    TRY(check_given(inputs));
    NewFile file(options.picture, options.existing);
    TRY(file.check());
    TRY_ASSIGN(const auto picture, run_plot_script(words));
    TRY(file.write(picture));
    TRY(file.commit());
    std::cout << "plot: " << one_line(file.target().string()) << '\n';
    return {};
}

}  // namespace

void add_plot_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("plot", "draw the forces of a run over time, or the fingers' paths over a frame");
    auto options = std::make_shared<PlotOptions>();
    add_file_option(*sub, "FORCES", options->forces, "forces file (touchable touch --forces)")->required();
    add_file_option(*sub, "PICTURE", options->picture, "PNG file to write")
        ->required()
        ->check(ends_in({".png"}, "a picture"));
    add_file_option(*sub, "--over", options->over,
                    "draw the fingers' paths over depth of the frame in this folder (touchable export --out)")
        ->type_name("FOLDER");
    add_overwrite_option(*sub, options->existing);
    set_work(*sub, command, [options] { return plot(*options); });
}

}  // namespace touchable
