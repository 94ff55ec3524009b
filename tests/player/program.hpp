#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

/// A folder of its own for a test, removed with everything in it.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }

private:
    std::filesystem::path path_;
};

std::string file_contents(const std::filesystem::path& file);
/// Names in a folder, hidden ones too, sorted.
std::vector<std::string> names_in(const std::filesystem::path& folder);

}  // namespace touchable::test
