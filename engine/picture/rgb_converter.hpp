#pragma once

#include <memory>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/picture/packed_rgb.hpp"

namespace touchable {

/// 8-bit RGB of any colour format: bytes moved where the format is RGB, otherwise rounded. Keeps what it has
/// set up for frames of one kind.
class RgbConverter {
public:
    /// A frame of format RGB24.
    Result<FramePtr> converted(const AVFrame& frame);

private:
    bool is_set_up_for(const AVFrame& frame) const;
    bool set_up_for(const AVFrame& frame);
    bool set_up_scaler(const AVFrame& frame);
    FramePtr new_rgb() const;

    ScalerPtr scaler_;                    // null: bytes are only moved, or there are
    std::optional<YuvFactors> factors_;   // what swscale's arithmetic is done with, without it
    std::shared_ptr<AVBufferPool> pool_;  // of RGB pictures: fresh memory costs a page fault every 4096 bytes
    int width_ = 0, height_ = 0, format_ = AV_PIX_FMT_NONE;
    AVColorRange range_ = AVCOL_RANGE_UNSPECIFIED;
    AVColorSpace space_ = AVCOL_SPC_UNSPECIFIED;
};
/// The same of one frame.
Result<Image> rgb_converted(const AVFrame& frame);

}  // namespace touchable
