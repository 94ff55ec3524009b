#pragma once

#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace touchable {

/// All that this room asks of the system's video devices (V4L2), call by call, so that a test can stand in
/// for them. Calls give what the system's give: -1, or MAP_FAILED, with errno. Several threads may ask for
/// different devices.
class VideoSystem {
public:
    virtual ~VideoSystem() = default;
    /// Nodes that there are, such as "/dev/video0", in the order of their numbers.
    virtual std::vector<std::string> nodes() = 0;
    /// For reading and writing, and so that no call waits.
    virtual int open(const char* node) = 0;
    virtual int close(int descriptor) = 0;
    virtual int ioctl(int descriptor, unsigned long request, void* argument) = 0;
    /// Shared, for reading and writing.
    virtual void* mmap(int descriptor, std::size_t length, std::int64_t offset) = 0;
    virtual int munmap(void* memory, std::size_t length) = 0;
    virtual int poll(std::span<pollfd> descriptors, int timeout_ms) = 0;
};

/// This machine's.
std::shared_ptr<VideoSystem> system_video();

/// A call that a signal broke off is made again.
int call(VideoSystem& system, int descriptor, unsigned long request, void* argument);

/// Why a node cannot be used, with what would help: "/dev/video0: may not be opened: ...". `failure` is the
/// errno.
std::string node_trouble(const std::string& node, int failure);

/// Who has a device open, such as "cheese (process 123)", as far as this user may see; empty: nobody that is
/// seen.
std::string users_of_node(const std::string& node);

}  // namespace touchable
