// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A file format for the same depth.
struct DepthForm {
    const char* name;
    /// Writes the depth, metres or whole millimetres, into an empty folder and returns the path to open.
    Result<std::filesystem::path> (*write)(const std::filesystem::path& folder, const Scene& scene,
                                           const std::vector<RawFrame>& frames);
};

/// 16-bit PNG, `.npy` of float32, OpenEXR of half floats, a ROS 1 recording with 32FC1.
const std::vector<DepthForm>& depth_forms();

/// Frames opened without a scene file, with only the camera stated; unit millimetres.
struct OpenedForm {
    Scene scene;
    std::vector<RawFrame> frames;
};
/// Writes the frames in this form and opens them. The scene must have metric depth.
Result<OpenedForm> opened(const DepthForm& form, const Scene& scene, const std::vector<RawFrame>& frames);

}  // namespace touchable
