#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/wake.hpp"
#include "engine/stream/stream_audience.hpp"
#include "engine/stream/stream_listener.hpp"
#include "engine/stream/stream_ring.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

/// Gives a stream to whoever connects, by TCP or HTTP, to each at its own pace: one that is slow or hostile
/// costs the others nothing.
class StreamServer {
public:
    static constexpr int most_connections = 96;
    using Clock = std::function<std::int64_t()>;  ///< ns, of any beginning; never backward

    /// Listens at tcp:// and http:// names; port 0 is any that is free. The ring and the audience outlive it.
    /// Refused is (ErrorKind::usage) a host that is no address of numbers, and (ErrorKind::input) an address
    /// that cannot be had.
    static Result<std::unique_ptr<StreamServer>> open(const std::vector<StreamUrl>& urls, StreamRing& ring,
                                                      StreamAudience& audience, Clock clock = steady_clock());
    static Clock steady_clock();
    /// Closes everything at once.
    ~StreamServer();

    /// Where it listens: "tcp://0.0.0.0:7000".
    std::vector<std::string> addresses() const;
    /// Its thread, which takes turns until the server is destroyed.
    Result<void> start();
    /// Waits so long for something to do, and does it. Not beside that thread.
    void turn(std::chrono::milliseconds longest);
    /// Connections, with those that listen and those that do not yet or no more.
    int connections() const { return connections_; }

private:
    struct Door {
        OwnedSocket socket;
        StreamUrl url;
    };
    StreamServer(StreamRing& ring, StreamAudience& audience, Clock clock)
        : ring_(ring), audience_(audience), clock_(std::move(clock)) {}
    Result<void> open_door(const StreamUrl& url);
    void accept_from(const Door& door);
    void refuse(const OwnedSocket& socket, const Door& door, const std::string& name);
    int timeout_ms(std::chrono::milliseconds longest, std::int64_t now_ns) const;

    StreamRing& ring_;
    StreamAudience& audience_;
    const Clock clock_;
    std::shared_ptr<Wake> wake_ = std::make_shared<Wake>();  // the ring has it too
    std::vector<Door> doors_;
    std::vector<std::unique_ptr<StreamListener>> listeners_;
    std::atomic<int> connections_{0};
    std::int64_t doors_closed_until_ns_ = 0, next_refusal_said_ns_ = 0;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace touchable
