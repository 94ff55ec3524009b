#pragma once

#include <string>

#include "engine/content/height_fields.hpp"
#include "engine/content/scenes.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// What is touched, and how; what its name tells.
struct TouchCase {
    static constexpr int exact = 0;  ///< for `bits`: depths are not quantised

    std::string scene;
    int width = 720, height = 480;
    int bits = 16;
    int fingers = 1;
    TouchMetric metric = TouchMetric::world;
    CameraPreset preset = CameraPreset::b;
    int median = 0;
    bool terraces = false;  ///< removed
    bool lazy = false;      ///< pixels are filtered when they are touched, not before
    bool hold = false;      ///< between frames the earlier one, not a blend
    std::string run;        ///< where a set-up is used for more than one run: which; may be empty
};

/// Of the height fields: "bumps", "rough", "moving".
Relief relief_of(const std::string& scene);

/// <scene>-<W>x<H>-<bits>-<fingers>f-<mode>, then -A or -Aprime, -m<side>, -t, -lazy, -hold, -<run> where
/// they apply.
std::string name_of(const TouchCase& c);

}  // namespace touchable
