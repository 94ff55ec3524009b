#pragma once

// The terminal: Ctrl-C, standard output that may go away, progress, and a line about a live run.
//
// catch_interrupts makes SIGINT, SIGTERM and SIGHUP a wish to stop (engine/base/threads.hpp); one that comes
// later than `same_wish` ends the program. StandardOutput writes to a reader that may be slow, gone or a full
// disk. LiveLine shows on a terminal only; Progress may write lines into a log.
//
// Objects are one thread's; `interrupted` is any thread's.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "device/hand.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// Exit code of a program that was asked to stop (Ctrl-C) and did so cleanly.
inline constexpr int interrupted_exit_code = 130;

/// Signals that come so soon after the first say the same.
inline constexpr std::chrono::milliseconds same_wish{300};

/// From here on the first SIGINT, SIGTERM or SIGHUP only sets a flag; one that comes later than `same_wish`
/// after it ends the program at once.
/// Those that are ignored already, as under nohup, stay so. A file-size limit no longer ends it at all.
void catch_interrupts();

/// True once the person asked to stop. Long work looks here between frames.
bool interrupted();

/// From now on neither Ctrl-Z nor a terminal stops the program: it would stop with a force on.
void ignore_stop_keys();

/// By which clock a run goes, and so what becomes of its files.
enum class Pace {
    own,         ///< it can be repeated: it waits for whoever reads, and a file is whole or not there
    wall_clock,  ///< it cannot: it waits for nobody, and what a full disk has taken of a file is kept
};

/// Whether an output's name, "-", means standard output ("./-" is a file of that name).
bool is_standard_output(const std::filesystem::path& name);

/// Writes out what was said. Fails (ErrorKind::input) where it cannot be written; a reader that has gone away
/// (`| head`) has heard what it wanted to hear and is no failure.
Result<void> flush_standard_output();

/// Standard output as a file of a run, for somebody who may read slowly, or not at all. Never waits where
/// nobody could end that: by the run's own pace until it is read, or the person asks to stop (an error then);
/// by the wall clock not at all, but at the end for a reader who reads, until the person asks to stop.
class StandardOutput {
public:
    /// By the wall clock: so many pieces may wait, four seconds of ticks.
    static constexpr std::size_t most_waiting = 4096;

    /// Of a live run's end: whoever reads takes a pipe's worth in so long, or what is left.
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

/// One line on the terminal's error stream that is drawn again and again; silent where that is no terminal.
class StatusLine {
public:
    StatusLine();
    ~StatusLine();  ///< clears the line
    StatusLine(const StatusLine&) = delete;
    StatusLine& operator=(const StatusLine&) = delete;

    /// Whether to `show` something: ten times a second at most.
    bool is_due() const;
    bool is_on_terminal() const { return terminal_; }
    void show(const std::string& text);

private:
    bool terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point last_{};
};

/// A status line that counts up while long work runs, and after the first second says how fast, and how long
/// it takes still.
class Progress {
public:
    /// Where the error stream is no terminal: nothing, or a line of its own every 10 seconds.
    enum class InALog { nothing, lines };
    /// `what`: "making frame". `total` <= 0: the end is not known.
    Progress(std::string what, std::int64_t total, InALog in_a_log = InALog::nothing);
    void at(std::int64_t done);

private:
    std::string what_;
    std::int64_t total_;
    InALog in_a_log_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), logged_ = start_;
    StatusLine line_;
};

/// The ticks of an offline run.
class TickProgress final : public TouchSink {
public:
    /// `total`: as of Progress.
    explicit TickProgress(std::int64_t total) : progress_("tick", total) {}
    Result<void> take(const TouchTick& tick) override;

private:
    Progress progress_;
};

/// ", 120/s, 3 s left", of work of which so much was done in so many seconds; `total` <= 0: no end is known.
/// Nothing in the first second.
std::string pace_in_words(std::int64_t done, std::int64_t total, double seconds);

/// What a person sees on a terminal while a live session runs: for how long it has, what came late so far,
/// and the largest force on a finger now. With a device that a person holds, the force that is asked of it,
/// and why it is kept back where it is.
class LiveLine final : public TouchSink {
public:
    /// `control`: of the device that exerts forces on a person, which outlives this; nullptr: none does.
    /// `device`: what is to be said of it; nothing: nothing.
    explicit LiveLine(const HandControl* control = nullptr, std::function<std::string()> device = {})
        : control_(control), device_(std::move(device)) {}
    Result<void> take(const TouchTick& tick) override;
    void show(const LiveStatus& status);

private:
    const HandControl* const control_;
    const std::function<std::string()> device_;
    StatusLine line_;
    std::int64_t ticks_ = 0, next_ = 0;  // taken; the tick after the newest
    double newtons_ = 0;
    bool is_kept_back_ = false;  // a finger's force, until it has been free
    bool is_stale_ = false;      // the surface
};

}  // namespace touchable
