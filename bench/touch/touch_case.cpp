// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/touch_case.hpp"

namespace touchable {

Relief relief_of(const std::string& scene) {
    if (scene == "rough") return Relief::rough;
    return scene == "moving" ? Relief::moving : Relief::bumps;
}

std::string name_of(const TouchCase& c) {
    std::string name = c.scene + "-" + std::to_string(c.width) + "x" + std::to_string(c.height) + "-" +
                       (c.bits == TouchCase::exact ? "exact" : std::to_string(c.bits)) + "-" +
                       std::to_string(c.fingers) + "f-" + std::string(name_of(c.metric));
    if (c.preset == CameraPreset::a) name += "-A";
    if (c.preset == CameraPreset::a_prime) name += "-Aprime";
    if (c.median > 0) name += "-m" + std::to_string(c.median);
    if (c.terraces) name += "-t";
    if (c.lazy) name += "-lazy";
    if (c.hold) name += "-hold";
    if (!c.run.empty()) name += "-" + c.run;
    return name;
}

}  // namespace touchable
