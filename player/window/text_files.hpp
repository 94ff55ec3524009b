#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/window/disk_work.hpp"

namespace touchable {

/// Texts that become files, in the order in which they are given, on a thread of their own: a disk that does
/// not answer keeps the window from nothing. All calls are the window's.
class TextFiles {
public:
    TextFiles();
    /// Finishes.
    ~TextFiles() { finish(); }
    TextFiles(const TextFiles&) = delete;
    TextFiles& operator=(const TextFiles&) = delete;

    /// Refuses, by the text of a file that is there, to replace it: why. It owns all that it uses: it may
    /// outlive the window.
    using Check = std::function<Result<void>(const std::filesystem::path& file)>;
    enum class Kind {
        history,  ///< which the window keeps by itself
        saved     ///< which a person asked for
    };
    struct Text {
        std::filesystem::path file;
        std::string text;
        Kind kind = Kind::history;
        std::string clip{};  ///< of which it is
        Check check{};
    };
    /// Whole or not at all; folders that are missing are made. A text that still waits and is for the same
    /// file is not written any more: this one has its place, before those that came after it.
    void write(Text text);
    struct Written {
        std::filesystem::path file;
        Kind kind;
        std::string clip;
        Result<void> result;
    };
    /// Those that were written or refused since, oldest first.
    std::vector<Written> take();
    /// The last call but `take`: waits until all are written, for that long at most; then `take` has the
    /// rest, and those that are not finished as errors.
    void finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

private:
    /// What the thread works on.
    struct Files;
    const std::shared_ptr<Files> files_;
    std::unique_ptr<DiskWork> disk_;  // from the first text until the end
};

}  // namespace touchable
