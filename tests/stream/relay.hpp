// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"

namespace touchable::test {

/// Faults of the network, in both directions. They are random, and the same for the same seed and
/// the same traffic.
struct NetworkFaults {
    double loss = 0;              ///< share of datagrams that never arrive, 0 to below 1
    double burst = 1;             ///< how many are lost one after the other, in the mean; from 1
    double delay_ms = 0;          ///< one way
    double jitter_ms = 0;         ///< up to so much more, evenly; what was sent first arrives first
    double bytes_per_second = 0;  ///< of datagrams, one way; what waits for 2 s is lost. 0: as many as come
    std::uint64_t seed = 1;
};

/// A network between a listener on this machine and clients that connect to `port`, on the loopback alone. Of
/// a connection (TCP), which repairs loss by itself, a lost segment of 1448 bytes stops all behind it for a
/// round trip and 10 ms, as a quick retransmission does. Of datagrams (UDP) each client has its own path.
class Relay {
public:
    enum class Kind { tcp, udp };
    /// To `target_port` of 127.0.0.1.
    static Result<std::unique_ptr<Relay>> open(Kind kind, int target_port, const NetworkFaults& faults = {});
    virtual ~Relay() = default;

    virtual int port() const = 0;
    /// Nothing passes while it is stalled: bytes of connections wait, datagrams are lost. Any thread.
    virtual void stall(bool is_stalled) = 0;
    /// Connections that are there break. Any thread.
    virtual void cut() = 0;
    /// Datagrams, or reads of a connection.
    virtual std::int64_t passed() const = 0;
    virtual std::int64_t lost() const = 0;
};

}  // namespace touchable::test
