// SPDX-License-Identifier: Apache-2.0
#include "player/run/terminal.hpp"

#include <poll.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <glm/geometric.hpp>
#include <iostream>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

std::atomic<std::int64_t> first_ns{0};  // time of the first signal
static_assert(std::atomic<std::int64_t>::is_always_lock_free,
              "a signal handler may touch nothing that locks");

/// Passes on what a stream is given, one piece of whole characters after the other.
class EscapedOutput final : public std::streambuf {
public:
    explicit EscapedOutput(std::ostream& stream) : stream_(stream), to_(stream.rdbuf(this)) {}
    ~EscapedOutput() override { stream_.rdbuf(to_); }

private:
    std::streamsize xsputn(const char* piece, std::streamsize count) override {
        const std::string text =
            printable({piece, static_cast<std::size_t>(count)}, std::string::npos, "\n\t");
        return to_->sputn(text.data(), std::ssize(text)) == std::ssize(text) ? count : 0;
    }
    int_type overflow(int_type byte) override {
        const char piece = traits_type::to_char_type(byte);
        return xsputn(&piece, 1) == 1 ? byte : traits_type::eof();
    }
    int sync() override { return to_->pubsync(); }

    std::ostream& stream_;
    std::streambuf* const to_;
};

/// A second request by the user comes later than same_wish. An immediate repetition is the same request: a
/// terminal and the parent process may both send the signal, and exiting now would leave half-written files.
void take_signal(int signal) {
    const int error_before = errno;
    const std::int64_t now = clock_ns(CLOCK_MONOTONIC);
    std::int64_t first = 0;
    if (first_ns.compare_exchange_strong(first, now)) {
        request_stop();
    } else if (now - first >= std::int64_t{1'000'000} * same_wish.count()) {
        std::signal(signal, SIG_DFL);
        raise(signal);
    }
    errno = error_before;
}

/// A signal that was ignored when the program started stays ignored: nohup, a shell's background.
void catch_signal(int signal) {
    struct sigaction inherited = {};
    sigaction(signal, nullptr, &inherited);
    if (inherited.sa_handler == SIG_IGN) return;
    struct sigaction action = {};
    action.sa_handler = take_signal;
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
}

bool reader_is_gone() {
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    return poll(&output, 1, 0) == 1 && (output.revents & (POLLERR | POLLHUP)) != 0;
}

}  // namespace

void catch_interrupts() {
    catch_signal(SIGINT);
    catch_signal(SIGTERM);
    catch_signal(SIGHUP);           // the terminal is gone
    std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an ordinary error of that write
}

void ignore_stop_keys() {
    for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU}) std::signal(signal, SIG_IGN);
}

bool is_standard_output(const std::filesystem::path& name) {
    return name == "-";
}

void escape_for_terminal() {
    static EscapedOutput words(std::cout), errors(std::cerr);
}

void say_on_stderr(std::string_view words) {
    std::cerr << "touchable: " + printable(words, 2000) + '\n';
}

Result<void> flush_standard_output() {
    std::cout.flush();
    if (std::cout || reader_is_gone()) return {};
    return input_error("standard output cannot be written");
}

StatusLine::StatusLine() {
    const char* const kind = std::getenv("TERM");
    terminal_ = isatty(STDERR_FILENO) == 1 && !(kind && std::string_view(kind) == "dumb");
}

StatusLine::~StatusLine() {
    if (drawn_) std::fputs("\r\033[K", stderr);
}

bool StatusLine::is_due() const {
    return terminal_ &&
           (!drawn_ || std::chrono::steady_clock::now() - last_ >= std::chrono::milliseconds(100));
}

void StatusLine::show(const std::string& text) {
    last_ = std::chrono::steady_clock::now();
    drawn_ = true;
    std::fprintf(stderr, "\r%s\033[K", printable(text, 500).c_str());
}

void Progress::at(std::int64_t done) {
    if (!line_.is_on_terminal() && in_a_log_ == InALog::nothing) return;
    const auto now = std::chrono::steady_clock::now();
    if (line_.is_on_terminal() ? !line_.is_due() : now - logged_ < std::chrono::seconds(10)) return;
    const std::chrono::duration<double> elapsed = now - start_;
    const std::string words = what_ + ' ' + std::to_string(done) +
                              (total_ > 0 ? " of " + std::to_string(total_) : std::string()) +
                              pace_in_words(done, total_, elapsed.count());
    if (line_.is_on_terminal()) return line_.show(words);
    logged_ = now;
    say_on_stderr(words);
}

Result<void> Progress::consume(const TouchTick& tick) {
    at(tick.tick);
    return {};
}

std::string pace_in_words(std::int64_t done, std::int64_t total, double seconds) {
    if (done <= 0 || seconds < 1) return "";
    const double per_second = static_cast<double>(done) / seconds;
    const std::string in_words = formatted(per_second < 10 ? ", %.1f/s" : ", %.0f/s", per_second);
    if (total <= done) return in_words;
    const std::int64_t left = std::llround(std::ceil(static_cast<double>(total - done) / per_second));
    if (left < 100) return in_words + ", " + std::to_string(left) + " s left";
    if (left < 6000) return in_words + ", " + std::to_string((left + 59) / 60) + " min left";
    return in_words + ", " + std::to_string((left + 3599) / 3600) + " h left";
}

Result<void> LiveLine::consume(const TouchTick& tick) {
    ++ticks_;
    next_ = tick.tick + 1;
    newtons_ = 0;
    age_ns_ = tick.time_ns - std::max(tick.pair.prev.time_ns, tick.pair.next.time_ns);
    is_kept_back_ = control_ && control_->waits_to_be_free();
    for (std::size_t finger = 0; finger < tick.forces.size(); ++finger) {
        const GuardedForce& guarded = tick.forces[finger];
        newtons_ = std::max(newtons_, glm::length(tick.sent(finger)));
        is_kept_back_ = is_kept_back_ ||
                        (control_ && control_->force_is_asked() && (guarded.reasons & guard_waiting) != 0);
    }
    return {};
}

void LiveLine::show(const TouchSessionSettings::LiveStatus& status) {
    const std::string silence = silence_ ? silence_(age_ns_) : "";
    if (!line_.is_on_terminal() && is_silent_ == silence.empty()) {
        is_silent_ = !is_silent_;
        say_on_stderr(is_silent_ ? silence : "frames come again");
    }
    if (!line_.is_due()) return;
    const char* const what = !status.is_camera  ? "frames late"
                             : status.has_ended ? "frames felt, and no more come"
                                                : "frames felt";
    std::string words = formatted("live %.1f s, %lld ticks skipped, %lld %s, %.2f N",
                                  static_cast<double>(next_) / 1000, static_cast<long long>(next_ - ticks_),
                                  static_cast<long long>(status.frames), what, newtons_);
    if (device_) words += "; " + device_();
    if (!silence.empty()) words += "; " + silence;
    if (is_kept_back_) words += "; lift the finger off the surface: then it is felt";
    line_.show(words);
}

}  // namespace touchable
