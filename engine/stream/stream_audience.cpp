#include "engine/stream/stream_audience.hpp"

#include <utility>

namespace touchable {
namespace {

constexpr std::size_t most_remembered = 256;

std::string listeners(int count) {
    return count == 1 ? "1 listener" : std::to_string(count) + " listeners";
}

}  // namespace

void StreamAudience::came(const std::string& name) {
    const std::lock_guard lock(mutex_);
    ++all_;
    say_(name + " listens; " + listeners(there_ + 1));
    ++there_;
}

void StreamAudience::went(ListenerFigures figures) {
    const std::lock_guard lock(mutex_);
    say_(figures.name + (figures.end.empty() ? " has all of it: " : " " + figures.end + ": ") +
         std::to_string(figures.sent) + " framesets sent, " +
         (figures.without_colour > 0 ? std::to_string(figures.without_colour) + " of them without colour, "
                                     : "") +
         std::to_string(figures.dropped) + " left out; " + listeners(there_ - 1));
    if (gone_.size() == most_remembered) gone_.erase(gone_.begin());
    gone_.push_back(std::move(figures));
    --there_;
}

void StreamAudience::goes_without_colour(const std::string& name) {
    remark(name + ": its link is too narrow; colour is left out for it until it keeps up");
}

void StreamAudience::remark(const std::string& line) {
    const std::lock_guard lock(mutex_);
    say_(line);
}

std::vector<ListenerFigures> StreamAudience::gone() const {
    const std::lock_guard lock(mutex_);
    return gone_;
}

std::int64_t StreamAudience::all() const {
    const std::lock_guard lock(mutex_);
    return all_;
}

}  // namespace touchable
