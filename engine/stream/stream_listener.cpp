#include "engine/stream/stream_listener.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <limits>
#include <system_error>
#include <utility>

namespace touchable {
namespace {

constexpr std::int64_t no_deadline = std::numeric_limits<std::int64_t>::max();

bool would_wait(int failure) {
    return failure == EAGAIN || failure == EWOULDBLOCK || failure == EINTR;
}

std::shared_ptr<const std::string> shared_text(std::string text) {
    return std::make_shared<const std::string>(std::move(text));
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

OwnedSocket::~OwnedSocket() {
    if (of_ >= 0) ::close(of_);
}

OwnedSocket& OwnedSocket::operator=(OwnedSocket&& other) noexcept {
    std::swap(of_, other.of_);
    return *this;
}

StreamListener::StreamListener(OwnedSocket socket, std::string name, const std::optional<std::string>& path,
                               const StreamRing& ring, StreamAudience& audience, std::int64_t now_ns)
    : socket_(std::move(socket)),
      name_(std::move(name)),
      ring_(ring),
      audience_(audience),
      deadline_ns_(now_ns + longest_request_ns) {
    if (path)
        request_.emplace(*path);
    else
        begin(now_ns);
}

StreamListener::~StreamListener() {
    end("is cut off");
}

short StreamListener::events() const {
    const int reads = hears_no_more_ ? 0 : POLLIN, writes = is_blocked_ ? POLLOUT : 0;
    return static_cast<short>(reads | writes);
}

void StreamListener::go_on(bool has_something, bool takes_something, std::int64_t now_ns) {
    if (has_something) read(now_ns);
    if (takes_something) is_blocked_ = false;
    if (!is_blocked_) write(now_ns);
    if (phase_ == Phase::over || now_ns < deadline_ns_) return;
    end(phase_ == Phase::listens ? "took no whole frameset for 10 s" : "");
}

void StreamListener::read(std::int64_t now_ns) {
    std::array<char, 4096> bytes;
    const auto got = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got < 0 && would_wait(errno)) return;
    if (got < 0) return end("is lost (" + std::generic_category().message(errno) + ")");
    if (got == 0) {
        // It may still listen, who has nothing more to say; but not who never was given anything.
        hears_no_more_ = true;
        const bool has_begun = phase_ == Phase::listens && has_header_;
        if (!has_begun && phase_ != Phase::is_refused) end("has gone");
        return;
    }
    const auto count = static_cast<std::size_t>(got);
    if (phase_ == Phase::asks) {
        request_->take({bytes.data(), count});
        if (request_->status() != 0) answer(now_ns);
        return;
    }
    heard_bytes_ += count;
    if (heard_bytes_ > most_heard_bytes) end("sends, but a listener has nothing to send");
}

void StreamListener::answer(std::int64_t now_ns) {
    int status = request_->status();
    if (status == 200 && !request_->is_head() && !audience_.has_room()) status = 503;
    const auto words = shared_text(http_answer(status));
    piece_ = words;
    rest_ = bytes_of(*words);
    if (status == 200 && !request_->is_head()) return begin(now_ns);
    phase_ = Phase::is_refused;
    deadline_ns_ = now_ns + longest_request_ns;
}

void StreamListener::begin(std::int64_t now_ns) {
    phase_ = Phase::listens;
    deadline_ns_ = rest_.empty() ? no_deadline : now_ns + longest_piece_ns;
    cursor_ = ring_.join();
    audience_.came(name_);
}

/// The next thing to be given, once all before is; false where there is none.
bool StreamListener::take_piece(std::int64_t now_ns) {
    sent_ += is_frameset_ ? 1 : 0;
    is_frameset_ = false;
    piece_.reset();
    deadline_ns_ = no_deadline;
    if (phase_ == Phase::is_refused) {
        leave(now_ns);
        return false;
    }
    if (!has_header_) {
        const auto header = ring_.header();
        if (!header) return false;
        has_header_ = true;
        piece_ = header;
        rest_ = *header;
    } else if (const auto block = ring_.next(cursor_)) {
        is_frameset_ = true;
        piece_ = block;
        rest_ = block->given(narrow_.gives_colour(block->is_key, now_ns));
        without_colour_ += rest_.size() < block->bytes.size() ? 1 : 0;
    } else {
        narrow_.has_caught_up();
        if (ring_.is_over(cursor_)) leave(now_ns);
        return false;
    }
    deadline_ns_ = now_ns + longest_piece_ns;
    return true;
}

void StreamListener::write(std::int64_t now_ns) {
    while (phase_ == Phase::listens || phase_ == Phase::is_refused) {
        if (rest_.empty() && !take_piece(now_ns)) return;
        const auto done = ::send(socket_.get(), rest_.data(), rest_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (done >= 0) {
            rest_ = rest_.subspan(static_cast<std::size_t>(done));
            continue;
        }
        if (!would_wait(errno))
            return end(errno == EPIPE || errno == ECONNRESET
                           ? "has gone"
                           : "is lost (" + std::generic_category().message(errno) + ")");
        is_blocked_ = true;
        if (phase_ == Phase::listens && ring_.has_next(cursor_) && narrow_.is_behind(now_ns) &&
            !std::exchange(is_said_, true))
            audience_.goes_without_colour(name_);
        return;
    }
}

/// What was given is still on its way: a socket that is closed with something unread loses it.
void StreamListener::leave(std::int64_t now_ns) {
    if (phase_ == Phase::listens) audience_.went({name_, sent_, cursor_.dropped(), without_colour_});
    ::shutdown(socket_.get(), SHUT_WR);
    phase_ = hears_no_more_ ? Phase::over : Phase::leaves;
    deadline_ns_ = now_ns + longest_farewell_ns;
}

void StreamListener::end(const std::string& why) {
    if (phase_ == Phase::listens) audience_.went({name_, sent_, cursor_.dropped(), without_colour_, why});
    phase_ = Phase::over;
}

}  // namespace touchable
