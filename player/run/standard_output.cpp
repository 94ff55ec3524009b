#include "player/run/standard_output.hpp"

#include <poll.h>
#include <unistd.h>
#include <cerrno>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/run/terminal.hpp"

namespace touchable {
namespace {

// Bytes that a ready pipe takes without blocking (PIPE_BUF).
constexpr std::size_t at_once = 4096;
// ms; interval at which a wait polls for a stop request.
constexpr int look_ms = 50;

}  // namespace

Result<void> StandardOutput::write(std::string_view piece) {
    if (gone_ || piece.empty()) return {};
    waiting_ += piece;
    all_ += piece.size();
    if (pace_ == Pace::own) return rest().size() < at_once ? Result<void>() : give_all();
    ends_.push_back(all_);
    while (!rest().empty()) {
        TRY_ASSIGN(const auto taken, give(0));
        if (taken == Taken::nothing_yet) break;
    }
    while (!ends_.empty() && ends_.front() <= written_) ends_.pop_front();
    return ends_.size() > most_waiting ? lagging() : Result<void>();
}

Error StandardOutput::lagging() {
    lags_ = true;
    return input_error("its disk or its reader was too slow for 1000 ticks a second: " +
                       std::to_string(ends_.size()) + " ticks are missing, so it is not complete");
}

/// Writes what fits at once if the reader accepts data within `patience_ms`.
Result<StandardOutput::Taken> StandardOutput::give(int patience_ms) {
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    if (poll(&output, 1, patience_ms) <= 0) return Taken::nothing_yet;
    const std::string_view bytes = rest().substr(0, at_once);
    const ssize_t count = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) return Taken::nothing_yet;
    if (count < 0 && errno != EPIPE)
        return input_error("standard output cannot be written: " + failure_words(errno));
    gone_ = count < 0;  // the reader has closed the pipe: no error
    const std::size_t given = gone_ ? rest().size() : static_cast<std::size_t>(count);
    given_ += given;
    written_ += given;
    if (given_ == waiting_.size() || given_ > 16 * at_once) {
        waiting_.erase(0, given_);
        given_ = 0;
    }
    return Taken::some;
}

Result<void> StandardOutput::give_all() {
    using Clock = std::chrono::steady_clock;
    // A live run that was interrupted still writes its remaining rows.
    const bool was_interrupted = pace_ == Pace::wall_clock && stop_requested();
    std::size_t taken_before = written_;
    Clock::time_point since = Clock::now();
    while (!rest().empty()) {
        TRY_ASSIGN(const auto taken, give(look_ms));
        const bool waits = pace_ == Pace::wall_clock || taken == Taken::nothing_yet;
        if (waits && !was_interrupted && stop_requested()) return interrupted_error();
        if (pace_ == Pace::own || rest().empty()) continue;
        if (written_ - taken_before >= least_taken) {
            taken_before = written_;
            since = Clock::now();
        }
        if (Clock::now() - since < patience_) continue;
        lags_ = true;
        return input_error("its reader takes too little, so it is not complete");
    }
    return {};
}

Result<void> StandardOutput::finish() {
    TRY(flush_standard_output());
    return give_all();
}

}  // namespace touchable
