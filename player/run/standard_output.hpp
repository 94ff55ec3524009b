#pragma once

// Standard output as a file of a run: what OutputFile writes to where its name is "-".
//
//   StandardOutput out(Pace::wall_clock);
//   TRY(out.write(row));  // each tick
//   TRY(out.finish());    // once
//
// One thread's. It is full where a reader is slow, gone where the reader has ended (`| head`), and may be a
// file on a full disk.

#include <chrono>
#include <cstddef>
#include <deque>
#include <string>
#include <string_view>

#include "player/run/run_files.hpp"

namespace touchable {

/// Standard output as a file of a run, for a reader that may be slow, or not read at all. Never waits where
/// the wait could not be ended: by the run's own pace until it is read, or the person asks to stop (an error
/// then); by the wall clock not at all, but at the end for a reader that reads, until the person asks to
/// stop.
class StandardOutput {
public:
    /// By the wall clock: so many pieces may wait, four seconds of ticks.
    static constexpr std::size_t most_waiting = 4096;

    /// Of a live run's end: a reader takes a pipe's worth in so long, or what is left.
    static constexpr std::size_t least_taken = 1 << 16;
    static constexpr std::chrono::milliseconds end_patience{4000};

    explicit StandardOutput(Pace pace, std::chrono::milliseconds patience = end_patience)
        : pace_(pace), patience_(patience) {}
    /// Errors (ErrorKind::input): it cannot be written, or the reader lags behind.
    Result<void> write(std::string_view piece);
    /// Until all is read.
    Result<void> finish();
    /// Whether the error was that.
    bool reader_lags() const { return lags_; }

private:
    enum class Taken { some, nothing_yet };
    Result<Taken> give(int patience_ms);
    Result<void> give_all();
    Error lagging();
    std::string_view rest() const { return std::string_view(waiting_).substr(given_); }

    Pace pace_;
    std::chrono::milliseconds patience_;
    std::string waiting_;           // with what is given already at its beginning
    std::size_t given_ = 0;         // of it
    std::deque<std::size_t> ends_;  // of the pieces that wait, as numbers of bytes from the run's beginning
    std::size_t written_ = 0, all_ = 0;  // bytes from the run's beginning
    bool gone_ = false, lags_ = false;
};

}  // namespace touchable
