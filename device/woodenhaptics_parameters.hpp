#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>

#include "device/haptic_device.hpp"

namespace touchable {

/// Where a parameter file is to begin with, in a checkout and where the program is installed.
inline constexpr std::string_view wooden_example =
    "examples/woodenhaptics.json (installed: share/touchable/examples/woodenhaptics.json)";

/// One of the three motors, and the joint that it turns by a cable. Signs count.
struct WoodenJoint {
    double counts_per_turn = 0;  ///< of the motor, quadrupled; negative: they fall as the joint's angle grows
    double cable_ratio = 0;      ///< the joint's turn for one of the motor's: capstan over drum, 0 to 1
    double torque_constant = 0;  ///< N m/A; negative: a positive current turns the joint back
    double most_amperes = 0;     ///< that its motor and amplifier bear
    std::int16_t home_counts = 0;  ///< of its counter in the home pose
};

/// What one build of a WoodenHaptics or Polhem is, as its parameter file says (docs/devices.md).
struct WoodenParameters {
    enum class Homing {
        start,  ///< it is in the home pose when it is opened
        button  ///< it is there when the button of its board is pressed
    };
    std::string name;
    bool drive = false;  ///< false: its motors get no current whatever the force
    std::array<WoodenJoint, 3> joints{};
    std::array<double, 3> links{};  ///< m: from the base up to the second joint, then both moving ones
    glm::dvec3 origin{0.0};  ///< m, the workspace's centre: x to the person, y right, z up, from the base
    double reach = 0;        ///< m to each side of it
    DeviceLimits limits{};
    Homing homing = Homing::start;
};

/// Of the text of a parameter file. Refuses (ErrorKind::input) what is missing, unknown or out of range;
/// `where` is the file's name, for the message.
Result<WoodenParameters> parse_wooden_parameters(std::string_view json, std::string_view where);
Result<WoodenParameters> read_wooden_parameters(const std::filesystem::path& file);

}  // namespace touchable
