#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// How samples lie in FFmpeg's pictures.
struct Packing {
    AVPixelFormat format;
    /// 16 bits as one picture of 8 bits and twice the height: the high bytes above the low bytes.
    bool halves = false;
};

/// Puts a plane into a picture of the packing's format and of its size.
Result<void> pack(const PlaneView& plane, const Packing& packing, ScalerPtr& scaler, AVFrame& picture);

/// Planes out of pictures, in the form of `form`: of lossless packings exactly what went in.
class Unpacker {
public:
    Unpacker(const PlaneView& form, const Packing& packing) : form_(form), packing_(packing) {}
    /// Valid until the next call, and as long as the picture.
    Result<PlaneView> plane(const AVFrame& picture);

private:
    PlaneView own();

    PlaneView form_;
    Packing packing_;
    ScalerPtr scaler_;
    std::vector<std::uint8_t> samples_;
};

}  // namespace touchable
