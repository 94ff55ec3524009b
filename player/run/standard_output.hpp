#pragma once

// Standard output as a file of a run: the target of an OutputFile named "-".
//
//   StandardOutput out(Pace::wall_clock);
//   TRY(out.write(row));  // each tick
//   TRY(out.finish());    // once
//
// For one thread. Standard output may be full (a slow reader), closed (`| head`) or a file on a full disk.

#include <chrono>
#include <cstddef>
#include <deque>
#include <string>
#include <string_view>

#include "player/run/run_files.hpp"

namespace touchable {

/// Standard output as a file of a run, for a reader that may be slow or not read at all. Every wait can be
/// ended. Pace::own waits until the data is read or a stop is requested (an error then). Pace::wall_clock
/// does not wait, except in `finish` for a reader that still reads, until a stop is requested.
class StandardOutput {
public:
    /// Pace::wall_clock: pieces that may wait, four seconds of ticks.
    static constexpr std::size_t most_waiting = 4096;

    /// At a live run's end: a reader must take least_taken bytes, or the rest, within end_patience.
    static constexpr std::size_t least_taken = 1 << 16;
    static constexpr std::chrono::milliseconds end_patience{4000};

    explicit StandardOutput(Pace pace, std::chrono::milliseconds patience = end_patience)
        : pace_(pace), patience_(patience) {}
    /// Errors (ErrorKind::input): a write failed, or the reader lags behind.
    Result<void> write(std::string_view piece);
    /// Waits until everything is read.
    Result<void> finish();
    /// Whether its reader has closed the pipe.
    bool is_unread() const { return gone_; }
    /// Whether the error was a lagging reader.
    bool reader_lags() const { return lags_; }

private:
    enum class Taken { some, nothing_yet };
    Result<Taken> give(int patience_ms);
    Result<void> give_all();
    Error lagging();
    std::string_view rest() const { return std::string_view(waiting_).substr(given_); }

    Pace pace_;
    std::chrono::milliseconds patience_;
    std::string waiting_;                // begins with the given_ bytes already written
    std::size_t given_ = 0;              // bytes
    std::deque<std::size_t> ends_;       // ends of the waiting pieces, bytes from the run's beginning
    std::size_t written_ = 0, all_ = 0;  // bytes from the run's beginning
    bool gone_ = false, lags_ = false;
};

}  // namespace touchable
