// SPDX-License-Identifier: Apache-2.0
// Prefetched frames, and the far plane estimated from them.
#include <cstdlib>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"

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
    /// Drops prefetched frames: in a run they would come before they are taken.
    Result<void> begin(std::chrono::steady_clock::time_point zero) override {
        if (given_ < frames_.size()) TRY(leave_for(static_cast<std::int64_t>(given_)));
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

constexpr std::int64_t stray_of = 10'000;  // one valid pixel in this many may be stray
constexpr double far_margin = 1.05;

/// The far plane of a metric clip that does not give one: 5 % beyond the depth that at most one valid pixel
/// in 10 000 exceeds. (A camera's stray pixels say nothing of its scene, and a far plane out there would make
/// codes coarser for all others.)
class FarPlaneEstimator {
public:
    explicit FarPlaneEstimator(const DepthCoding& coding) : coding_(coding), pixels_(65536) {}
    void add(const PlaneView& depth) {
        for (int y = 0; y < depth.height && !stop_requested(); ++y)
            for (int x = 0; x < depth.width; ++x) ++pixels_[static_cast<std::size_t>(depth.sample(x, y))];
        ++frames_;
    }

    /// Sets the scene's far plane and returns a note on it. An error if no depth was valid.
    Result<std::string> settle(Scene& scene) const {
        std::int64_t valid = 0;
        const auto is_valid = [&](int code) { return coding_.is_valid(static_cast<std::uint16_t>(code)); };
        for (int code = 0; code < 65536; ++code)
            if (is_valid(code)) valid += pixels_[static_cast<std::size_t>(code)];
        if (valid == 0) return input_error("no frame has a valid depth: give depth.far in the scene file");
        std::int64_t beyond = 0;
        int deepest = 65535;
        for (;; --deepest) {
            if (!is_valid(deepest)) continue;
            const std::int64_t here = pixels_[static_cast<std::size_t>(deepest)];
            if (beyond + here > valid / stray_of) break;
            beyond += here;
        }
        const double depth = coding_.depth(static_cast<std::uint16_t>(deepest));
        SceneDescription open(scene);
        open.unstated.far = true;
        TRY_ASSIGN(scene, touchable::settle(open, {.far = depth * far_margin}));
        // Some strays lie within the margin.
        std::int64_t lost = 0;
        for (int code = deepest + 1; code < 65536; ++code)
            if (is_valid(code) && !scene.depth.is_valid(static_cast<std::uint16_t>(code)))
                lost += pixels_[static_cast<std::size_t>(code)];
        const std::string note = formatted(
            "depth.far is %.6g, 5 %% beyond the depth that 1 pixel in %d exceeds at most (%d frame%s)",
            scene.depth.far, static_cast<int>(stray_of), frames_, frames_ == 1 ? "" : "s");
        if (lost == 0) return note;
        return note + formatted("; %.2g %% of the pixels lie beyond it and count as holes",
                                100 * static_cast<double>(lost) / static_cast<double>(valid));
    }

private:
    DepthCoding coding_;
    std::vector<std::int64_t> pixels_;  // pixel counts by code
    int frames_ = 0;
};

/// Adds a frame's depth; false if there is no frame.
Result<bool> look_at_frame(Result<std::optional<RawFrame>> frame, FarPlaneEstimator& estimator) {
    if (stop_requested()) return interrupted_error();
    if (!frame) return frame.error();
    if (*frame) estimator.add((*frame)->depth);
    if (stop_requested()) return interrupted_error();
    return frame->has_value();
}

Result<void> look_at_clip(Prefetch& ahead, FarPlaneEstimator& estimator) {
    std::int64_t looked = 0;  // frames in a row
    for (bool more = true; more && looked < first_frames;) {
        const auto there = look_at_frame(ahead.next(), estimator);
        if (!there && (looked == 0 || there.error().kind == ErrorKind::interrupted)) return there.error();
        more = there && *there;
        looked += more ? 1 : 0;
    }
    for (const std::int64_t wanted : telling_frames(ahead.clip().frame_count().value_or(0))) {
        const std::int64_t frame = ahead.clip().access_point(wanted);
        if (wanted < looked || frame < looked) continue;
        looked = frame + 1;
        const auto there = look_at_frame(ahead.at(frame), estimator);
        if (!there && there.error().kind == ErrorKind::interrupted) return there.error();
    }
    return {};
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

std::vector<std::int64_t> telling_frames(std::int64_t count) {
    std::vector<std::int64_t> frames;
    for (std::int64_t k = 0; k < std::min(count, first_frames); ++k) frames.push_back(k);
    const std::int64_t rest = count - first_frames;
    for (std::int64_t k = 1; k <= std::min(rest, spread_frames); ++k)
        frames.push_back(first_frames + rest * k / std::min(rest, spread_frames) - 1);
    return frames;
}

Result<std::unique_ptr<ClipReader>> with_far_plane(std::unique_ptr<ClipReader> clip, bool far_is_open,
                                                   const std::filesystem::path& file) {
    if (!far_is_open) return clip;
    Scene scene = clip->scene();
    FarPlaneEstimator estimator(scene.depth);
    Prefetch ahead(std::move(clip));
    TRY(look_at_clip(ahead, estimator));
    TRY_ASSIGN(auto note, error_at(file.string(), estimator.settle(scene)));
    TRY_ASSIGN(auto at_its_beginning, ahead.finish());
    return std::make_unique<ChangedClip>(std::move(at_its_beginning), std::move(scene), std::move(note));
}

}  // namespace touchable
