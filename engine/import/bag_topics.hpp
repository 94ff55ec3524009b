#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/import/bag_file.hpp"
#include "engine/import/ros_messages.hpp"
#include "engine/import/ros_picture.hpp"
#include "engine/import/source_description.hpp"
#include "engine/result.hpp"

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
    std::string topic;               ///< of the CameraInfo
    std::string frame;               ///< of coordinates, as header.frame_id names it
    std::vector<double> distortion;  ///< none of a picture that is rectified, and where all are 0
    std::string distortion_model;
};
Result<std::optional<BagCamera>> bag_camera(BagFile& bag, const std::string& pictures);

/// Metres that a stored 1 stands for, where a RealSense says it.
Result<std::optional<double>> bag_depth_unit(BagFile& bag, const std::string& pictures);

}  // namespace touchable
