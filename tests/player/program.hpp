#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/temporary_folder.hpp"

namespace touchable::test {

/// What a run of the program `touchable` left behind.
struct Outcome {
    int code = -1;  ///< exit code; -signal where it died of one
    std::string out, err;

    /// True for one line that begins with the program's name: how every failure is told.
    bool one_line_of_error() const;
};

/// Runs it to its end.
Outcome run_touchable(const std::vector<std::string>& arguments);

/// Starts it, sends SIGINT once there is something in `folder`, and waits for its end.
Outcome run_interrupted(const std::vector<std::string>& arguments, const std::filesystem::path& folder);

/// Starts it, sends SIGINT once it has said something, and waits for its end.
Outcome run_interrupted_once_it_speaks(const std::vector<std::string>& arguments);

/// Runs it where no file may grow beyond `kibibytes`: a full disk, for its files but not for what it says.
Outcome run_on_full_disk(const std::vector<std::string>& arguments, int kibibytes);

/// Runs it where it may have no more than `mebibytes` of memory, its libraries included.
Outcome run_in_memory(const std::vector<std::string>& arguments, int mebibytes);

std::string file_contents(const std::filesystem::path& file);
/// Names in a folder, hidden ones too, sorted.
std::vector<std::string> names_in(const std::filesystem::path& folder);

}  // namespace touchable::test
