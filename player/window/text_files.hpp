#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "engine/result.hpp"

namespace touchable {

/// Texts that become files, in the order in which they are given, on a thread of their own: a disk that does
/// not answer keeps the window from nothing. All calls are the window's.
class TextFiles {
public:
    TextFiles() = default;
    /// Waits for those that are being written.
    ~TextFiles() { finish(); }
    TextFiles(const TextFiles&) = delete;
    TextFiles& operator=(const TextFiles&) = delete;

    /// Refuses, by the text of a file that is there, to replace it: why.
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
    /// Waits until all are written; then `take` has the rest.
    void finish();

private:
    static Result<void> write_now(const Text& text);
    void note(const Text& text, Result<void> result);
    void write_all();

    std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by it.
    std::deque<Text> waiting_;
    std::vector<Written> done_;
    bool is_ending_ = false;
    std::thread thread_;  // from the first text
};

}  // namespace touchable
