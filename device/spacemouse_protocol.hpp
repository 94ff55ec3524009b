#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "engine/base/result.hpp"

namespace touchable {

/// Whether ids are those of a 3Dconnexion puck, or of the receiver of one: 046d:c603 to c63f (sold under
/// Logitech's id), and 256f but for its ordinary mice (CadMouse).
bool is_spacemouse(std::uint16_t vendor, std::uint16_t product);

/// What one report of a SpaceMouse tells; its rotation moves no finger and is left out.
struct SpaceMouseReport {
    std::optional<glm::ivec3> translation{};  ///< as the device counts: x right, y towards the person, z down
    std::optional<std::uint32_t> buttons{};   ///< one bit for each that is pressed
};

/// Of a report with its number in front, integers of 16 bits, low byte first: 1 is the translation, on some
/// models with the rotation behind it; 2 the rotation; 3 the buttons. Others (a battery's charge) tell
/// nothing. Refuses one that is too short for what it is.
Result<SpaceMouseReport> decode_spacemouse_report(std::span<const std::byte> bytes);

}  // namespace touchable
