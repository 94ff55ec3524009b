// SPDX-License-Identifier: Apache-2.0
#include "bench/paper/scripted_path.hpp"

#include "engine/base/same_bits.hpp"

namespace touchable {

glm::dvec2 ScriptedPath::at(double seconds) const {
    const double x = reach_x * sine(2 * pi * hz_x * seconds), y = reach_y * cosine(2 * pi * hz_y * seconds);
    const double c = cosine(2 * pi * turn_hz * seconds), s = sine(2 * pi * turn_hz * seconds);
    return {c * x - s * y, s * x + c * y};
}

}  // namespace touchable
