#include "player/outputs.hpp"

#include <CLI/CLI.hpp>
#include <map>
#include <system_error>

namespace touchable {

namespace {

/// One name for a file, however it is written. Of two hard links only the one named is ever replaced.
std::filesystem::path whole_name(const std::filesystem::path& path) {
    std::error_code failure;
    auto whole = std::filesystem::weakly_canonical(path, failure);
    return failure ? std::filesystem::absolute(path, failure).lexically_normal() : whole;
}

Result<void> refuse(const NamedFile& output, const std::string& why) {
    return usage_error(output.name + " " + output.path.string() + why);
}

}  // namespace

void add_overwrite_option(CLI::App& sub, bool& overwrite) {
    sub.add_flag("--overwrite", overwrite, "replace files that are there already, rather than refuse");
}

Result<void> check_outputs(const Outputs& outputs, const std::vector<NamedFile>& inputs) {
    std::map<std::filesystem::path, std::string> taken;
    for (const NamedFile& input : inputs)
        if (!input.path.empty()) taken.emplace(whole_name(input.path), input.name);
    for (const NamedFile& output : outputs.files) {
        const auto [at, free] = taken.emplace(whole_name(output.path), output.name);
        if (!free)
            return refuse(output,
                          " is also " + at->second + ", which it would replace; give it a name of its own");
        // What is no file, a folder or a device, is told on opening it.
        std::error_code ignored;
        if (!outputs.overwrite && std::filesystem::is_regular_file(output.path, ignored))
            return refuse(output, " is there already; give another name, or --overwrite");
    }
    return {};
}

}  // namespace touchable
