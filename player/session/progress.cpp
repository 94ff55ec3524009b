#include "player/session/progress.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

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

Progress::Progress(std::string what, std::int64_t total) : what_(std::move(what)), total_(total) {}

void Progress::at(std::int64_t done) {
    if (!line_.is_due()) return;
    line_.show(what_ + ' ' + std::to_string(done) +
               (total_ > 0 ? " of " + std::to_string(total_) : std::string()));
}

}  // namespace touchable
