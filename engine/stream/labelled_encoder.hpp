#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/picture_label.hpp"
#include "engine/clip/plane_part.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/clip/track_encoder.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// Framesets as tracks of H.264, in which each picture says what it is (picture_message.hpp): so planes,
/// frame numbers, damage and the scene are known from the pictures alone, whatever carries them. Planes that
/// are felt keep every value; those of more than 8 bits are two tracks.
class LabelledEncoder {
public:
    /// `touch`: how the planes that are felt are coded, h264_quick or h264_thrifty; `colour`: h264_visual or
    /// h264_reduced. An error of kind usage where H.264 has no pictures of that size.
    static Result<LabelledEncoder> open(const RawFrame& first, const SceneDescription& described,
                                        TrackCoding touch, TrackCoding colour = TrackCoding::h264_visual);

    /// Tracks in their order: colour first, which ordinary players show, low parts last.
    std::size_t tracks() const { return tracks_.size(); }
    PlaneRole role(std::size_t track) const { return tracks_[track].role; }
    /// "depth", "depth_low": for tools that show names.
    std::string name(std::size_t track) const;
    /// Says in a container how a track is encoded.
    Result<void> describe(std::size_t track, AVCodecParameters& stored) const;

    /// A packet for each track, without times; planes as the first frame had them, or an error of kind input.
    /// Where `is_key`, decoding can begin with each.
    Result<std::vector<PacketPtr>> encode(const RawFrame& frame, const PictureLabel& label, bool is_key);

private:
    struct Track {
        PlaneRole role;
        PlanePart part;
        int bits;  // of the plane's samples
        std::unique_ptr<TrackEncoder> encoder{};
        PlaneView form{};                   // of the plane; its samples are gone
        std::vector<std::uint8_t> bytes{};  // of the newest picture of a part
    };
    LabelledEncoder() = default;
    Result<void> add_track(Track track, const RawFrame& first, const Scene& scene, TrackCoding coding);

    std::vector<Track> tracks_;
    std::string scene_sei_;
};

}  // namespace touchable
