#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/decoding.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A part of a picture, in pixels.
struct PicturePart {
    int x = 0, y = 0, width = 0, height = 0;
};
/// Whether the two halves are side by side, rather than one above the other.
constexpr bool is_side_by_side(VideoLayout layout) {
    return layout == VideoLayout::left || layout == VideoLayout::right;
}
/// Depth's part of a picture of this size, and what is left for colour. Nothing where it has no two halves.
/// `bar`: columns, or rows, between the two that are of neither.
std::optional<PicturePart> depth_part(VideoLayout layout, int width, int height, int bar = 0);
PicturePart colour_part(VideoLayout layout, int width, int height, int bar = 0);
/// Whether so many columns of that many can be such a bar.
constexpr bool may_be_bar(int bar, int side) {
    return bar >= 16 && 4 * bar <= side;
}
/// A part of a plane, which stays where it is.
PlaneView part_of(PlaneView plane, const PicturePart& part);
/// Its samples, rows without padding.
Image packed_image(const PlaneView& view);

/// The codes that stand for black and white.
struct CodeRange {
    int least = 0, most = 255;
    bool operator==(const CodeRange&) const = default;
};

/// A picture of a video, and what can be made of it.
class VideoPicture {
public:
    /// Messages begin with `where`. The converter serves many pictures of one video.
    VideoPicture(FramePtr frame, RgbConverter& converter, std::string where);

    int width() const { return frame_->width; }
    int height() const { return frame_->height; }
    /// Whether its pixels are red, green and blue, or luma beside colour differences.
    bool has_colours() const;
    /// Of a grey sample as stored; of other pixels 8.
    int bits() const;
    /// In 8 bits, all of it; made once.
    Result<Plane> rgb();
    /// Values of depth as they are stored: never through a conversion of ranges. Hue: RGB.
    Result<Plane> depth(VideoValues values, const PicturePart& part);
    /// The usual range, 16 to 235, for luma without a stated one, unless values lie outside.
    CodeRange code_range(VideoValues values) const;

private:
    Result<Plane> grey(const PicturePart& part);
    Result<Plane> mean(const PicturePart& part);

    std::shared_ptr<const AVFrame> frame_;
    RgbConverter& converter_;
    std::string where_;
    std::optional<Plane> rgb_;
};

/// Where depth is in the pictures of a video, and what of a pixel it is.
struct DepthInVideo {
    VideoLayout layout = VideoLayout::alone;
    VideoValues values = VideoValues::grey;
    int bar = 0;           ///< columns between both halves
    bool is_ramp = false;  ///< of `mean`: from black through colours to white
};
/// By one picture. Grey comes first, then hue (of what is lit nine tenths are of full colour: one channel
/// full and one at 0), then what is nearly grey or a ramp, whose depth is the mean of its colours. Each
/// counts everywhere, or in one half where the other half is not so. Where `said` tells what values are, they
/// are that: in such a half, otherwise everywhere. Nothing of a picture in which no depth is.
std::optional<DepthInVideo> find_depth_in(VideoPicture& picture, std::optional<VideoValues> said);
/// The same of depth whose layout is known.
std::optional<VideoValues> values_in(VideoPicture& picture, const PicturePart& part);

}  // namespace touchable
