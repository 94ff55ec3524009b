#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/scene/colour_camera.hpp"

namespace touchable {

/// The cameras of an Azure Kinect, or of an Orbbec Femto that records as one.
struct K4aCameras {
    Camera depth;  ///< of the picture as it is stored, which its lens bends
    LensDistortion depth_lens;
    std::optional<ColourCamera> colour;  ///< scene units: metres
};

/// Pixels of a picture.
struct PictureSize {
    int width = 0, height = 0;
};

/// What a recording's calibration.json says of pictures of these sizes, which the camera's modes have.
Result<K4aCameras> parse_azure_kinect_calibration(std::string_view text, PictureSize depth,
                                                  const std::optional<PictureSize>& colour,
                                                  const std::string& where);

}  // namespace touchable
