#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/picture_label.hpp"
#include "engine/clip/track_decoder.hpp"
#include "engine/stream/frameset_assembler.hpp"

namespace touchable {

/// Makes pictures of the packets of one plane, of which some may be damaged or missing. What is decoded from
/// one that is missing or damaged is not decoded; larger pictures than 2^24 pixels are damaged ones.
class StreamTrack {
public:
    /// Refuses (ErrorKind::input) a track whose header has pictures of more than 2^24 pixels. Messages begin
    /// with `where`.
    static Result<void> check_size(const AVStream& stream, const std::string& where);
    /// The frame of a picture without a label, by its time in the stream.
    using NumberOf = std::function<std::int64_t(std::int64_t timestamp)>;
    StreamTrack(TrackDecoder decoder, int stream, NumberOf number_of)
        : decoder_(std::move(decoder)), stream_(stream), number_of_(std::move(number_of)) {}

    int stream() const { return stream_; }
    PlaneRole role() const { return decoder_.role(); }
    /// Whole once there was a picture.
    const TrackInfo& info() const { return decoder_.info(); }
    /// "tcp://h:7000: track depth".
    std::string name() const { return decoder_.name(); }

    struct Outcome {
        std::vector<StreamPicture> pictures{};
        bool is_torn = false;  ///< its checksum is wrong
        bool is_left = false;  ///< it is sound, but what it depends on is not there
    };
    Result<Outcome> take(const AVPacket& packet);
    /// After the last packet.
    Result<Outcome> finish();

private:
    struct Sent {
        std::optional<PictureLabel> label;
        std::int64_t frames = 1;
    };
    bool is_sound(const AVPacket& packet);
    bool depends_on_missing(const AVPacket& packet);
    void forget();
    Outcome torn();
    Result<Outcome> decode(const AVPacket* packet);

    TrackDecoder decoder_;
    int stream_;
    NumberOf number_of_;
    Sent newest_;            // of the packet at hand
    std::deque<Sent> sent_;  // to the decoder, and not out yet
    std::optional<bool> has_additions_;
    std::optional<std::int64_t> next_number_;  // of labels, where nothing is missing
    bool waits_for_key_ = true;
};

}  // namespace touchable
