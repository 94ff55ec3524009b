// SPDX-License-Identifier: Apache-2.0
#pragma once

// Haply's Inverse3: the messages and the service of its makers, up to `--device inverse3`.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "device/drivers/device_driver.hpp"
#include "engine/base/result.hpp"

namespace touchable {

// ---- Messages

// The messages of Haply's Inverse Service, as its public pages give them: docs.haply.co/inverseSDK/service
// (realtime/websocket-protocol, realtime/control-commands, commons/basis, commons/json-conventions, api/http)
// for 3.5, and the public Python samples of its makers for the versions before. Its axes are x right,
// y forward, z up; here they are turned to ours, x right, y up, z towards the person.

/// Form of a force in messages: {"values": {x, y, z}} before 3.5, {"vector": ...} since.
enum class Inverse3Dialect { values, vector };

struct Inverse3Version {
    int major = 0, minor = 0;
};

/// Parses a version such as "3.5.0.0" or "3.4". Error (device): it is none.
Result<Inverse3Version> parse_inverse3_version(std::string_view words);
/// Version in the answer to GET /version. Error (device): it has none.
Result<Inverse3Version> decode_inverse3_version(std::string_view answer);
/// Dialect of a version. Error (device), by name and version: one before 3.1 or from 4.0 on.
Result<Inverse3Dialect> inverse3_dialect(const Inverse3Version& version);

/// One arm's entry in a message.
struct Inverse3Arm {
    std::string id;                   ///< printable, at most 64 bytes
    std::optional<glm::dvec3> place;  ///< of the cursor, metres, our axes, without the service's `transform`
    /// Its place, by the configured mount, and the preset, which may move the origin; nothing in messages
    /// without them.
    std::optional<glm::dvec3> base;
    std::optional<std::string> preset;
    std::optional<bool> powered, calibrated, ready;
    /// The first setting that changes lengths, axes or the sign of forces, and the right value; empty: none.
    std::string unusable;
    std::string settings;  ///< others that change what is felt; only in a message with configurations
};

struct Inverse3Message {
    std::vector<Inverse3Arm> arms;
    std::uint32_t buttons = 0;  ///< first grip: bits 0 to 2 are a, b, c; a wired one: bit 0
};

/// Error (device): the text is no message of the service, with what it is instead. Entries without an id are
/// left out, and members of a wrong type count as missing.
Result<Inverse3Message> decode_inverse3_message(std::string_view text);
/// Value in the answer to GET /settings/devices/force_scale. Nothing: it has none.
std::optional<double> decode_force_scale(std::string_view answer);

/// Encodes a finite force, newtons, our axes. The service answers it with one message.
std::string encode_inverse3_force(Inverse3Dialect dialect, const std::string& id, const glm::dvec3& newtons);

/// Encodes a text of at most 65535 bytes as one WebSocket frame of a client (RFC 6455, 5.2).
std::vector<std::byte> web_socket_frame(std::string_view text, std::uint32_t mask);

// ---- The service

/// A program on this machine that answers HTTP requests and exchanges messages over a WebSocket, both at one
/// port. Errors are ErrorKind::device, or ErrorKind::interrupted if the caller cancelled.
class HaplyService : NonCopyable {
public:
    virtual ~HaplyService() = default;

    virtual std::string address() const = 0;  ///< "ws://localhost:10001"
    /// Body of the answer to GET `path`, at most 64 KiB; empty if its status is not 200.
    virtual Result<std::string> get(const std::string& path, std::chrono::milliseconds patience) = 0;
    /// A transport of text messages.
    virtual Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds patience) = 0;
};

/// Uses libwebsockets, without its log output, and leaves SIGPIPE as it was.
class LocalHaplyService final : public HaplyService {
public:
    static constexpr std::size_t longest_message = 256 * 1024;  ///< bytes

    explicit LocalHaplyService(std::uint16_t port) : port_(port) {}

    std::string address() const override { return "ws://localhost:" + std::to_string(port_); }
    Result<std::string> get(const std::string& path, std::chrono::milliseconds patience) override;
    Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds patience) override;

