#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/stream/sender_time.hpp"
#include "engine/stream/stream_muxer.hpp"
#include "engine/stream/stream_ring.hpp"

namespace touchable {

/// A form in which a stream is sent, and where its framesets go.
struct StreamChannel {
    std::unique_ptr<StreamMuxer> muxer;
    StreamRing& ring;
};

struct SendSettings {
    bool loop = false;                         ///< of a clip: from its beginning again and again
    std::optional<std::int64_t> longest_ns{};  ///< of the stream
    bool is_paced = true;                      ///< of a clip: otherwise as fast as it can be read and encoded
};

/// What was sent, whoever listened.
struct SendFigures {
    std::int64_t framesets = 0, keys = 0, bytes = 0;
    std::int64_t rounds = 0;      ///< of a loop, begun
    std::int64_t latest_ns = 0;   ///< behind its time, of the frameset that was so most
    std::int64_t held_up_ns = 0;  ///< what was not made up for
    bool clip_ended = false;      ///< it gave no further frame: a camera is gone
};

/// Sends a clip at its own times, or a camera's frames as they are taken: each is encoded once in every form.
/// Frames are numbered one after the other and times go on, also from round to round of a loop. Decoding of
/// all planes begins at least every half second, and every 15 frames.
class StreamSender {
public:
    static constexpr std::int64_t longest_between_keys_ns = 500'000'000, most_between_keys = 15;
    /// A clip begins so long after it is asked to: by then its first frames are encoded.
    static constexpr std::int64_t lead_ns = 100'000'000;
    /// A clip that is so late begins again from where it is, rather than hurry.
    static constexpr std::int64_t longest_hurry_ns = 500'000'000;

    /// The rings and `time` outlive it.
    StreamSender(std::unique_ptr<ClipReader> clip, std::vector<StreamChannel> channels,
                 const SendSettings& settings, SenderTime& time)
        : clip_(std::move(clip)), channels_(std::move(channels)), settings_(settings), time_(time) {}

    /// From the clip's beginning until it ends, it was sent for long enough, or it is told to end; the rings
    /// are then over.
    Result<void> run();
    /// From any thread.
    void end();
    /// From any thread.
    std::int64_t framesets() const { return sent_; }
    /// What a person should know of the run, such as that the camera was unplugged.
    std::vector<std::string> remarks() const { return clip_->remarks(); }
    /// Once it has run.
    const SendFigures& figures() const { return figures_; }

private:
    struct Due {
        std::int64_t time_ns;  ///< of the stream
        std::int64_t at_ns;    ///< of the sender's time; of a camera's frame, when it was taken
    };
    Result<void> send_all();
    Result<std::optional<RawFrame>> next();
    Due due(const RawFrame& frame) const;
    Result<bool> send(const RawFrame& frame, const Due& due);
    bool is_key(std::int64_t time_ns);
    void give(StreamChannel& channel, StreamBlock block);
    void keep_pace(const Due& due);

    const std::unique_ptr<ClipReader> clip_;
    std::vector<StreamChannel> channels_;
    const SendSettings settings_;
    SenderTime& time_;
    std::atomic<bool> is_told_to_end_{false};
    std::atomic<std::int64_t> sent_{0};
    SendFigures figures_;
    std::int64_t begin_ns_ = 0;  // time 0 of the stream
    std::int64_t round_ns_ = 0;  // when the round began, of a stream whose frames have own times
    std::int64_t frames_of_round_ = 0;
    std::int64_t key_frame_ = 0, key_time_ns_ = 0;  // of the newest key
};

}  // namespace touchable
