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

/// How a version of the service wants a force to be said: {"values": {x, y, z}} before 3.5, {"vector": ...}
/// since.
enum class Inverse3Dialect { values, vector };

struct Inverse3Version {
    int major = 0, minor = 0;
};

/// What was said about a service's version: "3.5.0.0", "3.4". Error (device): it is none.
Result<Inverse3Version> parse_inverse3_version(std::string_view words);
/// Of the answer to GET /version. Error (device): it tells of no version.
Result<Inverse3Version> decode_inverse3_version(std::string_view answer);
/// Error (device), by name and version: one before 3.1 or from 4.0 on.
Result<Inverse3Dialect> inverse3_dialect(const Inverse3Version& version);

/// How the service changes forces and positions of an arm. Nothing: it did not say.
struct Inverse3Settings {
    std::optional<double> damping;             ///< its filter's scalar
    std::optional<double> force_gate;          ///< gain left to a force while the arm oscillates
    std::optional<double> force_scale;         ///< all forces times this, from /settings
    std::optional<bool> gravity_compensation;  ///< it carries the arm's weight
    std::optional<double> gravity_scale;       ///< times this
    std::optional<bool> torque_scaling;
    std::string basis;  ///< permutation of axes; empty: not said
};

/// One arm, as a message tells of it.
struct Inverse3Arm {
    std::string id;                   ///< printable, at most 64 bytes
    std::optional<glm::dvec3> place;  ///< of the cursor from the base, metres, our axes
    std::optional<bool> powered, calibrated, ready;
    std::optional<Inverse3Settings> settings;  ///< of a message with configurations
};

struct Inverse3Message {
    std::vector<Inverse3Arm> arms;
    std::uint32_t buttons = 0;  ///< of the first grip: bits 0 to 2 are a, b, c; of a wired one bit 0
};

/// Error (device): what it is instead of a message of the service. Entries without an id are left out, and
/// members of a wrong type count as missing.
Result<Inverse3Message> decode_inverse3_message(std::string_view text);
/// Of the answer to GET /settings/devices/force_scale. Nothing: it tells none.
std::optional<double> decode_force_scale(std::string_view answer);

/// A force, newtons, our axes, finite. The service answers it with one message.
std::string encode_inverse3_force(Inverse3Dialect dialect, const std::string& id, const glm::dvec3& newtons);

/// The settings that a person should know of, in words; empty: none was said.
std::string in_words(const Inverse3Settings& settings);
/// Of them what makes forces differ from those that are asked for; empty: nothing.
std::string altered_forces(const Inverse3Settings& settings);

/// A text as one WebSocket frame of a client (RFC 6455, 5.2), at most 65535 bytes of it.
std::vector<std::byte> web_socket_frame(std::string_view text, std::uint32_t mask);

// ---- The service

/// A program on this machine that answers HTTP requests and exchanges messages over a WebSocket, both at one
/// port. Errors are ErrorKind::device, and ErrorKind::interrupted where the caller has given up.
class HaplyService : NonCopyable {
public:
    virtual ~HaplyService() = default;

    virtual std::string address() const = 0;  ///< "ws://localhost:10001"
    /// The body of what it answers to GET `path`, of 64 KiB at most; empty where the answer is not 200.
    virtual Result<std::string> get(const std::string& path, std::chrono::milliseconds patience) = 0;
    /// A transport of texts.
    virtual Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds patience) = 0;
};

/// By libwebsockets, which prints nothing here and leaves SIGPIPE as it was.
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
    /// The service is asked no more often, even if it could answer.
    static constexpr std::chrono::microseconds shortest_turn{500};
    /// Messages under way, of which more would only wait in the service; a zero always goes out.
    static constexpr int most_unanswered = 2;
    static constexpr std::chrono::milliseconds longest_answer{500};
    static constexpr int most_nonsense = 50;  ///< messages one after the other that cannot be read

    Inverse3Driver(Inverse3Choice choice, std::unique_ptr<HaplyService> service,
                   DriverClock clock = steady_ns)
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
        const std::string altered = altered_forces(settings_);
        return altered.empty()
                   ? altered
                   : "the Haply service " + altered + "; change it in Haply Hub if that is not meant";
    }

    /// What the service said of itself when it was connected: its version, the arm, the settings that change
    /// forces. Empty: it was not.
    std::string service_in_words() const;

private:
    std::int64_t ns_since(std::int64_t moment_ns) const { return clock_() - moment_ns; }
    Result<void> learn_version();
    Result<Inverse3Message> await(bool (*enough)(const Inverse3Message&));
    Result<void> choose(const std::vector<Inverse3Arm>& arms);
    Result<void> send_text(const std::string& text);
    Result<std::optional<Inverse3Message>> receive_message(std::chrono::microseconds patience);
    Result<bool> take(const Inverse3Message& message, DeviceSample& sample);
    std::string zero() const { return encode_inverse3_force(dialect_, id_, glm::dvec3(0)); }

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

/// Of the keys of "inverse3[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) what is none.
Result<Inverse3Choice> read_inverse3_choice(std::string_view keys);
Result<std::unique_ptr<DeviceDriver>> make_inverse3_driver(std::string_view keys);

}  // namespace touchable
