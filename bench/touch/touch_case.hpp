// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/content/families.hpp"
#include "engine/content/scenes.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// The surface and settings of a case, as described by its name.
struct TouchCase {
    static constexpr int exact = 0;  ///< for `bits`: depths are not quantised

    std::string scene;
    int width = 720, height = 480;
    int bits = 16;
    int fingers = 1;
    TouchMetric metric = TouchMetric::world;
    CameraPreset preset = CameraPreset::b;
    int median = 0;
    bool terraces = false;  ///< terrace removal
    bool lazy = false;      ///< filter pixels when they are touched, not before
    bool hold = false;      ///< hold the earlier frame, no blend
    std::string run;        ///< name of the run if a set-up has several; may be empty
};

/// For the height fields "bumps", "rough" and "moving".
Relief relief_of(const std::string& scene);

/// <scene>-<W>x<H>-<bits>-<fingers>f-<mode>, then -A or -Aprime, -m<side>, -t, -lazy, -hold, -<run> if they
/// apply.
std::string name_of(const TouchCase& c);

}  // namespace touchable
