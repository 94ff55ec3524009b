#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/image_file.hpp"
#include "player/window/disk_work.hpp"

namespace touchable {

/// Pictures of the window that become files, on a thread of their own: a disk that does not answer keeps the
/// window from nothing, and the key that takes the force off least of all. All calls are the window's.
class Screenshots {
public:
    /// Writes a picture under this name. It owns all that it uses: it may outlive the window.
    using Write = std::function<Result<void>(const Image&, const std::filesystem::path&)>;

    /// PNG files; `existing`: what becomes of one that is there.
    explicit Screenshots(Existing existing);
    explicit Screenshots(Write write);
    /// Finishes.
    ~Screenshots() { finish(); }
    Screenshots(const Screenshots&) = delete;
    Screenshots& operator=(const Screenshots&) = delete;

    /// Under this name, or a free one where it is empty. An error where too many wait, or the machine has no
    /// thread left.
    Result<void> keep(Image image, std::filesystem::path name);
    /// The names of those that were written, or why one was not, since; oldest first.
    std::vector<Result<std::filesystem::path>> take();
    /// The last call but `take`: waits until all are written, for that long at most; then `take` has the
    /// rest, and those that are not finished as errors.
    void finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

    static constexpr std::size_t most_waiting = 4;

private:
    /// What the thread works on.
    struct Files;
    const std::shared_ptr<Files> files_;
    std::unique_ptr<DiskWork> disk_;  // from the first picture until the end
};

}  // namespace touchable
