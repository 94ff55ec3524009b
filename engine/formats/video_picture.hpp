// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/decoding.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

class VideoFile;

/// A part of a picture, in pixels.
struct PicturePart {
    int x = 0, y = 0, width = 0, height = 0;
};
/// Whether the two halves are side by side, rather than one above the other.
constexpr bool is_side_by_side(VideoLayout layout) {
    return layout == VideoLayout::left || layout == VideoLayout::right;
}
/// Depth's and colour's parts of a picture of this size. Nothing if it has no two equal halves. `bar`:
/// columns, or rows, between the two that belong to neither.
std::optional<PicturePart> depth_part(VideoLayout layout, int width, int height, int bar = 0);
PicturePart colour_part(VideoLayout layout, int width, int height, int bar = 0);
/// Whether `bar` of `side` columns can be such a bar.
constexpr bool may_be_bar(int bar, int side) {
    return bar >= 16 && 4 * bar <= side;
}
/// A view of a part of a plane; copies no samples.
PlaneView part_of(PlaneView plane, const PicturePart& part);

/// The codes that stand for black and white.
struct CodeRange {
    int least = 0, most = 255;
    bool operator==(const CodeRange&) const = default;
};

/// A video's picture, and its conversions.
class VideoPicture {
public:
    /// Messages begin with `where`. The converter serves many pictures of one video.
    VideoPicture(FramePtr frame, RgbConverter& converter, std::string where);

    int width() const { return frame_->width; }
    int height() const { return frame_->height; }
    /// Whether its pixels are red, green and blue, or luma beside colour differences.
    bool has_colours() const;
    /// Bits of a grey or luma sample as stored; 8 for RGB.
    int bits() const;
    /// The whole picture in 8 bits; converted once.
    Result<Plane> rgb();
    /// Depth's values as stored, never through a conversion of ranges. For hue: RGB.
    Result<Plane> depth(VideoValues values, const PicturePart& part);
    /// The codes of black and white; for luma without a stated range 16 to 235, unless values lie outside.
    CodeRange code_range(VideoValues values) const;

private:
    Result<Plane> grey(const PicturePart& part);
    Result<Plane> mean(const PicturePart& part);

    std::shared_ptr<const AVFrame> frame_;
    RgbConverter& converter_;
    std::string where_;
    std::optional<Plane> rgb_;
};

/// The picture of this number.
Result<VideoPicture> picture_at(VideoFile& video, std::int64_t number, RgbConverter& converter);

/// Depth's part of a video's pictures, and what of a pixel depth is.
struct DepthInVideo {
    VideoLayout layout = VideoLayout::alone;
    VideoValues values = VideoValues::grey;
    int bar = 0;           ///< columns between both halves
    bool is_ramp = false;  ///< for `mean`: from black through colours to white
};
/// Finds depth in one picture: grey first, then hue (nine tenths of the lit pixels are of full colour: one
/// channel full and one at 0), then nearly grey or a ramp, whose depth is the mean of its colours. Each must
/// hold everywhere, or in one half and not in the other. If `said` states the values, depth is the half that
/// has them, otherwise the whole picture. Nothing if there is no depth.
std::optional<DepthInVideo> find_depth_in(VideoPicture& picture, std::optional<VideoValues> said);
/// The values of depth whose part is known: hue if most of what is lit there is bright and of full colour.
/// Nothing if the part is black, as before the first person comes.
std::optional<VideoValues> values_in(VideoPicture& picture, const PicturePart& part);
/// "depth is the left half, which is grey, colour the right one".
std::string words_of(const DepthInVideo& found);

/// Depth in a half of a picture of RGB of 8 bits, as nearly grey or a ramp, and colour in the other half.
std::optional<DepthInVideo> depth_beside_colour(const Image& picture);
/// The same, or depth in the whole picture if that is grey but for the noise of codecs.
std::optional<DepthInVideo> depth_in_colours(const Image& picture);
/// That half as grey (role `depth`), or the other one.
StoredImage half_of(const StoredImage& picture, const DepthInVideo& found, PlaneRole role);

}  // namespace touchable
