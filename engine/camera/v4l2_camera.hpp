// SPDX-License-Identifier: Apache-2.0
#pragma once

// A camera of V4L2 as a live clip: open_v4l2_camera opens the node of depth that a V4l2Choice names, and the
// one of colour beside it. meaning_of_depth finds what depth means, of cameras of any kind.
//
// A reader is used by one thread.

#include <filesystem>
#include <memory>
#include <span>

#include "engine/base/result.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/decoding.hpp"

namespace touchable {

/// A camera's colour picture as RGB of 8 bits, in its own size. An error, without the camera's name, if a
/// coded picture is damaged.
Result<Plane> rgb_of(const TakenPicture& picture, const StreamFormat& format, RgbConverter& converter);

/// A depth camera, and the mode that is wanted.
struct V4l2Choice {
    std::string node;                       ///< "/dev/video0"
    int width = 0, height = 0;              ///< 0: the largest at 30 frames/s, up to 1280x720
    std::optional<double> rate{};           ///< frames a second; nothing: 30, or the nearest to that
    std::string colour{};                   ///< the node of colour beside it; empty: none
    std::shared_ptr<VideoSystem> system{};  ///< null: this machine's
};

/// A camera as a live source: Z16, or grey of 16 bits taken for depth. The meaning of its frames comes from
/// `scene_file`; or from `known` and guesses from its first frames, as for a picture (open_clip.hpp), which
/// the scene's remarks list.
///
/// Before `begin` frames come one by one as the camera takes them, at most a few seconds late. From then on
/// `next` returns the newest one, at the time at which it was taken. Numbers are the driver's count, so that
/// lost, damaged or skipped frames leave gaps. After a run has ended, another may begin. A camera that is
/// unplugged has no more frames, and `remarks` say so.
Result<std::unique_ptr<ClipReader>> open_v4l2_camera(
    const V4l2Choice& choice, const SourceDescription& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

/// Finds what a camera's depth means, all but the rate; remarks of the scene tell what was assumed. By a
/// scene file, whose size must be that of the pictures; or like guess_camera by `known` and the first
/// frames' depth, of 16 bits in host order, with Z16 in millimetres unless `known` states another unit. An
/// unstated far plane is set well behind what they show. Errors begin with the node, or the file.
Result<LiveReader::Meaning> meaning_of_depth(const NodeFacts& facts, std::uint32_t format,
                                             std::span<const RawFrame> first, const SourceDescription& known,
                                             const std::optional<std::filesystem::path>& scene_file);

}  // namespace touchable
