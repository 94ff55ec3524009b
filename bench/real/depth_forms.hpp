#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A form in which people keep the same depth.
struct DepthForm {
    const char* name;
    /// Writes it into a folder that is empty, metres or whole millimetres, and says what is to be opened.
    Result<std::filesystem::path> (*write)(const std::filesystem::path& folder, const Scene& scene,
                                           const std::vector<RawFrame>& frames);
};

/// PNG of 16 bits, `.npy` of float32, OpenEXR of halves, a recording of ROS 1 with 32FC1.
const std::vector<DepthForm>& depth_forms();

/// Frames as touchable opens them without a scene file but for the camera, told in millimetres.
struct OpenedForm {
    Scene scene;
    std::vector<RawFrame> frames;
};
/// Of frames whose scene has metric depth.
Result<OpenedForm> opened(const DepthForm& form, const Scene& scene, const std::vector<RawFrame>& frames);

}  // namespace touchable
