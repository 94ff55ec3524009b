#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/decoded_picture.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/rgb_converter.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A part of a picture, in pixels.
struct PicturePart {
    int x = 0, y = 0, width = 0, height = 0;
};
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
    /// Of luma whose range nobody states, the usual one, 16 to 235, unless values lie outside.
    CodeRange code_range(VideoValues values) const;

private:
    Result<Plane> grey(const PicturePart& part);
    Result<Plane> mean(const PicturePart& part);

    std::shared_ptr<const AVFrame> frame_;
    RgbConverter& converter_;
    std::string where_;
    std::optional<Plane> rgb_;
};

}  // namespace touchable
