// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by the servers of a stream (TCP and HTTP: tcp_server.cpp; SRT: srt_output.cpp): HTTP requests of
// clients, for the stream or for the files of a page beside it, how much of the stream a listener's link
// carries, and what it is sent; and, for receivers, too, when failed attempts are repeated.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "engine/base/files.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

/// Begin of the one line that a TCP listener gets in place of a stream; the reason follows.
inline constexpr std::string_view stream_refusal = "touchable serve: ";

/// Limits on a listener: its connection is closed if it exceeds them.
struct StreamListener {
    static constexpr std::int64_t longest_request_ns = 5'000'000'000;  ///< for a whole HTTP request
    static constexpr std::int64_t longest_piece_ns = 10'000'000'000;   ///< for taking a frameset
    static constexpr std::size_t most_heard_bytes = 65536;  ///< received, though it has nothing to send
};

/// Delay before a failed attempt is repeated, after `tries` attempts since the first: doubled each time, 16
/// times `first` at most.
inline std::chrono::nanoseconds back_off(std::chrono::nanoseconds first, int tries) {
    constexpr int most_doublings = 4;
    return first * (1 << std::min(tries, most_doublings));
}

/// A client's HTTP request to a server that has one stream, and perhaps the files of a page.
class HttpRequest {
public:
    static constexpr std::size_t most_bytes = 8192;

    /// `path`: of the stream, such as "/clip.mkv".
    explicit HttpRequest(std::string path) : path_(std::move(path)) {}

    /// Adds bytes of the request. Bytes behind its end are ignored.
    void take(std::string_view bytes);
    /// 0: not complete yet; 200: it requests the stream; 404: another name; 400, 405: it is refused.
    int status() const { return status_; }
    /// With 200 and 404: it requests only the head of the answer.
    bool is_head() const { return is_head_; }
    /// With 200 and 404: what it requests, such as "/index.html", without a query.
    std::string_view target() const { return target_; }
    /// A field of its head, by a name in small letters; empty if it is missing.
    std::string_view field(std::string_view name) const;

private:
    int judged(std::string_view head);

    std::string path_, head_, target_;
    int status_ = 0;
    bool is_head_ = false;
};

/// The head of the answer; of a refusal, all of it. 503: no room for another listener. `type`: of the stream.
std::string http_answer(int status, std::string_view type = "video/x-matroska");

/// An answer with a file, or with a part of it (RFC 9110, 14): its head, then the file's bytes from `at` to
/// `end`. A file that may not be had is refused in the head, without a file.
struct ServedFile {
    std::string head;
    Descriptor file{};
    std::uint64_t at = 0, end = 0;
};
/// Answers a request for a file of the first of these folders that has it; "/" is index.html. Only files of
/// the kinds that a page has, and none of a folder inside, can be had.
ServedFile served_file(const HttpRequest& request, std::span<const std::filesystem::path> folders);

/// Decides what a listener on a narrow link does not get: its colour first, then framesets. Colour comes back
/// after the link has kept up without it for a while, which doubles with each failed trial. Reads no clock:
/// the caller passes the times, ns.
class NarrowLink {
public:
    static constexpr std::int64_t colour_goes_after_ns = 150'000'000, framesets_go_after_ns = 300'000'000;
    static constexpr std::int64_t joins_within_ns = 1'000'000'000;
    static constexpr std::int64_t shortest_trial_ns = 5'000'000'000, longest_trial_ns = 80'000'000'000;

    /// The listener has everything so far, or framesets were left out for it.
    void has_caught_up() { behind_since_ns_.reset(); }
    /// A frameset waits that the listener cannot take yet. True: from now on its colour is left out.
    /// `is_tried`: the link's capacity is still being measured.
    bool is_behind(std::int64_t now_ns, bool is_tried = false);
    /// Whether the listener is so far behind that framesets are left out, too.
    bool is_far_behind(std::int64_t now_ns) const {
        return behind_since_ns_ && now_ns - *behind_since_ns_ > framesets_go_after_ns;
    }
    /// Whether the next frameset is sent with its colour, whose decoding begins with a key.
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

/// Limits what is under way to a listener, so that its link is never idle and nothing waits long before it:
/// the rate at which bytes arrive, times the round trip, and a little more. What a link cannot take has to be
/// left out before it is sent, since datagrams that queue up are late or lost. Reads no clock.
class LinkRate {
public:
    /// The window of the slowest link, and the one until the arrival rate is known.
    static constexpr std::int64_t least_window_bytes = 1 << 16, first_window_bytes = 1 << 18;
    static constexpr std::int64_t slice_ns = 250'000'000;

    /// The state at a moment: bytes arrived so far, datagrams sent and lost so far, the round trip (0:
    /// unknown), and whether more would be sent if the window were larger.
    struct Look {
        std::int64_t now_ns = 0, arrived_bytes = 0, datagrams = 0, lost = 0, rtt_ns = 0;
        bool is_full = false;
    };
    void look(const Look& look);

    /// Whether the link's capacity is still being measured. Twice the bytes of a round trip may be under way,
    /// until the rate no longer rises by a quarter, bytes queue up, or everything has fitted for a while.
    bool is_growing() const { return is_growing_; }

    /// The rate of the last second, or of the one before if it was higher. A resent datagram is acknowledged
    /// together with all data behind it, so a shorter time would show more than arrives.
    std::int64_t bytes_per_second() const;

    /// More may be sent as long as fewer bytes than this are unacknowledged.
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
    Slice slice_;  // not complete yet
    std::optional<Look> first_in_slice_;
    std::int64_t shortest_ns_ = 0;  // round trip
    bool is_growing_ = true;
    double fastest_ = 0;           // bytes a second, while it grows
    std::int64_t in_vain_ns_ = 0;  // with a full window and no higher rate
    std::int64_t fits_ns_ = 0;     // without a full window
};

}  // namespace touchable
