#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"

namespace CLI {
class App;
}

namespace touchable {

class ClipReader;

/// A file as somebody named it: "--json" and its path, or "the clip" and its path.
struct NamedFile {
    std::string name;
    std::filesystem::path path;
};

/// Files that a command is to write, and what stands in its way.
struct Outputs {
    std::vector<NamedFile> files;
    Existing existing = Existing::keep;  ///< what becomes of earlier files of their names
};

/// Adds --overwrite.
void add_overwrite_option(CLI::App& sub, Existing& existing);

/// Adds every file that a clip is read from; `clip` as it was named.
void add_inputs(std::vector<NamedFile>& inputs, const std::filesystem::path& clip, const ClipReader& reader);

/// Refuses (ErrorKind::usage) an output that is also an input or another output, by whatever name, and
/// whatever was asked for, and one that is there already unless it may be replaced. Standard output is no
/// file, but there is only one.
Result<void> check_outputs(const Outputs& outputs, const std::vector<NamedFile>& inputs);

}  // namespace touchable
