#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "player/run/touch_session.hpp"

namespace touchable {

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

}  // namespace touchable
