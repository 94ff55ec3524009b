#pragma once

// The terminal: Ctrl-C, standard output that may go away, progress, and a line about a live run.
//
// catch_interrupts makes SIGINT, SIGTERM and SIGHUP a wish to stop (engine/base/threads.hpp); one that comes
// later than `same_wish` ends the program. Progress, of any work or of a run whose ticks it takes, and
// LiveLine show on a terminal; Progress may also write lines into a log.
//
// Objects are one thread's.

#include <filesystem>
#include <functional>

#include "device/hand.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// Signals that come so soon after the first say the same.
inline constexpr std::chrono::milliseconds same_wish{300};

/// From here on the first SIGINT, SIGTERM or SIGHUP only sets a flag; one that comes later than `same_wish`
/// after it ends the program at once. Those that are ignored already, as under nohup, stay so. A file-size
/// limit no longer ends it at all.
void catch_interrupts();

/// From now on neither Ctrl-Z nor a terminal stops the program: it would stop with a force on.
void ignore_stop_keys();

/// Whether an output's name, "-", means standard output ("./-" is a file of that name).
bool is_standard_output(const std::filesystem::path& name);

/// Writes out what was said. Fails (ErrorKind::input) where it cannot be written; a reader that has gone away
/// (`| head`) has heard what it wanted to hear and is no failure.
Result<void> flush_standard_output();

/// One line on the terminal's error stream that is drawn again and again; silent where that is no terminal.
class StatusLine : NonCopyable {
public:
    StatusLine();
    ~StatusLine();  ///< clears the line

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
class Progress final : public TouchSink {
public:
    /// Where the error stream is no terminal: nothing, or a line of its own every 10 seconds.
    enum class InALog { nothing, lines };
    /// `what`: "making frame". `total` <= 0: the end is not known.
    Progress(std::string what, std::int64_t total, InALog in_a_log = InALog::nothing)
        : what_(std::move(what)), total_(total), in_a_log_(in_a_log) {}
    void at(std::int64_t done);
    /// Of an offline run, whose ticks count.
    Result<void> take(const TouchTick& tick) override;

private:
    std::string what_;
    std::int64_t total_;
    InALog in_a_log_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), logged_ = start_;
    StatusLine line_;
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
    void show(const TouchSessionSettings::LiveStatus& status);

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
