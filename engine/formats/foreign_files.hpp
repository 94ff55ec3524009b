#pragma once

// Recordings, archives and containers of other programs that are not opened, but recognised: by their first
// bytes, or by their name where the bytes say less. For each there is one sentence that says what the file is
// and what to do with it. Pure functions of the file system, for any thread.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/files.hpp"

namespace touchable {

/// What a file is, as the end of a sentence that begins with its name, and what to do: "is a Git LFS pointer
/// ...: git lfs pull". Nothing where it is no file that is known here.
std::optional<std::string> foreign_file(const SourceFile& file);

/// The same of files that a reader of ours would take for its own by their first bytes: SVO2 is MCAP inside, a
/// Git LFS pointer has the name of the file that it stands for, and .npz are ZIP files. `begin`: its first 16
/// bytes, or all; where these cannot be of such a file, nothing more is read.
std::optional<std::string> misleading_file(const SourceFile& file, std::string_view begin);

/// The same of a folder that is one file to other programs (.zarr).
std::optional<std::string> foreign_folder(const std::filesystem::path& folder);

/// The first foreign file in a folder, or up to three folders below it, by name: "NAME is ...". Looks at
/// 10000 entries at most, and opens 64 files at most.
std::optional<std::string> foreign_file_below(const std::filesystem::path& folder);

}  // namespace touchable
