// SPDX-License-Identifier: Apache-2.0
#pragma once

// A program and its person: Ctrl-C, standard output that may be closed, text from outside, memory that does
// not suffice, progress, and a status line of a live run.
//
// catch_interrupts turns SIGINT, SIGTERM and SIGHUP into a stop request (engine/base/threads.hpp); another
// signal later than `same_wish` ends the program. Progress, of any work or of a run whose ticks it takes, and
// LiveLine draw on a terminal; Progress may also write lines into a log.
//
// Threads: one uses an object.

#include <filesystem>
#include <functional>
#include <new>

#include "device/hand.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// Signals this soon after the first count as the same request.
inline constexpr std::chrono::milliseconds same_wish{300};

/// From now on the first SIGINT, SIGTERM or SIGHUP only sets a flag; one later than `same_wish` after it ends
/// the program at once. Signals already ignored, as under nohup, stay ignored. A file-size limit no longer
/// ends the program.
void catch_interrupts();

/// From now on neither Ctrl-Z nor a terminal suspends the program, which would leave a force on.
void ignore_stop_keys();

/// Whether an output's name, "-", means standard output ("./-" is a file of that name).
bool is_standard_output(const std::filesystem::path& name);

/// From now on std::cout and std::cerr escape what a terminal would act on (words.hpp: printable), but line
/// breaks and tabs. So do words with names of files in them, and JSON stays valid: it has \u202e for such a
/// character.
void escape_for_terminal();

/// Writes "touchable: " and the words to stderr, on one line.
void say_on_stderr(std::string_view words);

/// Flushes std::cout. Error (ErrorKind::input): it cannot be written; a reader that has closed the pipe (`|
/// head`) is no error.
Result<void> flush_standard_output();

/// Memory does not suffice for `what`.
inline Error no_memory_for(const std::string& what) {
    return input_error("memory does not suffice for " + what);
}

/// Does the work; if memory does not suffice, the error names `what`. It is read only then, so the work may
/// update it as it learns of sizes.
Result<void> within_memory(const std::string& what, auto&& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return no_memory_for(what);
    }
}

/// One line on stderr that is redrawn in place; silent if stderr is no terminal, or one
/// that cannot redraw (TERM=dumb).
class StatusLine : NonCopyable {
public:
    StatusLine();
    ~StatusLine();  ///< clears the line

    /// Whether to `show` now: at most ten times a second.
    bool is_due() const;
    bool is_on_terminal() const { return terminal_; }
    void show(const std::string& text);

private:
    bool terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point last_{};
};

/// A status line that counts up during long work; after the first second also the rate and the time left.
class Progress final : public TouchSink {
public:
    /// If stderr is no terminal: write nothing, or a line every 10 seconds.
    enum class InALog { nothing, lines };
    /// `what`: "making frame". `total` <= 0: unknown.
    Progress(std::string what, std::int64_t total, InALog in_a_log = InALog::nothing)
        : what_(std::move(what)), total_(total), in_a_log_(in_a_log) {}
    void at(std::int64_t done);
    /// Counts an offline run's ticks.
    Result<void> consume(const TouchTick& tick) override;

private:
    std::string what_;
    std::int64_t total_;
    InALog in_a_log_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), logged_ = start_;
    StatusLine line_;
};

/// ", 120/s, 3 s left", for `done` units in `seconds`; `total` <= 0: unknown. Empty in the first second.
std::string pace_in_words(std::int64_t done, std::int64_t total, double seconds);

/// Status line of a live session: its duration, skipped ticks and late frames so far, and the largest force
/// on a finger now. For a device held by the user also the `device` text and why force is held back.
class LiveLine final : public TouchSink {
public:
    /// `control`: of a device that exerts forces on the user, must outlive this; nullptr: none. `device`:
    /// text about that device; null: no text. `silence`: text about a source whose newest frame is so many
    /// ns old (silence_in_words); null: none. Without a terminal only that is written, when it begins or
    /// ends.
    explicit LiveLine(const HandControl* control = nullptr, std::function<std::string()> device = {},
                      std::function<std::string(std::int64_t)> silence = {})
        : control_(control), device_(std::move(device)), silence_(std::move(silence)) {}
    Result<void> consume(const TouchTick& tick) override;
    void show(const TouchSessionSettings::LiveStatus& status);

private:
    const HandControl* const control_;
    const std::function<std::string()> device_;
    const std::function<std::string(std::int64_t)> silence_;
    StatusLine line_;
    std::int64_t ticks_ = 0, next_ = 0;  // ticks taken; the tick after the newest
    double newtons_ = 0;
    bool is_kept_back_ = false;  // a finger's force is held back until the finger has been free
    std::int64_t age_ns_ = 0;    // of the newest frame
    bool is_silent_ = false;     // the log says so
};

}  // namespace touchable
