#pragma once

// Bytes of a program that sends framesets (docs/camera.md): a command that is started, or a connection. Reads
// return at once with what is there; an object is one thread's.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <poll.h>

#include "engine/base/result.hpp"

namespace touchable {

/// Bytes that come when they come: a program's standard output, or a connection. One thread. What it began it
/// ends with itself.
class LiveBytes {
public:
    virtual ~LiveBytes() = default;
    /// What is there, up to the size of `into`, at once: its length; 0: nothing is there yet; nothing at all:
    /// it has ended.
    virtual std::optional<std::size_t> read(std::span<std::uint8_t> into) = 0;
    /// What poll waits for: of them a descriptor of -1 does not count.
    virtual std::array<pollfd, 2> waits() const = 0;
    /// Once it has ended: how, such as "ended with status 1". Waits for that for a fifth of a second at most.
    virtual std::string how_it_ended() = 0;
};

/// The standard output of a command that /bin/sh runs, in a process group of its own, without standard input.
/// The last line that it says on standard error is kept for how it ended. With this object the whole group is
/// asked to end (SIGTERM), and after 2 s made to (SIGKILL).
Result<std::unique_ptr<LiveBytes>> start_command(const std::string& command);

/// A connection to "HOST:PORT", of which HOST is an address in numbers or localhost ("127.0.0.1:7000",
/// "[::1]:7000"). It is there within 5 s, or an error says why not; or earlier, of kind interrupted, where
/// the program is told to stop.
Result<std::unique_ptr<LiveBytes>> connect_to(const std::string& address);

/// Whether an address is one as `connect_to` takes it; an error (usage) says what would be right.
Result<void> check_address(const std::string& address);

}  // namespace touchable
