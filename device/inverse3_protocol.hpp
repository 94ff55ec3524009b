#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

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
/// Asks for a message with configurations.
std::string encode_inverse3_full_state_request();

/// The settings that a person should know of, in words; empty: none was said.
std::string in_words(const Inverse3Settings& settings);
/// Of them what makes forces differ from those that are asked for; empty: nothing.
std::string altered_forces(const Inverse3Settings& settings);

/// A text as one WebSocket frame of a client (RFC 6455, 5.2), at most 65535 bytes of it.
std::vector<std::byte> web_socket_frame(std::string_view text, std::uint32_t mask);

}  // namespace touchable
