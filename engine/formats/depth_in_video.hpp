#pragma once

#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/formats/video_picture.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Where depth is in the pictures of a video, and what of a pixel it is.
struct DepthInVideo {
    VideoLayout layout = VideoLayout::alone;
    VideoValues values = VideoValues::grey;
    int bar = 0;  ///< columns between both halves
};

/// By one picture. Grey comes first, then hue (of what is lit nine tenths are of full colour), then what is
/// nearly grey, whose depth is the mean of its colours; each everywhere, or in one half where the other half
/// is not so. Where `said` tells what values are, they are that: in such a half, otherwise everywhere.
/// Nothing of a picture in which no depth is.
std::optional<DepthInVideo> find_depth_in(VideoPicture& picture, std::optional<VideoValues> said);
/// The same of depth whose layout is known.
std::optional<VideoValues> values_in(VideoPicture& picture, const PicturePart& part);

/// "depth is the left half, which is grey, colour the right one".
std::string words_of(const DepthInVideo& found);

}  // namespace touchable
