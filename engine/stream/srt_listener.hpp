#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/stream/link_rate.hpp"
#include "engine/stream/narrow_link.hpp"
#include "engine/stream/srt_socket.hpp"
#include "engine/stream/stream_audience.hpp"
#include "engine/stream/stream_ring.hpp"

namespace touchable {

/// One listener by SRT: is given the stream at the pace of its link, and whole framesets are left out for it
/// alone where that is too slow. Never waits. Moments are of a steady clock, ns.
class SrtListener {
public:
    static constexpr std::int64_t longest_standstill_ns = 10'000'000'000;
    static constexpr std::size_t most_heard_bytes = 65536;

    /// The socket is connected. The ring and the audience outlive it.
    SrtListener(SrtSocket socket, std::string name, const StreamRing& ring, StreamAudience& audience,
                std::int64_t now_ns);
    ~SrtListener();
    SrtListener(const SrtListener&) = delete;
    SrtListener& operator=(const SrtListener&) = delete;

    /// Gives what there is to give and fits.
    void go_on(std::int64_t now_ns);
    /// It can be forgotten.
    bool is_over() const { return phase_ == Phase::over; }
    /// Whether it was given anything, and stayed for a second.
    bool has_stayed(std::int64_t now_ns) const;

private:
    enum class Phase { listens, leaves, over };
    void look(std::int64_t now_ns);
    void read();
    void probe(std::int64_t now_ns);
    void write(std::int64_t now_ns);
    bool take_piece(std::int64_t now_ns);
    void leave(std::int64_t now_ns);
    void end(const std::string& why);

    SrtSocket socket_;
    const std::string name_;
    const StreamRing& ring_;
    StreamAudience& audience_;
    const std::int64_t begin_ns_;
    Phase phase_ = Phase::listens;
    StreamRing::Cursor cursor_;
    LinkRate rate_;
    LinkFigures link_{};
    std::int64_t next_figures_ns_ = 0;
    std::int64_t handed_over_ = 0, arrived_ = 0;  // bytes
    // The way there and back, timed by one byte after the other: libsrt says 100 ms at first, and for long.
    std::int64_t timed_byte_ = 0, timed_since_ns_ = 0, rtt_ns_ = 0;
    std::size_t heard_bytes_ = 0;  // that it sent though it has nothing to say
    std::int64_t progress_ns_;     // when bytes arrived last, or none were on their way
    bool is_full_ = false;         // more would be given if more might be on its way
    std::int64_t next_probe_ns_ = 0;
    int probes_ = 0;  // since bytes arrived last
    NarrowLink narrow_;
    bool is_said_ = false;  // that its colour is left out
    std::int64_t paced_until_ns_ = 0;
    std::int64_t sent_ = 0, without_colour_ = 0;  // framesets
    std::optional<std::int64_t> leaves_at_ns_;
    // What it is being given.
    bool has_header_ = false;
    std::shared_ptr<const void> piece_;
    std::span<const std::uint8_t> rest_;
};

}  // namespace touchable
