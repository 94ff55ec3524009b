#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device/device_driver.hpp"
#include "device/haply_service.hpp"
#include "device/inverse3_protocol.hpp"
#include "device/steady_time.hpp"

namespace touchable {

/// Which arm, and what it bears.
struct Inverse3Choice {
    std::uint16_t port = 10001;
    std::string id;                          ///< of the arm; empty: the only one
    std::optional<Inverse3Version> version;  ///< of the service, where it does not say it itself
    glm::dvec3 centre{0, 0.15, 0.12};        ///< of its workspace from its base, metres, our axes
    DeviceLimits limits{5, 1000};
};

/// An Inverse3 of Haply through the service of its makers. The service answers each message with one: so a
/// force goes out whether there is one or not, and what comes back is the position.
class Inverse3Driver final : public DeviceDriver {
public:
    /// The service is asked no more often, whatever it could.
    static constexpr std::chrono::microseconds shortest_turn{500};
    /// Messages under way, of which more would only wait in the service; a zero always goes out.
    static constexpr int most_unanswered = 2;
    static constexpr std::chrono::milliseconds longest_answer{500};
    static constexpr int most_nonsense = 50;  ///< messages one after the other that cannot be read

    Inverse3Driver(Inverse3Choice choice, std::unique_ptr<HaplyService> service,
                   DriverClock clock = steady_ns);
    ~Inverse3Driver() override { disconnect(); }

    std::string name() const override { return "Inverse3"; }
    int fingers() const override { return 1; }
    DeviceLimits limits() const override { return choice_.limits; }
    DeviceCapabilities capabilities() const override;
    Result<void> connect(const GivenUp& given_up) override;
    void disconnect() noexcept override;
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override;
    std::optional<ZeroForcePacket> zero_force_packet() const override;
    std::string prompt() const override;

    /// What the service said of itself when it was connected: its version, the arm, the settings that change
    /// forces. Empty: it was not.
    std::string service_in_words() const;

private:
    std::int64_t ns_since(std::int64_t moment_ns) const { return clock_() - moment_ns; }
    Result<void> learn_version(const GivenUp& given_up);
    Result<Inverse3Message> await(bool (*enough)(const Inverse3Message&), const GivenUp& given_up);
    Result<void> choose(const std::vector<Inverse3Arm>& arms);
    Result<void> send_text(const std::string& text);
    Result<std::optional<Inverse3Message>> receive_message(std::chrono::microseconds patience);
    Result<bool> take(const Inverse3Message& message, DeviceSample& sample);
    std::string zero() const;

    const Inverse3Choice choice_;
    const std::unique_ptr<HaplyService> service_;
    const DriverClock clock_;
    std::unique_ptr<Transport> transport_;
    std::vector<std::byte> room_;
    // Of this connection.
    Inverse3Version version_;
    Inverse3Dialect dialect_ = Inverse3Dialect::vector;
    std::string id_;
    Inverse3Settings settings_;
    std::string trouble_;
    int unanswered_ = 0, nonsense_ = 0;
    bool pushed_ = false;  // the last force that went out was not zero
    std::int64_t said_ns_ = 0, answered_ns_ = 0;
};

}  // namespace touchable
