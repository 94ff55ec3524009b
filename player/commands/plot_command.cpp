#include "player/commands/plot_command.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "engine/given_file.hpp"
#include "player/commands/plot_script.hpp"
#include "player/options/file_option.hpp"
#include "player/options/outputs.hpp"
#include "player/options/picture_options.hpp"

namespace touchable {
namespace {
namespace fs = std::filesystem;

struct PlotOptions {
    fs::path forces, picture;
    std::optional<fs::path> over;
    Existing existing = Existing::keep;
};

/// The script reads them: what would keep it waiting, or fill its memory, is told before.
Result<void> check_given(const std::vector<NamedFile>& inputs) {
    constexpr std::uint64_t largest = std::uint64_t{256} << 20;  // as compare has it
    for (const NamedFile& input : inputs) {
        const std::string named = input.name + " " + input.path.string();
        const auto given = GivenFile::open(input.path, named, "a file that touch or export wrote");
        if (!given.ok()) return given.error();
        if (given->size() > largest) return input_error(named + ": is larger than " + in_bytes(largest));
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
    if (auto free = check_outputs({{{"the picture", options.picture}}, options.existing}, inputs); !free.ok())
        return free;
    if (auto given = check_given(inputs); !given.ok()) return given;
    NewFile file(options.picture, options.existing);
    if (auto usable = file.check(); !usable.ok()) return usable;
    if (auto drawn = run_plot_script(words, file.path()); !drawn.ok()) return drawn;
    if (auto named = file.commit(); !named.ok()) return named;
    std::cout << "plot: " << file.target().string() << '\n';
    return {};
}

}  // namespace

void add_plot_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("plot", "draw the forces of a run over time, or its ways over a frame");
    auto options = std::make_shared<PlotOptions>();
    add_file_option(*sub, "FORCES", options->forces, "forces file (touch --forces)")->required();
    add_file_option(*sub, "PICTURE", options->picture, "PNG file to write")->required()->check(ends_in_png());
    add_file_option(
        *sub, "--over", options->over,
        "instead: where the fingers went over the depth of the frame in this folder (export --out)");
    add_overwrite_option(*sub, options->existing);
    sub->callback([options, &command] { command = [options] { return plot(*options); }; });
}

}  // namespace touchable
