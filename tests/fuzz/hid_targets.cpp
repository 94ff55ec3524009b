// HID devices: their reports, what Linux says of them, and the file that tells how one is built.
#include <cmath>
#include <cstdlib>
#include <span>

#include "device/drivers/hid_transport.hpp"
#include "device/drivers/spacemouse_device.hpp"
#include "device/drivers/woodenhaptics_device.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_hid_report(std::string_view bytes) {
    const auto report = std::as_bytes(std::span(bytes));
    const auto puck = decode_spacemouse_report(report);
    const bool is_pucks = is_taken(puck);
    const auto board = decode_wooden_reading(report);
    const bool is_boards = is_taken(board);
    require(is_boards == (bytes.size() == 14), "a reading is not of 14 bytes");
    return is_pucks || is_boards;
}

bool parse_hid_uevent(std::string_view bytes) {
    const auto node = read_hid_uevent(bytes);
    if (node) require(node->name.find('\n') == std::string::npos, "a name is more than a line");
    return node.has_value();
}

bool parse_wooden_file(std::string_view bytes) {
    const auto build = parse_wooden_parameters(bytes, "wooden.json");
    if (!is_taken(build)) return false;
    for (const std::int16_t count : {-32768, -1, 0, 6000, 32767}) {
        const glm::dvec3 angles = wooden_angles(*build, {count, count, count});
        const glm::dvec3 place = wooden_place(*build, angles);
        require(std::isfinite(place.x + place.y + place.z), "a place is not finite");
        const auto currents = wooden_currents(*build, angles, {1e6, -1e6, build->limits.max_force});
        for (std::size_t joint = 0; joint < 3; ++joint)
            require(std::abs(currents[joint]) <= 1000 * build->joints[joint].most_amperes,
                    "a current is more than its motor bears");
    }
    return true;
}

const Registered hid_report_target{{.name = "hid_report", .parse = parse_hid_report, .most_bytes = 65}};
const Registered hid_uevent_target{{.name = "hid_uevent", .parse = parse_hid_uevent, .most_bytes = 512}};
const Registered wooden_file_target{{.name = "wooden_file",
                                     .parse = parse_wooden_file,
                                     .cuts_are_refused = true,
                                     .needless_bytes = 1,
                                     .changes = 300}};

}  // namespace
}  // namespace touchable::fuzz
