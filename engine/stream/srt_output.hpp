#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/result.hpp"
#include "engine/stream/stream_audience.hpp"
#include "engine/stream/stream_ring.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

/// A stream sent to one srt:// URL, by a thread of its own. It takes several callers, each at its own pace,
/// or (mode=caller) calls, and calls again when the other end has gone; one that goes within a second is
/// called again as one that does not answer.
class SrtOutput {
public:
    /// A listener takes its port here. Refused (ErrorKind::usage): another transport, a port 0, and a setting
    /// that SRT does not have; (ErrorKind::input) a port that cannot be had. The ring and the audience
    /// outlive it.
    static Result<std::unique_ptr<SrtOutput>> create(const StreamUrl& url, const StreamRing& ring,
                                                     StreamAudience& audience);
    /// Ends at once what it does, within a tenth of a second.
    virtual ~SrtOutput() = default;

    virtual Result<void> start() = 0;
    /// From any thread: nothing is sent any more, not even what is on its way.
    virtual void end() = 0;
    /// The stream is over, and all of it was given, or nobody is there.
    virtual bool is_over() const = 0;
    /// Whether this end calls; otherwise it listens.
    virtual bool calls() const = 0;

    /// "srt://0.0.0.0:7000", as it was given, without its passphrase.
    std::string address() const { return url_.name(); }
    /// Only a program that knows the passphrase can receive it.
    bool is_encrypted() const { return !url_.value("passphrase").empty(); }

protected:
    explicit SrtOutput(const StreamUrl& url) : url_(url) {}
    const StreamUrl url_;
};

/// How long a caller waits after so many calls in vain, from 1 on: half a second, twice as long each time,
/// eight seconds at most.
std::int64_t wait_before_call_ns(int calls_in_vain);

}  // namespace touchable
