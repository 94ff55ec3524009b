#include "player/commands/outputs.hpp"

#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <map>
#include <system_error>

#include "engine/clip/clip_reader.hpp"
#include "player/run/standard_output.hpp"

namespace touchable {

namespace {
namespace fs = std::filesystem;

std::string identity_of(const struct stat& file) {
    return std::to_string(file.st_dev) + ':' + std::to_string(file.st_ino);
}

/// The same for two names of one file, and for two names under which one file would be made.
std::string file_behind(const fs::path& path) {
    if (is_standard_output(path)) return "standard output";
    struct stat file = {}, folder = {};
    if (stat(path.c_str(), &file) == 0) return identity_of(file);
    std::error_code failure;
    fs::path whole = fs::weakly_canonical(fs::absolute(path, failure), failure);
    if (failure) whole = path.lexically_normal();
    if (stat(whole.parent_path().c_str(), &folder) != 0) return whole.string();
    return identity_of(folder) + '/' + whole.filename().string();
}

/// Whether something has that name, be it a link to nowhere. What is no file, a folder or a device, is told
/// on opening it.
bool is_taken(const fs::path& path) {
    std::error_code ignored;
    const auto named = fs::symlink_status(path, ignored);
    if (!fs::exists(named)) return false;
    const auto led_to = fs::status(path, ignored);
    return !fs::exists(led_to) || fs::is_regular_file(led_to);
}

Result<void> refuse(const NamedFile& output, const std::string& why) {
    return usage_error(output.name + " " + output.path.string() + why);
}

}  // namespace

void add_overwrite_option(CLI::App& sub, Existing& existing) {
    sub.add_flag_callback(
        "--overwrite", [&existing] { existing = Existing::replace; },
        "replace files that are there already, rather than refuse");
}

void add_inputs(std::vector<NamedFile>& inputs, const fs::path& clip, const ClipReader& reader) {
    inputs.push_back({"the clip", clip});
    for (const fs::path& file : reader.inputs()) inputs.push_back({"a file of the clip", file});
}

Result<void> check_outputs(const Outputs& outputs, const std::vector<NamedFile>& inputs) {
    std::map<std::string, std::string> taken;
    for (const NamedFile& input : inputs)
        if (!input.path.empty()) taken.emplace(file_behind(input.path), input.name);
    for (const NamedFile& output : outputs.files) {
        const auto [at, free] = taken.emplace(file_behind(output.path), output.name);
        if (!free && is_standard_output(output.path))
            return usage_error(output.name + " - and " + at->second +
                               " -: one of them can go to standard output; give the other a file's name");
        if (!free)
            return refuse(output,
                          " is also " + at->second + ", which it would replace; give it a name of its own");
        if (outputs.existing == Existing::keep && is_taken(output.path))
            return refuse(output, " is there already; give another name, or --overwrite");
    }
    return {};
}

}  // namespace touchable
