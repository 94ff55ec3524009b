#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

struct DecodedPicture {
    FramePtr frame;
    AVCodecID codec = AV_CODEC_ID_NONE;
    int bits = 8;             ///< of a sample as stored; grey of 2 and 4 is spread over 8 in the frame
    bool interlaced = false;  ///< a PNG that is; then it is not found out where its data end too early
};

/// PNG or JPEG by its first bytes. Refused where it is cut, damaged, or has data for a part of it only.
Result<DecodedPicture> decode_picture(std::string_view bytes, const std::string& where);

}  // namespace touchable
