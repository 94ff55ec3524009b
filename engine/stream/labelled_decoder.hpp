#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/packet_decoder.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/rgb_converter.hpp"
#include "engine/stream/picture_message.hpp"

namespace touchable {

/// A plane of a frameset as it was sent: every value of it where it is felt.
struct LabelledPicture {
    PlaneRole role = PlaneRole::depth;
    PictureLabel label;
    bool is_key = false;                       ///< decoding could have begun with it
    std::int64_t time_ns = 0;                  ///< by the container's clock
    Plane plane;                               ///< of both halves, where it was sent as two
    std::shared_ptr<const std::string> scene;  ///< JSON that came with it; null: none did
};

/// Pictures that were not given, by cause.
struct PictureFaults {
    std::int64_t undecodable = 0;  ///< also larger than was said, or depending on one that is not there
    std::int64_t unlabelled = 0;   ///< of somebody else, or what they say of themselves is damaged
    std::int64_t damaged = 0;      ///< other samples than were sent
    std::int64_t halved = 0;       ///< whose other half never came
    std::int64_t all() const { return undecodable + unlabelled + damaged + halved; }
};

/// Takes apart what LabelledEncoder made, whatever carried it and in whatever order its tracks come. What is
/// damaged is counted and never given. One thread.
class LabelledDecoder {
public:
    /// Larger pictures are not decoded.
    explicit LabelledDecoder(std::int64_t most_pixels) : most_pixels_(most_pixels) {}

    /// One more track of H.264, which its packets are to name. Refused (ErrorKind::input) is another codec,
    /// and more than 16.
    Result<std::size_t> add_track(const AVStream& stream, const std::string& where);
    /// The pictures that are whole with this packet. An error only of kind internal: out of memory.
    Result<std::vector<LabelledPicture>> add(std::size_t track, const AVPacket& packet);
    /// Those that are left, once no packet comes any more.
    Result<std::vector<LabelledPicture>> end();
    /// Packets from here on do not follow those before.
    void restart();

    /// Colour from here on comes without samples.
    void leave_out_colour() { leaves_out_colour_ = true; }
    const PictureFaults& faults() const { return faults_; }

private:
    struct Track {
        std::unique_ptr<PacketDecoder> decoder;
        AVRational time_base;
        bool has_begun = false;                // with a packet that is a key
        bool is_broken = false;                // a picture that others depend on is missing
        std::optional<std::int64_t> newest{};  // frame number
        RgbConverter converter{};
    };
    /// A plane that is in two parts, of which one came.
    struct Half {
        PictureMessage message;
        LabelledPicture picture;
    };
    using Pictures = std::vector<LabelledPicture>;
    Result<void> send(Track& track, const AVPacket* packet, Pictures& pictures);
    Result<void> take(Track& track, FramePtr frame, Pictures& pictures);
    bool follows(Track& track, const PictureMessage& message, bool is_key);
    void join(const PictureMessage& message, LabelledPicture picture, Pictures& pictures);
    std::optional<Plane> plane_in(Track& track, FramePtr frame, const ReadSei& sei);

    const std::int64_t most_pixels_;
    std::deque<Track> tracks_;
    std::array<std::deque<Half>, all_roles.size()> halves_;
    bool leaves_out_colour_ = false;
    PictureFaults faults_;
};

}  // namespace touchable
