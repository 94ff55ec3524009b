// SPDX-License-Identifier: Apache-2.0
#pragma once

// Another program that runs beside this one and ends with its owner.
//
// A ChildProcess has its own process group, no standard input and none of this program's open files. Its
// standard output is read piece by piece without waiting (`read`, `waits`), or as a whole within a limit of
// bytes (`all_output`). `how_it_ended` gives the reason for a message, with the last line of its standard
// error. The destructor sends SIGTERM to the whole group, and SIGKILL after 2 s, or 0.1 s if a stop is
// requested; no zombie is left. A child that reads files from strangers gets limits of memory and processor
// time.
//
// Threads: one at a time uses an object.

#include <poll.h>
#include <sys/types.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Limits of a child; 0: the same as this program's.
struct ChildLimits {
    std::uint64_t memory_bytes = 0;  ///< of its address space
    std::uint64_t processor_seconds = 0;
};

class ChildProcess : NonCopyable {
public:
    /// Starts a program. `words`: its path, or its name on PATH, and its arguments. `settings`: "NAME=value"
    /// entries that replace the environment's. An error says why it cannot be started; null: there is no such
    /// program.
    static Result<std::unique_ptr<ChildProcess>> start(std::vector<std::string> words,
                                                       const ChildLimits& limits = {},
                                                       const std::vector<std::string>& settings = {});
    ~ChildProcess();

    /// Reads the standard output that is available now, at most the size of `into`. Returns the number of
    /// bytes, 0 if none is available yet, nullopt once the output has ended.
    std::optional<std::size_t> read(std::span<std::uint8_t> into);
    /// Descriptors to poll for more output; poll ignores a descriptor of -1.
    std::array<::pollfd, 2> waits() const;
    /// Returns the whole standard output once the child has ended well. An error says how it ended, or that
    /// it wrote more than `most` bytes, that it ran for longer than its ChildLimits
    /// (Error::Cause::out_of_time), or that the program is asked to stop (ErrorKind::interrupted).
    Result<std::string> all_output(std::size_t most);
    /// Says how the child ended, such as "ended" or "ended with status 1: no such file", once its output has
    /// ended. Waits for its exit for at most 0.2 s.
    std::string how_it_ended();

private:
    ChildProcess(::pid_t process, Descriptor output, Descriptor errors)
        : process_(process), output_(std::move(output)), errors_(std::move(errors)) {}
    void hear_errors();
    std::string last_words() const;
    bool has_ended(::siginfo_t& how) const;
    Result<void> outcome(const ::siginfo_t& how) const;

    const ::pid_t process_;  // also the id of its group, which stays taken until it is waited for
    Descriptor output_, errors_;
    std::string errors_said_;  // the last 2000 bytes
};

}  // namespace touchable
