#include "player/session/shared_clip.hpp"

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {
namespace {

// A run by other settings begins where the one before it is. If that reads 12 frames ahead of the hand, and
// a filter with a memory wants 16 frames before its beginning, 28 must be there: otherwise both take turns at
// the one decoder, each by a seek. So many of 1920x1080 with all four planes are less than 576 MiB. Of larger
// frames there are fewer: 12, which do without such a filter, where those are less than 1 GiB (3840x2160).
constexpr std::size_t most_kept = 32, kept_without_memory = 12, least_kept = 2;
constexpr std::size_t most_newest_bytes = std::size_t{576} << 20, most_first_bytes = std::size_t{128} << 20;

/// Whether so many frames are more than are to be kept.
bool is_too_much(std::size_t frames, std::size_t bytes) {
    const std::size_t most = frames > kept_without_memory ? most_newest_bytes : std::size_t{1} << 30;
    return frames > most_kept || (frames > least_kept && bytes > most);
}

std::size_t kept_bytes_of(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += static_cast<std::size_t>(plane->width) * static_cast<std::size_t>(plane->height) *
                 static_cast<std::size_t>(plane->channels * plane->bytes_per_sample);
    return bytes;
}

}  // namespace

/// What describes the clip stays as it is once the clip is open, so that no reader waits for another there.
class SharedClip::Reader final : public ClipReader {
public:
    explicit Reader(std::shared_ptr<SharedClip> shared) : shared_(std::move(shared)) {
        ++shared_->readers_;
        for (const auto& input : clip().inputs()) add_input(input);
    }
    ~Reader() override { --shared_->readers_; }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    const Scene& scene() const override { return clip().scene(); }
    UnstatedFilters unstated_filters() const override { return clip().unstated_filters(); }
    const std::vector<TrackInfo>& tracks() const override { return clip().tracks(); }
    std::optional<std::int64_t> frame_count() const override { return clip().frame_count(); }
    const std::vector<std::string>& notes() const override { return clip().notes(); }
    std::span<const Camera> frame_cameras() const override { return clip().frame_cameras(); }
    Result<std::optional<RawFrame>> next() override {
        auto frame = shared_->frame(next_number_, is_from_the_beginning_);
        if (frame.ok() && *frame) next_number_ = (*frame)->number + 1;
        return frame;
    }
    Result<void> rewind() override { return seek(0); }
    /// The clip itself is led there only when a frame is wanted that nobody has read.
    Result<void> seek(std::int64_t frame) override {
        const auto count = frame_count();
        if (frame < 0 || (count && frame > *count))
            return usage_error("frame " + std::to_string(frame) + ": must be 0 to the clip's last" +
                               (count ? ", " + std::to_string(*count - 1) : std::string()));
        next_number_ = frame;
        is_from_the_beginning_ = false;
        return {};
    }
    std::int64_t access_point(std::int64_t frame) const override {
        const std::lock_guard lock(shared_->mutex_);
        return clip().access_point(frame);
    }

private:
    ClipReader& clip() const { return *shared_->clip_; }

    std::shared_ptr<SharedClip> shared_;
    std::int64_t next_number_ = 0;
    bool is_from_the_beginning_ = true;
};

Result<std::unique_ptr<ClipReader>> SharedClip::open(const Open& open_clip) {
    if (!clip_) {
        auto opened = open_clip();
        if (!opened.ok()) return opened;
        clip_ = std::move(*opened);
        position_ = 0;
    }
    return std::unique_ptr<ClipReader>(std::make_unique<Reader>(shared_from_this()));
}

void SharedClip::forget_first_frames() {
    keeps_first_ = false;  // whoever reads next lets go of them: a read may take long
}

Result<std::optional<RawFrame>> SharedClip::frame(std::int64_t number, bool is_from_the_beginning) {
    const std::lock_guard lock(mutex_);
    if (!keeps_first_) first_.clear();
    if (const RawFrame* const there = kept(number, is_from_the_beginning)) return std::optional(*there);
    // A read that was broken off would leave a clip in the middle of a frame, of which the other run knows
    // nothing.
    const WorkForAll work;
    // Not known where reading fails.
    if (std::exchange(position_, std::nullopt) != number) TRY(clip_->seek(number));
    auto frame = clip_->next();
    if (!frame.ok()) return frame;
    position_ = *frame ? (*frame)->number + 1 : number;
    if (*frame) keep(**frame);
    return frame;
}

/// The first frames are for whoever looks at no others, as a survey does: behind them reading on would mean
/// to seek.
const RawFrame* SharedClip::kept(std::int64_t number, bool is_from_the_beginning) const {
    for (const RawFrame& frame : newest_)
        if (frame.number == number) return &frame;
    const auto index = static_cast<std::size_t>(number);
    return is_from_the_beginning && index < first_.size() ? &first_[index] : nullptr;
}

void SharedClip::keep(const RawFrame& frame) {
    const std::size_t bytes = kept_bytes_of(frame);
    newest_.push_back(frame);
    newest_bytes_ += bytes;
    while (is_too_much(newest_.size(), newest_bytes_)) {
        newest_bytes_ -= kept_bytes_of(newest_.front());
        newest_.pop_front();
    }
    if (!keeps_first_ || first_.size() == DepthEstimator::frames ||
        frame.number != static_cast<std::int64_t>(first_.size()))
        return;
    first_.push_back(frame);
    first_bytes_ += bytes;
    if (first_bytes_ > most_first_bytes) {
        keeps_first_ = false;
        first_.clear();
    }
}

}  // namespace touchable
