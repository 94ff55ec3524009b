#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/stream/http_request.hpp"
#include "engine/stream/narrow_link.hpp"
#include "engine/stream/stream_audience.hpp"
#include "engine/stream/stream_ring.hpp"

namespace touchable {

/// A socket that is closed with its owner.
class OwnedSocket {
public:
    explicit OwnedSocket(int of = -1) : of_(of) {}
    ~OwnedSocket();
    OwnedSocket(OwnedSocket&& other) noexcept : of_(other.of_) { other.of_ = -1; }
    OwnedSocket& operator=(OwnedSocket&& other) noexcept;
    int get() const { return of_; }

private:
    int of_;
};

/// One connection on which somebody asks for a stream, is given it and goes. Never waits. Moments are those
/// of the server's clock, ns.
class StreamListener {
public:
    static constexpr std::int64_t longest_request_ns = 5'000'000'000, longest_piece_ns = 10'000'000'000,
                                  longest_farewell_ns = 1'000'000'000;
    static constexpr std::size_t most_heard_bytes = 65536;

    /// `path`: where HTTP has the stream; nothing: it is given at once. The audience has room for one more,
    /// or whoever asks by HTTP is told that it has not. The socket is one that never waits.
    StreamListener(OwnedSocket socket, std::string name, const std::optional<std::string>& path,
                   const StreamRing& ring, StreamAudience& audience, std::int64_t now_ns);
    ~StreamListener();
    StreamListener(const StreamListener&) = delete;
    StreamListener& operator=(const StreamListener&) = delete;

    int socket() const { return socket_.get(); }
    /// For poll.
    short events() const;
    /// Takes what there is to read, if poll says so, and gives what there is to give.
    void go_on(bool has_something, bool takes_something, std::int64_t now_ns);
    /// When it is closed if nothing happens before.
    std::int64_t deadline_ns() const { return deadline_ns_; }
    /// It can be forgotten.
    bool is_over() const { return phase_ == Phase::over; }

private:
    enum class Phase { asks, is_refused, listens, leaves, over };
    void read(std::int64_t now_ns);
    void write(std::int64_t now_ns);
    bool take_piece(std::int64_t now_ns);
    void answer(std::int64_t now_ns);
    void begin(std::int64_t now_ns);
    void leave(std::int64_t now_ns);
    void end(const std::string& why);

    OwnedSocket socket_;
    const std::string name_;
    const StreamRing& ring_;
    StreamAudience& audience_;
    std::optional<HttpRequest> request_;
    Phase phase_ = Phase::asks;
    StreamRing::Cursor cursor_;
    bool has_header_ = false, is_blocked_ = false, hears_no_more_ = false;
    std::size_t heard_bytes_ = 0;  // that it sent though there was nothing to say
    NarrowLink narrow_;
    bool is_said_ = false;  // that its colour is left out
    std::int64_t sent_ = 0, without_colour_ = 0;
    std::int64_t deadline_ns_;
    // What it is being given.
    std::shared_ptr<const void> piece_;
    std::span<const std::uint8_t> rest_;
    bool is_frameset_ = false;
};

}  // namespace touchable
