// SPDX-License-Identifier: Apache-2.0
#pragma once

// Framesets as H.264 tracks with labelled pictures: the message in a picture, the encoder and the decoder.
// MPEG-TS (stream_muxers.cpp) and HLS (hls_output.cpp) carry them; labelled_pictures.cpp reads them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/containers.hpp"
#include "engine/picture/decoding.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The label of an H.264 picture, in any container: an unregistered SEI message (ISO/IEC 14496-10, D.1.7)
/// with our own UUID. Its text is
///   touchable=1 role=depth part=high bits=16 frame=12 taken_ns=1700000000000000000 xxh64=0123456789abcdef
/// part: whole, high or low; bits: of the plane's samples, of which the high part has the upper eight; xxh64
/// (seed 0): hash of the text before " xxh64=" and of the part's samples as they decode, row by row, with
/// three channels red, green, blue. Colour, which no codec here keeps exactly, hashes the text only.
struct PictureMessage {
    PlaneRole role = PlaneRole::depth;
    PlanePart part = PlanePart::whole;
    int bits = 8;  ///< 8 to 16; 8 if the part is whole
    PictureLabel label;
    bool operator==(const PictureMessage&) const = default;
};

/// The message with the UUID. `samples`: the part's, one byte each.
std::string sei_of(const PictureMessage& message, const PlaneView& samples);
/// The scene's description as a message, sent with keyframes of depth, whole or high:
///   touchable_scene=1 xxh64=0123456789abcdef {...}
/// The hash is that of the JSON behind it.
std::string sei_of_scene(std::string_view json);

/// A parsed message of either kind.
struct ReadSei {
    std::optional<PictureMessage> picture;  ///< its hash is not checked yet
    std::string hashed;                     ///< of a picture: the text before its hash
    std::string hash;                       ///< 16 digits if it is right
    std::optional<std::string> scene;       ///< JSON, as it was sent
};
/// Nothing for other and for damaged messages: numbers out of range, unknown words, a scene with a wrong
/// hash.
std::optional<ReadSei> read_sei(std::span<const std::uint8_t> content);
/// Whether the message and its samples arrived as they were sent.
bool is_sound(const ReadSei& sei, const PlaneView& samples);

/// Framesets as H.264 tracks with labelled pictures (PictureMessage): planes, frame numbers, damage and the
/// scene are known from the pictures alone, in any container. Touch planes keep every value; planes of more
/// than 8 bits are two tracks.
class LabelledEncoder {
public:
    /// `touch`: coding of the touch planes, h264_quick or h264_thrifty; `colour`: h264_visual or
    /// h264_reduced. An error of kind usage if H.264 has no pictures of that size.
    static Result<LabelledEncoder> open(const RawFrame& first, const SceneDescription& described,
                                        TrackCoding touch, TrackCoding colour = TrackCoding::h264_visual);

    /// Number of tracks, in this order: colour first, which ordinary players show; low parts last.
    std::size_t tracks() const { return tracks_.size(); }
    /// "depth", "depth_low": for tools that show names.
    std::string name(std::size_t track) const { return tracks_[track].name(); }
    /// Stores in a container how a track is encoded.
    Result<void> describe(std::size_t track, AVCodecParameters& stored) const {
        return tracks_[track].encoder->describe(stored);
    }

    /// A packet for each track, without times. Planes have to be like the first frame's, else an error of
    /// kind input. `is_key`: decoding can begin with each packet.
    Result<std::vector<PacketPtr>> encode(const RawFrame& frame, const PictureLabel& label, bool is_key);

private:
    LabelledEncoder() = default;

    std::vector<PartTrack> tracks_;
    RawFrame form_;  // the first frame, for its planes' sizes: their samples are gone
    std::string scene_sei_;
};

/// A plane of a frameset as it was sent; touch planes keep every value.
struct LabelledPicture {
    PlaneRole role = PlaneRole::depth;
    PictureLabel label;
    bool is_key = false;                       ///< decoding could have begun with it
    Plane plane;                               ///< joined, if it was sent as two halves
    std::shared_ptr<const std::string> scene;  ///< JSON that came with it; null: none
};

/// Decodes the tracks of a LabelledEncoder, from any container and in any order of tracks. Pictures that are
/// damaged, not labelled, larger than stated, or depend on a missing one, are never returned, nor is a half
/// without its other half. Used by one thread.
class LabelledDecoder {
public:
    /// Larger pictures are not decoded.
    explicit LabelledDecoder(std::int64_t most_pixels) : most_pixels_(most_pixels) {}

    /// Adds a track of H.264 and returns its number, for `add`. Refused (ErrorKind::input): another codec,
    /// and more than 16 tracks.
    Result<std::size_t> add_track(const AVStream& stream, const std::string& where);
    /// The pictures that this packet completes. The only error is kind internal: out of memory.
    Result<std::vector<LabelledPicture>> add(std::size_t track, const AVPacket& packet);
    /// The remaining pictures, after the last packet.
    Result<std::vector<LabelledPicture>> end();
    /// To be called before packets that do not follow the previous ones.
    void restart();

    /// Colour comes without samples from here on.
    void leave_out_colour() { leaves_out_colour_ = true; }
    /// Number of pictures that were left out because they have other samples than were sent.
    std::int64_t damaged() const { return damaged_; }

private:
    struct Track {
        std::unique_ptr<PacketDecoder> decoder;
        bool has_begun = false;                // with a key packet
        bool is_broken = false;                // a picture that others depend on is missing
        std::optional<std::int64_t> newest{};  // frame number
        RgbConverter converter{};
    };
    /// One of the two parts of a plane.
    struct Half {
        PictureMessage message;
        LabelledPicture picture;
    };
    using Pictures = std::vector<LabelledPicture>;
    Result<void> send(Track& track, const AVPacket* packet, Pictures& pictures);
    Result<void> take(Track& track, FramePtr frame, Pictures& pictures);
    /// Whether the picture may be used. A colour picture does not show that it depends on a lost one; a touch
    /// plane does, by its hash.
    bool follows(Track& track, const PictureMessage& message, bool is_key) {
        const std::int64_t frame = message.label.frame;
        const bool is_next = track.newest && *track.newest < frame && frame - *track.newest == 1;
        track.newest = frame;
        track.is_broken = !is_key && (track.is_broken || !is_next);
        return !track.is_broken || message.role != PlaneRole::colour;
    }
    void join(const PictureMessage& message, LabelledPicture picture, Pictures& pictures);
    std::optional<Plane> plane_in(Track& track, FramePtr frame, const ReadSei& sei);

    const std::int64_t most_pixels_;
    std::deque<Track> tracks_;
    std::array<std::deque<Half>, all_roles.size()> halves_;
    bool leaves_out_colour_ = false;
    std::int64_t damaged_ = 0;
};

}  // namespace touchable
