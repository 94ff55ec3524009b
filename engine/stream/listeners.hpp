#pragma once

// Shared by the servers of a stream (TCP and HTTP: tcp_server.cpp; SRT: srt_output.cpp): what a client asks
// for over HTTP, how much of the stream a listener's link carries, and what it was given; and when what was
// in vain is tried again, by receivers too.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "engine/stream/stream_url.hpp"

namespace touchable {

/// The beginning of the one line that a listener by TCP gets in place of a stream; the reason follows.
inline constexpr std::string_view stream_refusal = "touchable serve: ";

/// Limits on a listener: the connection of one that goes beyond them is closed.
struct StreamListener {
    static constexpr std::int64_t longest_request_ns = 5'000'000'000;  ///< for a whole request by HTTP
    static constexpr std::int64_t longest_piece_ns = 10'000'000'000;   ///< for taking a frameset
    static constexpr std::size_t most_heard_bytes = 65536;  ///< sent by it, though it has nothing to send
};

/// How long is waited before what was tried in vain is tried again, after so many tries since the first:
/// twice as long each time, 16 times as long at most.
inline std::chrono::nanoseconds back_off(std::chrono::nanoseconds first, int tries) {
    constexpr int most_doublings = 4;
    return first * (1 << std::min(tries, most_doublings));
}

/// A client's request to a server that has one stream and nothing else.
class HttpRequest {
public:
    static constexpr std::size_t most_bytes = 8192;

    /// `path`: where the stream is, "/clip.mkv".
    explicit HttpRequest(std::string path) : path_(std::move(path)) {}

    /// More of it. Bytes behind its end are ignored.
    void take(std::string_view bytes);
    /// 0: it is not whole yet; 200: the stream is asked for; 400, 404, 405: it is refused.
    int status() const { return status_; }
    /// Of 200: only the head of the answer is asked for.
    bool is_head() const { return is_head_; }

private:
    int judged(std::string_view head);

    std::string path_, head_;
    int status_ = 0;
    bool is_head_ = false;
};

/// The head of the answer, and of a refusal all of it. 503: there is no place.
std::string http_answer(int status);

/// Decides what a listener on a narrow link goes without: its colour first, then framesets. Colour comes back
/// once the link has kept up without it for a while, which doubles each time that this was in vain. Reads no
/// clock: the caller gives the moments, ns.
class NarrowLink {
public:
    static constexpr std::int64_t colour_goes_after_ns = 150'000'000, framesets_go_after_ns = 300'000'000;
    static constexpr std::int64_t joins_within_ns = 1'000'000'000;
    static constexpr std::int64_t shortest_trial_ns = 5'000'000'000, longest_trial_ns = 80'000'000'000;

    /// The listener has everything that there is, or framesets were left out for it.
    void has_caught_up() { behind_since_ns_.reset(); }
    /// There is a frameset for it, and it cannot be given yet. True: from now on its colour is left out.
    /// `is_tried`: how much its link takes is being found out.
    bool is_behind(std::int64_t now_ns, bool is_tried = false);
    /// Whether it is so far behind that framesets are to be left out, too.
    bool is_far_behind(std::int64_t now_ns) const {
        return behind_since_ns_ && now_ns - *behind_since_ns_ > framesets_go_after_ns;
    }
    /// Whether the next frameset goes with its colour. Decoding of colour begins with a key.
    bool gives_colour(bool is_key, std::int64_t now_ns) {
        if (!has_colour_ && is_key && !behind_since_ns_ && now_ns >= next_trial_ns_) {
            has_colour_ = true;
            colour_back_ns_ = now_ns;
        }
        return has_colour_;
    }

private:
    std::optional<std::int64_t> first_behind_ns_, behind_since_ns_, colour_back_ns_;
    bool has_colour_ = true;
    std::int64_t trial_ns_ = shortest_trial_ns, next_trial_ns_ = 0;
};

/// How much may be on its way to a listener so that its link is never idle and nothing waits long in front of
/// it: the rate at which bytes arrive, times the way there and back, and a little more. What a link cannot
/// take is to be left out before it is sent, since datagrams that queue up are late or lost. Reads no clock.
class LinkRate {
public:
    /// The window of the slowest link, and the one before it is known how quickly bytes arrive.
    static constexpr std::int64_t least_window_bytes = 1 << 16, first_window_bytes = 1 << 18;
    static constexpr std::int64_t slice_ns = 250'000'000;

    /// The state at this moment: bytes that have arrived so far, datagrams sent and lost so far, the way
    /// there and back (0: not known), and whether more would be handed over if the window were larger.
    struct Look {
        std::int64_t now_ns = 0, arrived_bytes = 0, datagrams = 0, lost = 0, rtt_ns = 0;
        bool is_full = false;
    };
    void look(const Look& look);

    /// Whether it is still being found out how much the link takes. Twice what fits on the way may be on it,
    /// until the rate no longer rises by a quarter, or bytes queue up, or all that there is has fitted for a
    /// while.
    bool is_growing() const { return is_growing_; }

    /// The rate of the last second, or of the one before if it was more. What was lost and comes at last is
    /// acknowledged together with all that is behind it, so a shorter time would show more than arrives.
    std::int64_t bytes_per_second() const;

    /// More may be handed over as long as less than this has not been acknowledged.
    std::int64_t window_bytes() const;

private:
    static constexpr std::size_t recent = 8;
    struct Slice {
        double rate = 0;  // bytes a second
        std::int64_t datagrams = 0, lost = 0, rtt_ns = std::numeric_limits<std::int64_t>::max();
        bool is_full = false;
    };
    void grow();
    void forget_shortest();

    std::array<Slice, recent> slices_{};  // a ring
    std::size_t slice_count_ = 0;
    Slice slice_;  // that has not ended
    std::optional<Look> first_in_slice_;
    std::int64_t shortest_ns_ = 0;  // way there and back
    bool is_growing_ = true;
    double fastest_ = 0;           // bytes a second, while it grows
    std::int64_t in_vain_ns_ = 0;  // for which the window was full, and the rate did not grow
    std::int64_t fits_ns_ = 0;     // for which the window was not full
};

}  // namespace touchable
