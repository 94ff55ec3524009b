#include "player/session/frames_in_hand.hpp"

#include <cstddef>
#include <utility>

namespace touchable {
namespace {

class FramesInHand final : public ClipReader {
public:
    FramesInHand(std::unique_ptr<ClipReader> reader, std::vector<RawFrame> frames)
        : reader_(std::move(reader)), frames_(std::move(frames)) {
        for (const auto& input : reader_->inputs()) add_input(input);
    }
    const Scene& scene() const override { return reader_->scene(); }
    const std::vector<TrackInfo>& tracks() const override { return reader_->tracks(); }
    std::optional<std::int64_t> frame_count() const override { return reader_->frame_count(); }
    const std::vector<std::string>& notes() const override { return reader_->notes(); }
    Result<std::optional<RawFrame>> next() override {
        if (given_ < frames_.size()) return std::optional(std::exchange(frames_[given_++], {}));
        return reader_->next();
    }
    Result<void> rewind() override {
        frames_.clear();
        given_ = 0;
        return reader_->rewind();
    }
    Result<void> seek(std::int64_t frame) override {
        frames_.clear();
        given_ = 0;
        return reader_->seek(frame);
    }
    std::int64_t access_point(std::int64_t frame) const override { return reader_->access_point(frame); }
    void leave_out_colour() override { reader_->leave_out_colour(); }

private:
    std::unique_ptr<ClipReader> reader_;
    std::vector<RawFrame> frames_;
    std::size_t given_ = 0;
};

}  // namespace

std::unique_ptr<ClipReader> with_frames_in_hand(std::unique_ptr<ClipReader> reader,
                                                std::vector<RawFrame> frames) {
    return std::make_unique<FramesInHand>(std::move(reader), std::move(frames));
}

}  // namespace touchable