private:
    const std::uint16_t port_;
};

// ---- The driver and its keys

/// Which arm to use, and its limits.
struct Inverse3Choice {
    std::uint16_t port = 10001;
    std::string id;                          ///< of the arm; empty: the only one
    std::optional<Inverse3Version> version;  ///< of the service, if the service does not report it
    glm::dvec3 centre{0, 0.15, 0.12};        ///< of the workspace from the base, metres, our axes
    DeviceLimits limits{5, 1000};
};

/// Haply's Inverse3 through its makers' service. The service answers each message with one, so a force, zero
/// if need be, is always sent, and the answer is the position.
class Inverse3Driver final : public DeviceDriver {
public:
    /// Shortest interval between messages, even if the service could answer faster.
    static constexpr std::chrono::microseconds shortest_turn{500};
    /// Limit of unanswered messages; more would only wait in the service. The first zero always goes out.
    static constexpr int most_unanswered = 2;
    static constexpr std::chrono::milliseconds longest_answer{500};
    static constexpr int most_nonsense = 50;  ///< consecutive unreadable messages

    Inverse3Driver(Inverse3Choice choice, std::unique_ptr<HaplyService> service, DriverClock clock = boot_ns)
        : choice_(std::move(choice)),
          service_(std::move(service)),
          clock_(std::move(clock)),
          room_(LocalHaplyService::longest_message) {}
    ~Inverse3Driver() override { disconnect(); }

    std::string name() const override { return "Inverse3"; }
    DeviceLimits limits() const override { return choice_.limits; }
    /// The reach is that of the sphere in which the service's tutorial on positions keeps its targets.
    DeviceCapabilities capabilities() const override {
        return {.reach = glm::dvec3(0.1),
                .rate_hz = 1e6 / static_cast<double>(shortest_turn.count()),
                .buttons = 3,
                .answers = true};
    }
    Result<void> connect() override;
    void disconnect() noexcept override;
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override {
        unanswered_ = 0;
        return transport_->drop_what_came(room_);
    }
    std::optional<ZeroForcePacket> zero_force_packet() const override;
    std::string prompt() const override {
        if (id_.empty()) return {};
        if (!trouble_.empty()) return "Inverse3 " + id_ + " " + trouble_;
        return settings_.empty() ? std::string()
                                 : "the Haply service changes what is felt (" + settings_ +
                                       "); change it in Haply Hub if that is not meant";
    }

private:
    std::int64_t ns_since(std::int64_t moment_ns) const { return clock_() - moment_ns; }
    Result<void> learn_version();
    Result<Inverse3Message> await(bool (*enough)(const Inverse3Message&));
    Result<void> choose(const std::vector<Inverse3Arm>& arms);
    Result<void> check(const Inverse3Arm& arm) const;
    Result<void> send_text(const std::string& text);
    Result<std::optional<Inverse3Message>> receive_message(std::chrono::microseconds patience);
    Result<bool> take(const Inverse3Message& message, DeviceSample& sample);
    std::string zero() const { return encode_inverse3_force(dialect_, id_, glm::dvec3(0)); }

    const Inverse3Choice choice_;
    const std::unique_ptr<HaplyService> service_;
    const DriverClock clock_;
    std::unique_ptr<Transport> transport_;
    std::vector<std::byte> room_;
    // State of the current connection.
    Inverse3Dialect dialect_ = Inverse3Dialect::vector;
    std::string id_;
    double force_scale_ = 1;  // of the service, on all forces
    glm::dvec3 base_{0.0};
    std::string preset_, settings_, trouble_;
    int unanswered_ = 0, nonsense_ = 0;
    bool pushed_ = false;  // the last force sent was not zero
    std::int64_t said_ns_ = 0, answered_ns_ = 0;
};

/// Choice of "inverse3[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) invalid keys.
Result<Inverse3Choice> read_inverse3_choice(std::string_view keys);
Result<std::unique_ptr<DeviceDriver>> make_inverse3_driver(std::string_view keys);

}  // namespace touchable
