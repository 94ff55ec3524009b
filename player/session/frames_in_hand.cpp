#include "player/session/frames_in_hand.hpp"

#include <cstddef>
#include <utility>

#include "engine/media/reader_around.hpp"

namespace touchable {
namespace {

class FramesInHand final : public ReaderAround {
public:
    FramesInHand(std::unique_ptr<ClipReader> reader, std::vector<RawFrame> frames)
        : ReaderAround(std::move(reader)), frames_(std::move(frames)) {}
    Result<std::optional<RawFrame>> next() override {
        if (given_ < frames_.size()) return std::optional(std::exchange(frames_[given_++], {}));
        return inner().next();
    }
    Result<void> seek(std::int64_t frame) override {
        frames_.clear();
        given_ = 0;
        return inner().seek(frame);
    }
    /// Those that were read ahead are of the future then.
    Result<void> begin(std::chrono::steady_clock::time_point zero) override {
        if (given_ < frames_.size())
            if (auto back = seek(static_cast<std::int64_t>(given_)); !back.ok()) return back;
        return inner().begin(zero);
    }

private:
    std::vector<RawFrame> frames_;
    std::size_t given_ = 0;
};

}  // namespace

std::unique_ptr<ClipReader> with_frames_in_hand(std::unique_ptr<ClipReader> reader,
                                                std::vector<RawFrame> frames) {
    return std::make_unique<FramesInHand>(std::move(reader), std::move(frames));
}

}  // namespace touchable
