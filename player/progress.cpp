#include "player/progress.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

namespace touchable {

Progress::Progress(std::string what, std::int64_t total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::at(std::int64_t done) {
    if (!terminal_) return;
    const auto now = std::chrono::steady_clock::now();
    if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    drawn_ = true;
    if (total_ > 0)
        std::fprintf(stderr, "\r%s %lld of %lld\033[K", what_.c_str(), static_cast<long long>(done),
                     static_cast<long long>(total_));
    else
        std::fprintf(stderr, "\r%s %lld\033[K", what_.c_str(), static_cast<long long>(done));
}

}  // namespace touchable
