#include "player/session/only_frames.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "engine/media/reader_around.hpp"

namespace touchable {
namespace {

class OnlyFrames final : public ReaderAround {
public:
    OnlyFrames(std::unique_ptr<ClipReader> reader, std::vector<FrameRun> runs)
        : ReaderAround(std::move(reader)), runs_(std::move(runs)) {}

    /// To the first of them that is not before it.
    Result<void> seek(std::int64_t frame) override {
        wanted_ = frame;
        run_ = 0;
        return {};
    }
    Result<std::optional<RawFrame>> next() override {
        while (run_ < runs_.size() && wanted_ - runs_[run_].first >= runs_[run_].count) ++run_;
        if (run_ == runs_.size()) return std::optional<RawFrame>();
        wanted_ = std::max(wanted_, runs_[run_].first);
        if (wanted_ >= frame_count().value_or(wanted_ + 1)) return std::optional<RawFrame>();
        if (wanted_ != position_)
            if (auto there = inner().seek(wanted_); !there.ok()) return there.error();
        position_ = ++wanted_;
        return inner().next();
    }

private:
    const std::vector<FrameRun> runs_;
    std::size_t run_ = 0;
    std::int64_t wanted_ = 0, position_ = 0;  // what is given next, and by the clip
};

}  // namespace

std::unique_ptr<ClipReader> only_frames(std::unique_ptr<ClipReader> reader, std::vector<FrameRun> runs) {
    return std::make_unique<OnlyFrames>(std::move(reader), std::move(runs));
}

}  // namespace touchable
