// The position and direction of a camera, in a file or on the command line.
#include <cmath>
#include <glm/matrix.hpp>
#include <string>

#include "player/commands/run_options.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_world_from_camera(std::string_view bytes) {
    const auto frame = read_world_from_camera(file_of(bytes, "world.txt").string());
    const auto typed = read_world_from_camera(std::string(bytes.substr(0, 1024)));
    (void)is_taken(typed, Quotes::typed);
    if (!is_taken(frame)) return false;
    const glm::dmat4 back = glm::inverse(*frame) * *frame;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            require(std::isfinite((*frame)[column][row]), "a number is not finite");
            require(std::abs(back[column][row] - (column == row ? 1.0 : 0.0)) < 1e-6, "has no way back");
        }
    return true;
}

const Registered world_from_camera_target{{.name = "world_from_camera",
                                           .parse = parse_world_from_camera,
                                           .cuts_are_refused = true,
                                           .needless_bytes = 2,
                                           .most_bytes = 512,
                                           .most_live_mebibytes = 4}};

}  // namespace
}  // namespace touchable::fuzz
