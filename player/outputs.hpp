#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/result.hpp"

namespace touchable {

/// A file as somebody named it: "--json" and its path, or "the clip" and its path.
struct NamedFile {
    std::string name;
    std::filesystem::path path;
};

/// Refuses (ErrorKind::usage) an output that is also an input or another output: it would be replaced without
/// a word.
Result<void> keep_outputs_apart(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

}  // namespace touchable
