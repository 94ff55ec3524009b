#pragma once

// A camera of V4L2 as a live clip: open_v4l2_camera opens the node of depth that a V4l2Choice names, and the
// one of colour beside it.
//
// A reader is used by one thread.

#include <filesystem>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/clip/clip.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/decoding.hpp"

namespace touchable {

/// Makes RGB of a camera's pictures of colour. Keeps what it has set up.
class ColourConverter {
public:
    /// Of 8 bits, in the picture's own size. An error, without the camera's name, where a coded picture is
    /// damaged.
    Result<Plane> rgb(const TakenPicture& picture, const StreamFormat& format);

private:
    RgbConverter converter_;
};

/// A camera of depth that is plugged in, and what is wanted of it.
struct V4l2Choice {
    std::string node;                       ///< "/dev/video0"
    int width = 0, height = 0;              ///< 0: the largest at 30 frames/s, up to 1280x720
    std::optional<double> rate{};           ///< frames a second; nothing: 30, or the nearest to that
    std::string colour{};                   ///< the node of colour beside it; empty: none
    std::shared_ptr<VideoSystem> system{};  ///< nothing: this machine's
};

/// A camera as a live source: Z16, or grey of 16 bits taken for depth. What its frames mean is
/// said by `scene_file`; or by `known` and by guesses from its first frames, as of a picture (open_clip.hpp),
/// which the scene's remarks tell.
///
/// Before `begin` frames come one by one as the camera takes them, at most a few seconds late. From then on
/// `next` gives the newest one, at the time at which it was taken. Numbers are the driver's count, so that
/// what was lost, damaged or passed over is a gap. After a run that has ended it may begin another one. A
/// camera that is unplugged has no more frames, and `remarks` say so.
Result<std::unique_ptr<ClipReader>> open_v4l2_camera(
    const V4l2Choice& choice, const std::optional<SourceDescription>& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

}  // namespace touchable
