// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A track's picture as it is stored.
struct TrackPicture {
    StoredImage image;      ///< without samples if they are lent
    Plane lent{};           ///< samples in a decoder's picture
    bool lossless = false;  ///< TrackInfo::lossless
};
/// Makes the picture of a track stored as `track` from samples of a decoder's picture or a part of it.
TrackPicture lent_picture(const TrackInfo& track, Plane plane);

/// Makes a track's picture of a whole picture, such as a PNG or JPEG. Depth and height stored as grey RGB
/// become grey. An error if haptic is JPEG, which mixes materials, and the rules do not allow it, or if a
/// touched picture is interlaced. Messages begin with `where`.
struct StillRules {
    DepthCodingKind depth = DepthCodingKind::linear;
    bool haptic_may_be_lossy = false;
    Packing packed = Packing::none;  ///< of depth
};
Result<TrackPicture> track_picture(StoredImage stored, PlaneRole role, const StillRules& rules,
                                   const std::string& where);

/// Reads the pictures of a stored clip: files in a folder, messages of a recording, packets of a video.
class FrameSource {
public:
    virtual ~FrameSource() = default;
    /// A picture's name in messages: its file, track and frame.
    virtual std::string where(PlaneRole role, std::int64_t frame) const = 0;
    /// Reads a track's picture in a frame, in any order; the next frame's is the quickest. An error names
    /// file, track and frame. Callers do not read a track's newest picture again.
    virtual Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) = 0;
    /// Consecutive frames with the same number show the same picture of that track.
    virtual std::int64_t picture_number(PlaneRole, std::int64_t frame) const { return frame; }
    /// ClipReader::access_point.
    virtual std::int64_t access_point(std::int64_t frame) const { return frame; }
    /// Whether `picture` may be called for several tracks of a frame at once, each on its own thread.
    virtual bool reads_side_by_side() const { return false; }
    /// Keeps a depth picture that was read to find depth's range and will be read again as a frame.
    virtual void keep(std::int64_t, StoredImage) {}
};

/// A clip in files, as the format's reader found it.
struct StoredClip {
    std::string name;  ///< its file or folder, for messages
    SceneDescription described;
    std::shared_ptr<FrameSource> pictures{};
    std::int64_t count = 0;          ///< frames, at least 1
    std::vector<PlaneRole> roles{};  ///< of its tracks, depth first
    SceneDescription::FoundInClip found{};
    std::vector<Camera> cameras{};  ///< one a frame; empty: all have the scene's
    std::vector<ClipNote> notes{};
    std::vector<std::filesystem::path> inputs{};
    /// Applies to depth without a scale; to other depth only if `on`.
    DepthAlignment alignment = DepthAlignment::automatic;
    bool has_no_scale = false;  ///< depth has no scale, though its codes are settled already
};

/// Opens the clip at its beginning. All pictures must be stored as those of frame 0; reading another is an
/// error. Depth that is not codes becomes codes (DepthValues), and all that the description leaves open,
/// except for the filters, is settled.
Result<std::unique_ptr<ClipReader>> open_stored_clip(StoredClip clip, Colour colour = Colour::wanted);

}  // namespace touchable
