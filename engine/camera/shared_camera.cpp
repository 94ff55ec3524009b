#include "engine/camera/shared_camera.hpp"

#include <atomic>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/clip/camera_run.hpp"

namespace touchable {

class SharedCamera::Reader final : public ClipReader {
public:
    Reader(std::shared_ptr<SharedCamera> shared, bool is_first)
        : shared_(std::move(shared)), reads_(is_first) {
        for (const auto& input : camera().inputs()) add_input(input);
    }
    const Scene& scene() const override { return camera().scene(); }
    UnstatedFilters unstated_filters() const override { return camera().unstated_filters(); }
    const std::vector<TrackInfo>& tracks() const override { return camera().tracks(); }
    std::optional<std::int64_t> frame_count() const override { return std::nullopt; }
    const std::vector<std::string>& notes() const override { return camera().notes(); }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override;
    bool is_live() const override { return true; }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override;
    void interrupt() override {
        if (reads_) camera().interrupt();
    }
    std::vector<std::string> remarks() const override { return camera().remarks(); }
    std::int64_t taken_before(std::int64_t frame) const override { return camera().taken_before(frame); }
    std::optional<StreamFigures> stream_figures() const override { return camera().stream_figures(); }

private:
    ClipReader& camera() const { return *shared_->camera_; }

    std::shared_ptr<SharedCamera> shared_;
    std::atomic<bool> reads_;       // the camera, and not what another run was given
    std::int64_t next_number_ = 0;  // before the run
    std::int64_t further_ = 0;      // the run's numbers than the camera's
};

/// A frame of before the run is as the camera has such: numbered one by one, a moment apart.
Result<std::optional<RawFrame>> SharedCamera::Reader::next() {
    if (reads_) {
        auto frame = shared_->read();
        if (frame.ok() && *frame) (*frame)->number += further_;
        return frame;
    }
    TRY_ASSIGN(auto frame, shared_->newest());
    frame.number = next_number_++;
    frame.time_ns = frame.number * ns_before_a_run;
    return std::optional(std::move(frame));
}

Result<void> SharedCamera::Reader::seek(std::int64_t frame) {
    if (reads_) return camera().seek(frame);
    next_number_ = frame;
    return {};
}

Result<void> SharedCamera::Reader::begin(std::chrono::steady_clock::time_point zero) {
    if (auto begun = camera().begin(zero); !begun.ok() || reads_) return begun;
    further_ = next_number_ - shared_->next_number_;
    reads_ = true;
    return {};
}

Result<std::optional<RawFrame>> SharedCamera::read() {
    auto frame = camera_->next();
    if (!frame.ok() || !*frame) return frame;
    next_number_ = (*frame)->number + 1;
    const std::lock_guard lock(mutex_);
    newest_ = **frame;
    came_.notify_all();
    return frame;
}

/// The next that comes soon, so that two of them are two; otherwise the one before.
Result<RawFrame> SharedCamera::newest() {
    constexpr std::chrono::milliseconds soon(100);
    std::unique_lock lock(mutex_);
    if (!newest_) return input_error("the camera has given no frame yet");
    const void* const before = newest_->storage.get();
    came_.wait_for(lock, soon, [&] { return newest_->storage.get() != before; });
    return *newest_;
}

Result<std::unique_ptr<ClipReader>> SharedCamera::open(
    const PluggedChoice& choice, const std::optional<SourceDescription>& known,
    const std::optional<std::filesystem::path>& scene_file) {
    const bool is_first = !camera_;
    if (is_first) {
        auto camera = open_plugged_camera(choice, known, scene_file);
        if (!camera.ok()) return camera;
        camera_ = std::move(*camera);
    }
    return std::unique_ptr<ClipReader>(std::make_unique<Reader>(shared_from_this(), is_first));
}

}  // namespace touchable
