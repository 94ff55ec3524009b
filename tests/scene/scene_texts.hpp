// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "engine/scene/scene.hpp"

namespace touchable::test {

/// A depth camera's recording: metric, with holes, read from a folder.
inline constexpr const char* recording = R"({
  "touchable_scene": 1, "name": "castle", "width": 640, "height": 480, "rate": [30, 1], "metres_per_unit": 1,
  "camera": {"fx": 476.0, "fy": -476.5, "cx": 312.2, "cy": 240.6},
  "depth": {"coding": "metric", "scale": 0.000125, "near": 0.2, "far": 1.5, "invalid": [0, 65535]},
  "default_properties": {"stiffness": 0.4, "static_friction": 0.5, "dynamic_friction": 0.25},
  "hole_stiffness": 0.1, "filter": {"median": 5, "fill_holes": 2}, "interpolation": "hold", "device_metres_per_unit": 0.4,
  "folder": {"depth": "depth_%04d.png", "colour": "image_%04d.png", "first": 3, "count": 20}
})";

/// A generated clip in the paper's terms.
inline constexpr const char* globe = R"({
  "touchable_scene": 1, "name": "globe", "width": 720, "height": 480, "rate": [30000, 1001],
  "camera": {"focal_length": 4.7, "pixel_width": 0.0112},
  "depth": {"coding": "linear", "near": 40, "far": 180, "bits": 16},
  "height_map": {"max": 2.5, "units": "levels", "bits": 10},
  "haptic": {"stiffness": [0.1, 10], "static_friction": [0.2, 0.9], "dynamic_friction": [0.2, 0.8]}
})";

inline SceneDescription described(const std::string& json) {
    auto read = parse_scene(json, "test.json");
    EXPECT_TRUE(read) << read.error().message;
    return read ? *read : SceneDescription{};
}

/// The stated scene, without what is open.
inline Scene parsed(const std::string& json) {
    return described(json).scene;
}

}  // namespace touchable::test
