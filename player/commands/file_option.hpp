#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace touchable {

/// An option (or a word, where `name` has no dashes) that names a file or a folder: an empty name, which is
/// most often a variable of the shell that was never set, is refused.
template <class Path>
CLI::Option* add_file_option(CLI::App& sub, const std::string& name, Path& file, const std::string& what) {
    const CLI::Validator named([](std::string& text) { return text.empty() ? "names no file" : ""; }, "");
    return sub.add_option(name, file, what)->check(named)->type_name("FILE");
}

}  // namespace touchable
