#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "engine/result.hpp"
#include "engine/stream/sender_time.hpp"
#include "engine/stream/stream_audience.hpp"
#include "engine/stream/stream_ring.hpp"
#include "engine/stream/stream_url.hpp"

struct AVDictionary;
struct AVIOContext;

namespace touchable {

/// How long whoever calls waits after so many calls in vain, from 1 on: half a second, twice as long each
/// time, eight seconds at most.
std::int64_t wait_before_call_ns(int calls_in_vain);

/// A stream on a way of FFmpeg's that has one listener at a time, by a thread of its own: SRT, which is
/// called (or calls, with mode=caller), and goes on with the next caller (or calls again) when one has gone;
/// whoever it calls and goes within a second is called again as one that does not answer;
/// UDP, which sends to whoever may be there.
class StreamOutput {
public:
    /// Opens nothing yet. Refused (ErrorKind::usage): another transport, a port 0, and what no setting of the
    /// name may be. The ring and the audience outlive it.
    static Result<std::unique_ptr<StreamOutput>> create(const StreamUrl& url, const StreamRing& ring,
                                                        StreamAudience& audience);
    /// Ends at once what it does, within what FFmpeg takes to see it: a tenth of a second.
    ~StreamOutput();

    /// "srt://0.0.0.0:7000", as whoever listens has to name it, or as it was given;
    /// without its passphrase.
    std::string address() const { return url_.name(); }
    bool calls() const { return calls_; }
    /// Only a program that knows the passphrase can receive it.
    bool is_encrypted() const { return !url_.value("passphrase").empty(); }
    Result<void> start();
    /// From any thread: nothing is sent any more, not even what is on its way.
    void end();
    /// The stream is over, and all of it was given, or nobody is there.
    bool is_over() const { return is_over_; }

private:
    struct Closer {
        void operator()(AVIOContext* io) const;
    };
    using Output = std::unique_ptr<AVIOContext, Closer>;
    StreamOutput(const StreamUrl& url, const StreamRing& ring, StreamAudience& audience);
    void send_all();
    Output open();
    void set_options(AVDictionary*& options) const;
    bool give_all(AVIOContext& output, std::span<const std::uint8_t> bytes);
    std::string send_to(AVIOContext& output, ListenerFigures& figures);
    void wait_for_arrival();
    bool was_for_long(AVIOContext& output);
    bool waits_for_next(int calls);

    const StreamUrl url_;
    const StreamRing& ring_;
    StreamAudience& audience_;
    const bool calls_;
    int failure_ = 0;  // FFmpeg's, of the newest `open`
    SteadySenderTime time_;
    std::atomic<bool> stop_{false}, is_open_{false}, is_over_{false};
    std::thread thread_;
};

}  // namespace touchable
