#include "engine/clip/prefetch.hpp"

#include <cstdlib>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/reader_around.hpp"

namespace touchable {
namespace {

class PrefetchedClip final : public ReaderAround {
public:
    PrefetchedClip(std::unique_ptr<ClipReader> clip, std::vector<RawFrame> frames)
        : ReaderAround(std::move(clip)), frames_(std::move(frames)) {}
    Result<std::optional<RawFrame>> next() override {
        if (given_ < frames_.size()) return std::optional(std::exchange(frames_[given_++], {}));
        return inner().next();
    }
    Result<void> seek(std::int64_t frame) override {
        const bool is_next = given_ < frames_.size() && frame == static_cast<std::int64_t>(given_);
        return is_next ? Result<void>{} : leave_for(frame);
    }
    /// Those that were read ahead are of the future then.
    Result<void> begin(std::chrono::steady_clock::time_point zero) override {
        if (given_ < frames_.size())
            if (auto back = leave_for(static_cast<std::int64_t>(given_)); !back.ok()) return back;
        return inner().begin(zero);
    }

private:
    Result<void> leave_for(std::int64_t frame) {
        frames_.clear();
        given_ = 0;
        return inner().seek(frame);
    }

    std::vector<RawFrame> frames_;
    std::size_t given_ = 0;
};

std::size_t bytes_of(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += static_cast<std::size_t>(std::abs(plane->stride)) * static_cast<std::size_t>(plane->height);
    return bytes;
}

}  // namespace

std::unique_ptr<ClipReader> with_prefetched_frames(std::unique_ptr<ClipReader> clip,
                                                   std::vector<RawFrame> frames) {
    return std::make_unique<PrefetchedClip>(std::move(clip), std::move(frames));
}

Result<std::optional<RawFrame>> Prefetch::next() {
    auto frame = clip_->next();
    is_damaged_ = !frame;
    if (!frame || !*frame) return frame;
    ++number_;
    bytes_ += bytes_of(**frame);
    if (bytes_ <= most_bytes)
        frames_.push_back(**frame);
    else
        frames_.clear();
    return frame;
}

Result<std::optional<RawFrame>> Prefetch::at(std::int64_t frame) {
    has_moved_ = true;
    TRY(clip_->seek(frame));
    return clip_->next();
}

Result<std::unique_ptr<ClipReader>> Prefetch::finish() {
    const bool kept = bytes_ <= most_bytes && !is_damaged_;
    if (!kept) {
        TRY(clip_->rewind());
        return std::move(clip_);
    }
    if (has_moved_) TRY(clip_->seek(number_));
    return with_prefetched_frames(std::move(clip_), std::move(frames_));
}

}  // namespace touchable
