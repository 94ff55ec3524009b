#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// Layout of samples in FFmpeg's pictures.
struct PicturePacking {
    AVPixelFormat format;
    /// 16 bits as one 8-bit picture of twice the height: high bytes above low bytes.
    bool halves = false;
};

/// Packs a plane into a picture of the packing's format and size.
Result<void> pack(const PlaneView& plane, const PicturePacking& packing, ScalerPtr& scaler, AVFrame& picture);

/// Unpacks pictures to planes in the form of `form`; exact for lossless packings.
class Unpacker {
public:
    Unpacker(const PlaneView& form, const PicturePacking& packing) : form_(form), packing_(packing) {}
    /// Valid until the next call and while the picture exists.
    Result<PlaneView> plane(const AVFrame& picture);

private:
    PlaneView own();

    PlaneView form_;
    PicturePacking packing_;
    ScalerPtr scaler_;
    std::vector<std::uint8_t> samples_;
};

}  // namespace touchable
