#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "device/device_driver.hpp"
#include "device/transport.hpp"

namespace touchable {

/// A program on this machine that answers HTTP requests and exchanges messages over a WebSocket, both at one
/// port. Errors are ErrorKind::device, and ErrorKind::interrupted where the caller has given up.
class HaplyService {
public:
    HaplyService() = default;
    HaplyService(const HaplyService&) = delete;
    HaplyService& operator=(const HaplyService&) = delete;
    virtual ~HaplyService() = default;

    virtual std::string address() const = 0;  ///< "ws://localhost:10001"
    /// The body of what it answers to GET `path`, of 64 KiB at most; empty where the answer is not 200.
    virtual Result<std::string> get(const std::string& path, std::chrono::milliseconds patience,
                                    const GivenUp& given_up) = 0;
    /// A transport of texts.
    virtual Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds patience,
                                                       const GivenUp& given_up) = 0;
};

/// By libwebsockets, which prints nothing here and leaves SIGPIPE as it was.
class LocalHaplyService final : public HaplyService {
public:
    static constexpr std::size_t longest_message = 256 * 1024;  ///< bytes

    explicit LocalHaplyService(std::uint16_t port) : port_(port) {}

    std::string address() const override { return "ws://localhost:" + std::to_string(port_); }
    Result<std::string> get(const std::string& path, std::chrono::milliseconds patience,
                            const GivenUp& given_up) override;
    Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds patience,
                                               const GivenUp& given_up) override;

private:
    const std::uint16_t port_;
};

}  // namespace touchable
