#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/formats/bag_file.hpp"
#include "engine/formats/ros_messages.hpp"
#include "engine/formats/ros_picture.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/colour_camera.hpp"
#include "engine/scene/lens.hpp"

namespace touchable {

/// A topic of pictures.
struct BagPictures {
    std::string topic;
    bool is_compressed = false;  ///< sensor_msgs/CompressedImage
    RosPictureKind kind = RosPictureKind::none;
    std::string encoding;              ///< or format, of the first
    std::vector<BagMessage> messages;  ///< in the order in which they were recorded
};

/// Which of a recording's topics make a clip.
struct BagStreams {
    BagPictures depth;
    std::optional<BagPictures> colour;
    std::vector<std::string> others;  ///< that could be depth as well
};

/// By names and encodings: depth that is registered to colour before other depth, raw before compressed;
/// colour of the same camera; an infrared picture only where there is no colour. An error says which topics
/// there are.
Result<BagStreams> choose_bag_streams(BagFile& bag);

/// The pinhole camera of a topic of pictures by the sensor_msgs/CameraInfo beside it; nothing where it has
/// none. Of pictures that are rectified, the camera that they are rectified to.
struct BagCamera {
    Intrinsics intrinsics;
    std::string topic;  ///< of the CameraInfo
    std::string frame;  ///< of coordinates, as header.frame_id names it
    /// None of a picture that is rectified, and of a kind that is not known.
    LensDistortion lens;
    std::string unknown_lens;  ///< what such a kind is called
};
Result<std::optional<BagCamera>> bag_camera(BagFile& bag, const std::string& pictures);

/// How the camera of a RealSense's pictures stands: from the recording's reference, metres; nothing where it
/// does not say.
Result<std::optional<CameraPose>> bag_pose(BagFile& bag, const std::string& pictures);

/// Whether a topic's name says that its depth has colour's pixels.
bool is_registered_topic(const std::string& pictures);

/// Metres that a stored 1 stands for, where a RealSense says it.
Result<std::optional<double>> bag_depth_unit(BagFile& bag, const std::string& pictures);

}  // namespace touchable
