#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/result.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// A file as somebody named it: "--json" and its path, or "the clip" and its path.
struct NamedFile {
    std::string name;
    std::filesystem::path path;
};

/// Files that a command is to write, and what stands in its way.
struct Outputs {
    std::vector<NamedFile> files;
    bool overwrite = false;  ///< an earlier file of an output's name may be replaced
};

/// Adds --overwrite.
void add_overwrite_option(CLI::App& sub, bool& overwrite);

/// Refuses (ErrorKind::usage) an output that is also an input or another output, whatever was asked for, and
/// one that is there already unless it may be replaced.
Result<void> check_outputs(const Outputs& outputs, const std::vector<NamedFile>& inputs);

}  // namespace touchable
