#pragma once

#include <chrono>
#include <cstddef>
#include <span>

#include "engine/base/result.hpp"

namespace touchable {

/// Carries a device's bytes, whatever they mean. One thread's. A call that fails says why (ErrorKind::device)
/// and what it was that failed; the device is taken for gone then.
class Transport {
public:
    Transport() = default;
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;
    virtual ~Transport() = default;

    /// All of it, or an error. A transport of messages (HID reports, WebSocket) sends one.
    virtual Result<void> send(std::span<const std::byte> bytes) = 0;
    /// How many bytes came, at most `room`'s; of messages one. Waits for them `patience` at most. 0: none.
    virtual Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) = 0;
    /// Drops what has come and was not received; into `room`, of the longest message.
    Result<void> drop_what_came(std::span<std::byte> room) {
        for (int most = 256; most > 0; --most) {  // whatever babbles must not hold the thread
            const auto came = receive(room, std::chrono::microseconds(0));
            if (!came.ok()) return came.error();
            if (*came == 0) break;
        }
        return {};
    }
    /// The descriptor that poll(2) reports as readable once something has come; -1: there is none.
    virtual int descriptor() const { return -1; }
};

}  // namespace touchable
