#include "player/session/camera_capture.hpp"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/clip/reader_around.hpp"

namespace touchable {
namespace {

// A second of frames: a disk that sleeps longer costs some.
constexpr std::size_t most_waiting = 30;

class KeptCamera final : public ReaderAround {
public:
    KeptCamera(std::unique_ptr<ClipReader> camera, std::shared_ptr<CameraCapture> film)
        : ReaderAround(std::move(camera)), film_(std::move(film)) {}
    Result<std::optional<RawFrame>> next() override {
        auto frame = inner().next();
        if (!frame.ok() || !*frame) return frame;
        TRY(film_->keep(**frame));
        return frame;
    }
    void interrupt() override {
        inner().interrupt();
        film_->interrupt();
    }

private:
    std::shared_ptr<CameraCapture> film_;
};

class CapturedCamera final : public ReaderAround {
public:
    CapturedCamera(std::unique_ptr<ClipReader> film, CapturedFrames frames)
        : ReaderAround(std::move(film)), frames_(std::move(frames)) {}
    std::optional<std::int64_t> frame_count() const override { return std::nullopt; }
    std::int64_t access_point(std::int64_t) const override { return 0; }
    std::optional<std::int64_t> taken_at(std::int64_t frame) const override {
        const auto found = place_of(frame);
        return found != frames_.end() && found->number == frame ? std::optional(found->time_ns)
                                                                : std::nullopt;
    }
    Result<void> seek(std::int64_t frame) override {
        next_ = place_of(frame) - frames_.begin();
        return inner().seek(next_);
    }
    Result<std::optional<RawFrame>> next() override {
        if (next_ == std::ssize(frames_)) return std::optional<RawFrame>();
        auto frame = inner().next();
        if (!frame.ok() || !*frame) return frame;
        const CapturedFrame& taken = frames_[static_cast<std::size_t>(next_++)];
        (*frame)->number = taken.number;
        (*frame)->time_ns = taken.time_ns;
        return frame;
    }

private:
    CapturedFrames::const_iterator place_of(std::int64_t frame) const {
        return std::lower_bound(
            frames_.begin(), frames_.end(), frame,
            [](const CapturedFrame& taken, std::int64_t number) { return taken.number < number; });
    }

    CapturedFrames frames_;
    std::ptrdiff_t next_ = 0;  // frame of the film
};

}  // namespace

CameraCapture::~CameraCapture() {
    stop();
}

Result<void> CameraCapture::open(const std::filesystem::path& file, Existing existing) {
    TRY_ASSIGN(auto writer, create_clip(file, described_, {}, existing));
    writer_ = std::move(writer);
    file_ = file;
    {
        const std::lock_guard lock(mutex_);
        open_ = true;
    }
    return start_thread(thread_, "camera-capture", "that keeps the camera's frames", [this] {
        try {
            write();
        } catch (const std::exception& fault) {
            const std::lock_guard lock(mutex_);
            failure_ = Error{ErrorKind::internal, file_.string() + ": cannot be written: " + fault.what()};
            is_broken_ = true;
            changed_.notify_all();
        }
    });
}

Result<void> CameraCapture::keep(const RawFrame& frame) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] {
        return !open_ || waiting_.size() < most_waiting || interrupted_ || failure_.has_value();
    });
    if (failure_) return {};
    if (interrupted_) return Error{ErrorKind::interrupted, "the camera's film was told to stop"};
    waiting_.push_back(frame);
    frames_.push_back({frame.number, frame.time_ns});
    changed_.notify_all();
    return {};
}

void CameraCapture::interrupt() {
    const std::lock_guard lock(mutex_);
    interrupted_ = true;
    changed_.notify_all();
}

void CameraCapture::write() {
    for (std::int64_t number = 0;; ++number) {
        RawFrame frame;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
            if (waiting_.empty()) return;
            frame = std::move(waiting_.front());
            waiting_.pop_front();
            changed_.notify_all();
        }
        frame.number = number;
        frame.time_ns = described_.scene.rate.time_ns(number);
        auto written = writer_->write(frame);
        const std::lock_guard lock(mutex_);
        if (written.ok()) ++written_;
        if (written.ok() && !writer_->is_full()) continue;
        is_broken_ = !written.ok();
        failure_ = is_broken_ ? written.error() : input_error(file_.string() + ": the disk is full");
        waiting_.clear();
        changed_.notify_all();
        return;
    }
}

std::optional<Error> CameraCapture::fault() const {
    const std::lock_guard lock(mutex_);
    return failure_;
}

void CameraCapture::give_up(const Error& why) {
    const std::lock_guard lock(mutex_);
    failure_ = why;
    waiting_.clear();
}

void CameraCapture::stop() {
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
        changed_.notify_all();
    }
    if (thread_.joinable()) thread_.join();
}

Result<void> CameraCapture::finish() {
    stop();
    if (failure_) frames_.resize(is_broken_ ? 0 : written_);
    if (failure_ && frames_.empty()) return {};
    return writer_ ? writer_->finish() : Result<void>();
}

std::filesystem::path film_beside(std::filesystem::path record, int part) {
    if (part > 1) record += '.' + std::to_string(part);
    record += ".mkv";
    return record;
}

std::unique_ptr<ClipReader> with_film(std::unique_ptr<ClipReader> camera,
                                      std::shared_ptr<CameraCapture> film) {
    return std::make_unique<KeptCamera>(std::move(camera), std::move(film));
}

Result<std::unique_ptr<ClipReader>> make_filmed_camera(std::unique_ptr<ClipReader> film,
                                                       CapturedFrames frames,
                                                       const std::filesystem::path& file) {
    const auto count = film->frame_count();
    if (count && *count != std::ssize(frames))
        return input_error(file.string() + ": has " + std::to_string(*count) + " frames, the camera gave " +
                           std::to_string(frames.size()) + ": it is not the film of that recording");
    return std::unique_ptr<ClipReader>(std::make_unique<CapturedCamera>(std::move(film), std::move(frames)));
}

}  // namespace touchable
