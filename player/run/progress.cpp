#include "player/run/progress.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "engine/base/number_words.hpp"

namespace touchable {

StatusLine::StatusLine() : terminal_(isatty(STDERR_FILENO) == 1) {}

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
    std::fprintf(stderr, "\r%s\033[K", text.c_str());
}

Progress::Progress(std::string what, std::int64_t total, InALog in_a_log)
    : what_(std::move(what)), total_(total), in_a_log_(in_a_log) {}

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
    std::fprintf(stderr, "touchable: %s\n", words.c_str());
}

Result<void> TickProgress::take(const TouchTick& tick) {
    progress_.at(tick.tick);
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

}  // namespace touchable
