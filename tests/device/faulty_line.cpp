#include "tests/device/faulty_line.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

namespace touchable::test {
namespace {

constexpr std::int64_t kept_ns = 250 * VirtualTime::ms;
constexpr double never_heard = std::numeric_limits<double>::infinity();

}  // namespace

void FaultyLine::begin(Fault fault, std::int64_t lasts_ns) {
    fault_ = fault;
    until_ns_ = time_.now_ns() + lasts_ns;
    delay_ns_ = (1 + below(40)) * VirtualTime::ms;
    struck_ = false;
}

void FaultyLine::lay(std::int64_t due_ns, Message message) {
    const auto later = [](std::int64_t due, const Coming& each) { return due < each.due_ns; };
    coming_.insert(std::upper_bound(coming_.begin(), coming_.end(), due_ns, later),
                   Coming{due_ns, std::move(message)});
}

void FaultyLine::keep(std::int64_t due_ns, const std::optional<glm::dvec3>& place) {
    if (place && std::isnan(place->x)) return;
    words_.push_back({due_ns, place});
    while (words_.front().due_ns < time_.now_ns() - kept_ns) words_.pop_front();
}

void FaultyLine::in_pieces(std::int64_t due_ns, const Message& message, const glm::dvec3& place) {
    const std::size_t first = 1 + below(message.size() - 1);
    const auto middle = message.begin() + static_cast<std::ptrdiff_t>(first);
    const std::int64_t rest_ns = due_ns + below(3) * VirtualTime::ms;
    lay(due_ns, Message(message.begin(), middle));
    lay(rest_ns, Message(middle, message.end()));
    last_due_ns_ = rest_ns;
    if (manner_.is_stream) keep(rest_ns, place);
}

void FaultyLine::tell(Message message, const glm::dvec3& place) {
    const Fault now = fault();
    std::int64_t due_ns = time_.now_ns() + manner_.answers_after_ns;
    // Of what overtakes each other each has a delay of its own.
    if (now == Fault::late) due_ns += manner_.reorders ? below(40) * VirtualTime::ms : delay_ns_;
    if (now == Fault::stalled) due_ns = std::max(due_ns, until_ns_);
    if (!manner_.reorders) due_ns = std::max(due_ns, last_due_ns_);
    last_due_ns_ = due_ns;
    const bool strikes = now != Fault::none && now != Fault::refuses;
    struck_ = struck_ || strikes;
    switch (now) {
        case Fault::lost:
        case Fault::unplugged:
            return;
        case Fault::cut:
            message.resize(below(message.size()));
            return lay(due_ns, std::move(message));
        case Fault::damaged:
            message[below(message.size())] ^= static_cast<std::byte>(1 + below(255));
            if (!manner_.has_checksum) keep(due_ns, std::nullopt);
            return lay(due_ns, std::move(message));
        case Fault::in_pieces:
            return in_pieces(due_ns, message, place);
        case Fault::babble:
            message.resize(below(65));
            for (std::byte& each : message) each = static_cast<std::byte>(below(256));
            return lay(due_ns, std::move(message));
        case Fault::twice:
            lay(due_ns, message);
            break;
        default:
            break;
    }
    keep(due_ns, place);
    lay(due_ns, std::move(message));
}

/// What loses its plug loses its power.
bool FaultyLine::is_cut() {
    const bool cut = fault() == Fault::unplugged;
    if (cut) {
        struck_ = true;
        force_ = 0;
        clear();
    }
    return cut;
}

bool FaultyLine::passes() {
    if (is_cut()) return false;
    if (fault() != Fault::refuses) return true;
    struck_ = true;
    end();
    return false;
}

std::optional<FaultyLine::Message> FaultyLine::next(std::chrono::microseconds patience) {
    const std::int64_t until = time_.now_ns() + std::chrono::nanoseconds(patience).count();
    const auto is_there = [&] { return !coming_.empty() && coming_.front().due_ns <= time_.now_ns(); };
    while (!is_there() && time_.now_ns() < until) {
        const std::int64_t due = coming_.empty() ? until : coming_.front().due_ns;
        time_.pass(std::min({until, due, time_.now_ns() + VirtualTime::ms}) - time_.now_ns());
    }
    if (!is_there()) return std::nullopt;
    Message message = std::move(coming_.front().message);
    coming_.pop_front();
    return message;
}

void FaultyLine::clear() {
    coming_.clear();
    last_due_ns_ = 0;
    std::erase_if(words_, [this](const Word& word) { return word.due_ns > time_.now_ns(); });
}

double FaultyLine::age_of(const glm::dvec3& place) const {
    std::int64_t newest_ns = -1;
    for (const Word& word : words_)
        if (word.due_ns <= time_.now_ns() &&
            (!word.place || glm::length(place - *word.place) <= manner_.place_step))
            newest_ns = std::max(newest_ns, word.due_ns);
    return newest_ns < 0 ? never_heard : static_cast<double>(time_.now_ns() - newest_ns) * 1e-9;
}

double FaultyLine::silence_s() const {
    std::int64_t newest_ns = -1;
    for (const Word& word : words_)
        if (word.due_ns <= time_.now_ns()) newest_ns = std::max(newest_ns, word.due_ns);
    return newest_ns < 0 ? never_heard : static_cast<double>(time_.now_ns() - newest_ns) * 1e-9;
}

}  // namespace touchable::test
