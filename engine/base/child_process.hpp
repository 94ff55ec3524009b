#pragma once

// Another program that runs beside this one and ends with its owner.
//
// A ChildProcess has a process group of its own, no standard input and none of this program's files. Its
// standard output is read piece by piece without waiting (`read`, `waits`), or as a whole, within bounds of
// bytes and time (`all_output`). `how_it_ended` says so for a message, with the last
// line of its standard error. Its owner's end asks the whole group to end (SIGTERM), and 2 s later makes it
// (SIGKILL); none is left as a zombie. What reads files from strangers has limits of memory and processor
// time.
//
// An object is used by one thread at a time.

#include <poll.h>
#include <sys/types.h>

#include <array>
#include <chrono>
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

/// What a child may use at most; 0: as much as this program may.
struct ChildLimits {
    std::uint64_t memory_bytes = 0;  ///< of its address space
    std::uint64_t processor_seconds = 0;
};

class ChildProcess : NonCopyable {
public:
    /// `words`: the program, by its path or as it is found on PATH, and its arguments. `settings`:
    /// "NAME=value", in the place of the environment's. An error says why it cannot be started; null: there
    /// is no such program.
    static Result<std::unique_ptr<ChildProcess>> start(std::vector<std::string> words,
                                                       const ChildLimits& limits = {},
                                                       const std::vector<std::string>& settings = {});
    ~ChildProcess();

    /// What is there of its standard output, up to the size of `into`, at once: its length; 0: nothing is
    /// there yet; nothing at all: it has ended.
    std::optional<std::size_t> read(std::span<std::uint8_t> into);
    /// What poll waits for until there is more: of them a descriptor of -1 does not count.
    std::array<::pollfd, 2> waits() const;
    /// All that it writes until it ends well. Otherwise an error says how it ended; also where it writes more
    /// than `most` bytes, or has not ended after that time, or the program is asked to stop
    /// (ErrorKind::interrupted).
    Result<std::string> all_output(std::size_t most, std::chrono::milliseconds longest);
    /// Once its output has ended: how, such as "ended" or "ended with status 1: no such file". Waits for that
    /// for a fifth of a second at most.
    std::string how_it_ended();

private:
    ChildProcess(::pid_t process, Descriptor output, Descriptor errors)
        : process_(process), output_(std::move(output)), errors_(std::move(errors)) {}
    void hear_errors();
    std::string last_words() const;
    bool has_ended(::siginfo_t& how) const;

    const ::pid_t process_;  // and its group, which is there until it is waited for
    Descriptor output_, errors_;
    std::string errors_said_;  // the last of it
};

}  // namespace touchable
