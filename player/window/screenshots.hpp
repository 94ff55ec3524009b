#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "engine/new_file.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/result.hpp"

namespace touchable {

/// Pictures of the window that become files, on a thread of their own: a disk that does not answer keeps the
/// window from nothing, and the key that takes the force off least of all. All calls are the window's.
class Screenshots {
public:
    /// Writes a picture under this name, or a free one where it is empty; gives the name that the file got.
    using Write = std::function<Result<std::filesystem::path>(const Image&, const std::filesystem::path&)>;

    /// PNG files; `existing`: what becomes of one that is there.
    explicit Screenshots(Existing existing);
    explicit Screenshots(Write write) : write_(std::move(write)) {}
    /// Waits for those that are being written.
    ~Screenshots() { finish(); }
    Screenshots(const Screenshots&) = delete;
    Screenshots& operator=(const Screenshots&) = delete;

    /// An error where too many wait, or the machine has no thread left.
    Result<void> keep(Image image, std::filesystem::path name);
    /// Those that were written or refused since, oldest first.
    std::vector<Result<std::filesystem::path>> take();
    /// Waits until all are written; then `take` has the rest.
    void finish();

    static constexpr std::size_t most_waiting = 4;

private:
    struct Picture {
        Image image;
        std::filesystem::path name;
    };
    void write_all();

    const Write write_;
    std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by it.
    std::deque<Picture> waiting_;  // the first one is being written
    std::vector<Result<std::filesystem::path>> done_;
    bool is_ending_ = false;
    std::thread thread_;  // from the first picture
};

}  // namespace touchable
