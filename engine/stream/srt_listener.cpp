#include "engine/stream/srt_listener.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace touchable {
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;

}  // namespace

SrtListener::SrtListener(SrtSocket socket, std::string name, const StreamRing& ring, StreamAudience& audience,
                         std::int64_t now_ns)
    : socket_(std::move(socket)),
      name_(std::move(name)),
      ring_(ring),
      audience_(audience),
      begin_ns_(now_ns),
      cursor_(ring.join()),
      progress_ns_(now_ns) {
    audience_.came(name_);
}

SrtListener::~SrtListener() {
    end("is cut off");
}

bool SrtListener::has_stayed(std::int64_t now_ns) const {
    constexpr std::int64_t short_ns = 1'000'000'000;
    return sent_ > 0 && now_ns - begin_ns_ >= short_ns;
}

void SrtListener::go_on(std::int64_t now_ns) {
    if (phase_ == Phase::over) return;
    if (socket_.state() == SrtSocket::State::gone) return end("has gone");
    look(now_ns);
    read();
    if (phase_ == Phase::listens) write(now_ns);
    if (phase_ == Phase::leaves) leave(now_ns);
    probe(now_ns);
    if (phase_ != Phase::over && now_ns - progress_ns_ > longest_standstill_ns)
        end("took no whole frameset for 10 s");
}

/// How quickly bytes arrive.
void SrtListener::look(std::int64_t now_ns) {
    constexpr std::int64_t figures_every_ns = 50 * ns_per_ms;
    if (now_ns >= next_figures_ns_) {
        next_figures_ns_ = now_ns + figures_every_ns;
        link_ = socket_.figures().value_or(link_);
        // A burst overflows the short queue of a narrow link, so its datagrams are spread.
        const std::int64_t rate = rate_.bytes_per_second();
        const bool is_paced = now_ns < paced_until_ns_ && !rate_.is_growing();
        socket_.pace(is_paced ? std::max<std::int64_t>(2 * rate, 1 << 17) : 0);
    }
    const std::int64_t before =
        std::exchange(arrived_, handed_over_ - static_cast<std::int64_t>(socket_.unacknowledged_bytes()));
    if (arrived_ != before || arrived_ == handed_over_) {
        progress_ns_ = now_ns;
        probes_ = 0;
    }
    if (timed_byte_ > 0 && arrived_ >= timed_byte_) {
        rtt_ns_ = now_ns - timed_since_ns_;
        timed_byte_ = 0;
    }
    rate_.look({.now_ns = now_ns,
                .arrived_bytes = arrived_,
                .datagrams = link_.datagrams,
                .lost = link_.lost,
                .rtt_ns = std::exchange(rtt_ns_, 0),
                .is_full = std::exchange(is_full_, false)});
}

/// A receiver knows what is lost by what comes behind it. Of datagrams that are lost with nothing behind
/// them, as those before the end of its handshake or the last ones of the stream, it would never know.
void SrtListener::probe(std::int64_t now_ns) {
    constexpr std::int64_t shortest_ns = 100 * ns_per_ms;
    constexpr int most_doublings = 4;
    if (phase_ == Phase::over || !rest_.empty() || arrived_ == handed_over_) return;
    const auto rtt_ns = static_cast<std::int64_t>(link_.rtt_ms * static_cast<double>(ns_per_ms));
    const std::int64_t wait_ns = std::max(shortest_ns, 2 * rtt_ns) << std::min(probes_, most_doublings);
    if (probes_ == 0) next_probe_ns_ = progress_ns_ + wait_ns;
    if (now_ns < next_probe_ns_) return;
    const auto done = socket_.send(ring_.padding());
    handed_over_ += std::max<std::ptrdiff_t>(done, 0);
    ++probes_;
    next_probe_ns_ = now_ns + 2 * wait_ns;
}

/// Nothing is expected, and libsrt keeps little of it.
void SrtListener::read() {
    std::array<std::uint8_t, SrtSocket::longest_message> bytes;
    const auto got = socket_.receive(bytes, 0).bytes;
    heard_bytes_ += got > 0 ? static_cast<std::size_t>(got) : 0;
    if (heard_bytes_ > most_heard_bytes) end("sends, but a listener has nothing to send");
}

/// The next thing to be given; false where there is none, or its turn has not come.
bool SrtListener::take_piece(std::int64_t now_ns) {
    constexpr std::int64_t paced_ns = 2'000'000'000;
    if (!has_header_) {
        const auto header = ring_.header();
        if (!header) return false;
        has_header_ = true;
        piece_ = header;
        rest_ = *header;
        return true;
    }
    if (ring_.is_over(cursor_)) {
        phase_ = Phase::leaves;
        return false;
    }
    if (!ring_.has_next(cursor_)) {
        narrow_.has_caught_up();
        return false;
    }
    if (handed_over_ - arrived_ > rate_.window_bytes()) {
        is_full_ = true;
        const bool loses_colour = narrow_.is_behind(now_ns, rate_.is_growing());
        if (loses_colour && !std::exchange(is_said_, true)) audience_.goes_without_colour(name_);
        paced_until_ns_ = now_ns + paced_ns;
        return false;
    }
    if (narrow_.is_far_behind(now_ns) && ring_.go_to_newest_key(cursor_)) narrow_.has_caught_up();
    const auto block = ring_.next(cursor_);
    ++sent_;
    piece_ = block;
    rest_ = block->given(narrow_.gives_colour(block->is_key, now_ns));
    without_colour_ += rest_.size() < block->bytes.size() ? 1 : 0;
    return true;
}

void SrtListener::write(std::int64_t now_ns) {
    while (phase_ == Phase::listens && (!rest_.empty() || take_piece(now_ns))) {
        const auto done = socket_.send(rest_);
        if (done < 0) return end("has gone");
        if (timed_byte_ == 0 && done > 0) {
            timed_byte_ = handed_over_ + 1;
            timed_since_ns_ = now_ns;
        }
        rest_ = rest_.subspan(static_cast<std::size_t>(done));
        handed_over_ += done;
        if (!rest_.empty()) return;
    }
}

/// What is on its way when SRT is closed is lost: once all has arrived, the receiver holds it for its
/// latency.
void SrtListener::leave(std::int64_t now_ns) {
    constexpr std::int64_t more_ms = 200;
    if (arrived_ < handed_over_) return;
    if (!leaves_at_ns_)
        leaves_at_ns_ =
            now_ns +
            (socket_.peer_latency_ms() + 2 * static_cast<std::int64_t>(link_.rtt_ms) + more_ms) * ns_per_ms;
    if (now_ns >= *leaves_at_ns_) end("");
}

void SrtListener::end(const std::string& why) {
    if (phase_ == Phase::over) return;
    link_ = socket_.figures().value_or(link_);
    audience_.went({name_, sent_, cursor_.dropped(), without_colour_, why, link_});
    phase_ = Phase::over;
    socket_.close();
}

}  // namespace touchable
