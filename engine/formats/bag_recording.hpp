#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/formats/bag_file.hpp"
#include "engine/formats/bag_topics.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

/// The depth of a recording of ROS 1, and the colour that goes with it, picture by picture.
class BagRecording {
public:
    static Result<BagRecording> open(const SourceFile& file);

    BagFile& bag() { return *bag_; }
    const BagStreams& streams() const { return streams_; }
    std::int64_t count() const { return static_cast<std::int64_t>(streams_.depth.messages.size()); }
    bool has_colour() const { return streams_.colour.has_value(); }
    /// When each picture of depth was taken, seconds, in order: as its header says, or where headers of depth
    /// and colour do not tell, when it was recorded.
    const std::vector<double>& times() const { return times_; }

    Result<StoredImage> depth(std::int64_t frame);
    /// Of the colour that is nearest in time.
    Result<StoredImage> colour(std::int64_t frame);
    /// Its place among the pictures of colour.
    std::int64_t colour_beside(std::int64_t frame) const {
        return static_cast<std::int64_t>(colours_[static_cast<std::size_t>(frame)]);
    }
    /// "my.bag: /camera/depth/image_raw, frame 7".
    std::string where(const BagPictures& pictures, std::int64_t frame) const;

private:
    Result<void> put_in_order();
    Result<StoredImage> picture(const BagPictures& pictures, const BagMessage& message, std::int64_t frame);

    std::unique_ptr<BagFile> bag_;
    BagStreams streams_;
    std::vector<double> times_;
    std::vector<std::size_t> colours_;  // of each depth, its colour's place
};

}  // namespace touchable
