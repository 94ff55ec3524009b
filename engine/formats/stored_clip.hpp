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

/// A picture of a track as it is stored.
struct TrackPicture {
    StoredImage image;      ///< without samples where they are lent
    Plane lent{};           ///< samples in a picture that a decoder made
    bool lossless = false;  ///< TrackInfo::lossless
};
/// The samples of a decoder's picture, or of a part of it, in a track that is stored like this.
TrackPicture lent_picture(const TrackInfo& track, Plane plane);

/// A whole picture, PNG or JPEG for one, as that of a track. Grey that is stored as RGB is grey where it must
/// be. What mixes materials is refused unless that is allowed, and what is touched must not be interlaced.
/// `where` begins messages.
struct StillRules {
    DepthCodingKind depth = DepthCodingKind::linear;
    bool haptic_may_be_lossy = false;
    bool depth_is_packed = false;  ///< StoredDepth::packed
};
Result<TrackPicture> track_picture(StoredImage stored, PlaneRole role, const StillRules& rules,
                                   const std::string& where);

/// What reads the pictures of a stored clip: files in a folder, messages of a recording, packets of a video.
class FrameSource {
public:
    virtual ~FrameSource() = default;
    /// A picture as messages name it: its file, track and frame.
    virtual std::string where(PlaneRole role, std::int64_t frame) const = 0;
    /// The picture of one of the clip's tracks in one of its frames, in any order; the next frame's is the
    /// quickest. An error names file, track and frame. The newest picture of a track is not asked for again.
    virtual Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) = 0;
    /// Frames in a row with the same number show the same picture of that track.
    virtual std::int64_t picture_number(PlaneRole, std::int64_t frame) const { return frame; }
    /// ClipReader::access_point.
    virtual std::int64_t access_point(std::int64_t frame) const { return frame; }
    /// Whether `picture` may be called for several tracks of a frame at once, each on a thread.
    virtual bool reads_side_by_side() const { return false; }
    /// A picture of depth that was asked for to find depth's range, and will be once more as a frame.
    virtual void keep(std::int64_t, StoredImage) {}
};

/// A clip that lies in files, as the reader of their format found it.
struct StoredClip {
    std::string name;  ///< its file or folder, for messages
    SceneDescription described;
    std::shared_ptr<FrameSource> pictures{};
    std::int64_t count = 0;          ///< of its frames, at least 1
    std::vector<PlaneRole> roles{};  ///< of its tracks, depth the first
    SceneDescription::FoundInClip found{};
    std::vector<Camera> cameras{};  ///< of the frames; none: the scene's
    std::vector<std::string> notes{};
    std::vector<std::filesystem::path> inputs{};
    /// Of depth without a scale; of other depth where it is `on` alone.
    DepthAlignment alignment = DepthAlignment::automatic;
    bool has_no_scale = false;  ///< though its codes are settled already
};

/// Its reader, at its beginning. How the pictures of frame 0 are stored stands for all, and a later one that
/// is not like them is refused. Depth that is no codes becomes codes (DepthValues), and the scene settles all
/// that the description leaves open but for its filters.
Result<std::unique_ptr<ClipReader>> open_stored_clip(StoredClip clip, Colour colour = Colour::wanted);

}  // namespace touchable
