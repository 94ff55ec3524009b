// SPDX-License-Identifier: Apache-2.0
// A stream as a clip that cannot go back.

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/stream/receiver.hpp"

namespace touchable {
namespace {

/// The choice of filters looks at 16 frames.
constexpr std::size_t most_kept = 48, most_kept_bytes = std::size_t{512} << 20;
constexpr std::int64_t most_in_place = 1'000;  // frames in place of lost ones

class StreamClip final : public ClipReader {
public:
    StreamClip(const StreamSource& source, std::unique_ptr<StreamReceiver> receiver)
        : url_(source.url), patience_(source.patience.frameset), receiver_(std::move(receiver)) {}

    const Scene& scene() const override { return receiver_->scene(); }
    UnstatedFilters unstated_filters() const override { return receiver_->unstated().filters; }
    const std::vector<TrackInfo>& tracks() const override { return receiver_->tracks(); }
    std::optional<std::int64_t> frame_count() const override { return std::nullopt; }
    const std::vector<ClipNote>& notes() const override { return receiver_->notes(); }

    Result<std::optional<RawFrame>> next() override {
        if (position_ < std::ssize(first_))
            return std::optional(first_[static_cast<std::size_t>(position_++)]);
        auto frame = read();
        if (frame && *frame) ++position_;
        return frame;
    }

    Result<void> rewind() override { return seek(0); }

    Result<void> seek(std::int64_t frame) override {
        if (frame < 0)
            return usage_error("frame " + std::to_string(frame) + " is before the clip's first, 0");
        if (frame < read_ && !keeps_)
            return usage_error(
                url_.name() + ": is a stream, which goes on and not back; save it first: touchable convert " +
                shell_word(url_.name()) + " clip.mkv");
        position_ = std::min(frame, read_);
        while (position_ < frame) {
            TRY_ASSIGN(const auto passed, next());
            if (!passed)
                return usage_error(url_.name() + ": has no frame " + std::to_string(frame) +
                                   ": its last is " + std::to_string(read_ - 1));
        }
        return {};
    }

    void leave_out_colour() override { receiver_->leave_out_colour(); }

    std::vector<std::string> remarks() const override {
        std::vector<std::string> all;
        const FramesetCounts counts = receiver_->counts();
        add_count(all, counts.lost, "the stream's framesets were lost on the way");
        add_count(all, counts.late, "the stream's framesets came late");
        add_count(all, counts.torn, "the stream's framesets were damaged on the way");
        if (held_ > 0)
            all.push_back("in place of them the one before was held, for " + std::to_string(held_) +
                          " frames");
        if (!end_.empty()) all.push_back(end_);
        return all;
    }

private:
    Result<std::optional<RawFrame>> read() {
        if (fault_) return *fault_;
        if (!coming_) {
            auto received = receiver_->next(patience_);
            if (!received && received.error().kind == ErrorKind::interrupted) return received.error();
            if (!received) {
                fault_ = error_at(url_.name() + ": frame " + std::to_string(read_), received.error());
                return *fault_;
            }
            if (!*received && receiver_->was_broken_off() && !ends_by_itself())
                return input_error(url_.name() + ": frame " + std::to_string(read_) + ": the sender " +
                                   receiver_->how_it_ended() + " in the middle of it");
            if (!*received &&
                (url_.transport == StreamTransport::udp || url_.transport == StreamTransport::srt))
                end_ = "the sender " + receiver_->how_it_ended() + " after frame " +
                       std::to_string(read_ - 1) + ", so the clip ends there";
            if (!*received) return std::optional<RawFrame>();
            coming_ = std::move(*received);
        }
        const std::int64_t missing = coming_->number - first_number_ - read_;
        const bool holds = newest_ && missing > 0 && missing <= most_in_place;
        if (!holds) {
            first_number_ = coming_->number - read_;
            newest_ = std::move(coming_->frame);
            coming_.reset();
        }
        held_ += holds ? 1 : 0;
        newest_->number = read_;
        newest_->time_ns = scene().rate.time_ns(read_);
        ++read_;
        keep(*newest_);
        return newest_;
    }

    void keep(const RawFrame& frame) {
        if (!keeps_) return;
        first_.push_back(frame);
        first_bytes_ += bytes_of_planes(frame);
        if (first_.size() <= most_kept && first_bytes_ <= most_kept_bytes) return;
        keeps_ = false;
        first_ = {};
    }

    bool ends_by_itself() const {
        return url_.transport == StreamTransport::srt || url_.transport == StreamTransport::udp ||
               url_.transport == StreamTransport::file;
    }

    const StreamUrl url_;
    const std::chrono::milliseconds patience_;
    std::unique_ptr<StreamReceiver> receiver_;
    std::optional<Received> coming_;
    std::optional<Error> fault_;  // nothing more is read after it
    std::optional<RawFrame> newest_;
    std::int64_t first_number_ = 0;  // the stream's number of frame 0
    std::int64_t read_ = 0;          // frames
    std::int64_t position_ = 0;      // of the frame that `next` returns
    std::int64_t held_ = 0;
    std::string end_;              // a remark on an end that may be the sender's or the network's
    std::vector<RawFrame> first_;  // all frames that were read, as long as they are few
    std::size_t first_bytes_ = 0;
    bool keeps_ = true;
};

}  // namespace

Result<std::unique_ptr<ClipReader>> open_stream_clip(const StreamSource& source,
                                                     const std::optional<SceneDescription>& described,
                                                     Colour colour) {
    const auto wait = source.connection ? source.connection->waits() : std::make_shared<StreamWait>();
    TRY_ASSIGN(auto receiver, StreamReceiver::open(source, wait, described));
    auto clip = std::make_unique<StreamClip>(source, std::move(receiver));
    if (colour == Colour::left_out) clip->leave_out_colour();
    return std::unique_ptr<ClipReader>(std::move(clip));
}

bool is_saved_stream(const SourceFile& file) {
    constexpr std::size_t packet = 188;
    const std::string begin = first_bytes(file, 3 * packet);
    return begin.size() == 3 * packet && begin[0] == 'G' && begin[packet] == 'G' && begin[2 * packet] == 'G';
}

Result<std::unique_ptr<ClipReader>> open_saved_stream(const SourceFile& file,
                                                      const std::optional<SceneDescription>& described,
                                                      Colour colour) {
    StreamSource source;
    source.url.transport = StreamTransport::file;
    source.url.text = file.string();
    TRY_ASSIGN(source.connection, StreamBytes::of_file(file));
    TRY_ASSIGN(auto clip, open_stream_clip(source, described, colour));
    clip->add_input(file.path());
    return clip;
}

}  // namespace touchable
