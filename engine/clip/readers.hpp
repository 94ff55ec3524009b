#pragma once

// What readers of clips are made of: readers around a reader, and the parts of a live one.
//
// A reader around another one takes it over and is itself a clip: a part of it, with planes that stay the
// same under every frame, with a far plane that was found in its frames, with depth of one scale, or as a
// camera would give it. part_of_clip, with_far_plane and with_aligned_depth hand the clip on unchanged
// where nothing is to be done; a class of another module derives from ReaderAround and overrides what it
// changes. Prefetch keeps the first frames that it read (up to 512 MiB), so that they are not decoded twice.
//
// A live reader has a CameraRun, which numbers and times its frames and knows when to stop, and a Wake, which
// ends a wait by poll.
//
// As every reader, each is used by one thread at a time; what may be called from any thread says so.

#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <span>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"

namespace touchable {

/// A reader around another one, which it is like but for what a class derived from this changes.
class ReaderAround : public ClipReader {
public:
    const Scene& scene() const override { return reader_->scene(); }
    UnstatedFilters unstated_filters() const override { return reader_->unstated_filters(); }
    const std::vector<TrackInfo>& tracks() const override { return reader_->tracks(); }
    std::optional<std::int64_t> frame_count() const override { return reader_->frame_count(); }
    const std::vector<std::string>& notes() const override { return reader_->notes(); }
    std::span<const Camera> frame_cameras() const override { return reader_->frame_cameras(); }
    Result<std::optional<RawFrame>> next() override { return reader_->next(); }
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override { return reader_->seek(frame); }
    std::int64_t access_point(std::int64_t frame) const override { return reader_->access_point(frame); }
    void leave_out_colour() override { reader_->leave_out_colour(); }
    bool is_live() const override { return reader_->is_live(); }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override { return reader_->begin(zero); }
    void interrupt() override { reader_->interrupt(); }
    std::int64_t taken_before(std::int64_t frame) const override { return reader_->taken_before(frame); }
    std::optional<std::int64_t> taken_at(std::int64_t frame) const override {
        return reader_->taken_at(frame);
    }
    std::vector<std::string> remarks() const override { return reader_->remarks(); }
    std::optional<StreamFigures> stream_figures() const override { return reader_->stream_figures(); }

protected:
    explicit ReaderAround(std::unique_ptr<ClipReader> reader) : reader_(std::move(reader)) {
        for (const auto& input : reader_->inputs()) add_input(input);
    }
    ClipReader& inner() { return *reader_; }

private:
    std::unique_ptr<ClipReader> reader_;
};

/// Which frames and pixels of a clip.
struct ClipPart {
    /// Columns x to x + width - 1, rows y to y + height - 1.
    struct Crop {
        int x = 0, y = 0, width = 0, height = 0;
    };

    std::int64_t first = 0;
    std::optional<std::int64_t> last{};  ///< inclusive; nothing: the clip's last
    std::int64_t every = 1;              ///< the first, and then each so many frames later
    std::optional<Crop> crop{};

    bool is_whole() const { return first == 0 && !last && every == 1 && !crop; }
};

/// A reader of a part of a clip, as a clip: its frames are numbered from 0, at the rate that is left of the
/// clip's; where it is cropped the camera's principal point moves, so that every pixel that is left stays
/// where it was in the world. Refused (ErrorKind::usage) where the clip has no such frame or pixel.
Result<std::unique_ptr<ClipReader>> part_of_clip(std::unique_ptr<ClipReader> clip, const ClipPart& part);

/// A picture that serves all frames of a clip.
struct StillPlane {
    PlaneRole role = PlaneRole::haptic;
    Plane plane;                                 ///< of any size: as stored, or resampled already
    TrackInfo info;                              ///< how it is stored
    std::vector<std::filesystem::path> files{};  ///< that it was read from, the one that was named first
    std::vector<std::string> notes{};
    /// Where it changes: the plane in a frame, which fits the scene, by its number and time.
    std::function<Result<Plane>(std::int64_t frame, std::int64_t time_ns)> at{};
};

/// The clip with these planes under every frame, in place of its own of their roles. `scene` is the clip's
/// but for what the planes mean: haptic ranges, height coding and what makes room for heights. Refused where
/// that cannot be, or a plane does not fit it.
Result<std::unique_ptr<ClipReader>> with_still_planes(std::unique_ptr<ClipReader> clip,
                                                      std::vector<StillPlane> planes, const Scene& scene);

/// A clip of which the next frames, so far its first ones, were read already: `next` gives them before it
/// reads on.
std::unique_ptr<ClipReader> with_prefetched_frames(std::unique_ptr<ClipReader> clip,
                                                   std::vector<RawFrame> frames);

/// Looks ahead in a clip that is at its beginning, and keeps its first frames for when it is played.
class Prefetch {
public:
    explicit Prefetch(std::unique_ptr<ClipReader> clip) : clip_(std::move(clip)) {}

    /// The next of the first frames.
    Result<std::optional<RawFrame>> next();
    /// A later one, which is not kept. After it no `next`.
    Result<std::optional<RawFrame>> at(std::int64_t frame);
    const ClipReader& clip() const { return *clip_; }
    /// The clip, at its beginning again. Once.
    Result<std::unique_ptr<ClipReader>> finish();

private:
    static constexpr std::size_t most_bytes = std::size_t{512} << 20;  // 25 frames of 1920x1080, all planes

    std::unique_ptr<ClipReader> clip_;
    std::vector<RawFrame> frames_;  // empty where they took too much memory
    std::size_t bytes_ = 0;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool has_moved_ = false, is_damaged_ = false;
};

/// The frames of a clip that tell what is to be known of all of them: the first ones, and as many more that
/// are spread over the rest. However long a clip is, to know it takes no longer.
inline constexpr std::int64_t first_frames = 16, spread_frames = 16;
/// Their numbers, ascending, in a clip of `count` frames of which each can be read on its own.
std::vector<std::int64_t> telling_frames(std::int64_t count);

/// A clip at its beginning. Where its description leaves the far plane open
/// (SceneDescription::Unstated::far), so that it is the deepest code's so far, it is settled, and a note says
/// it; otherwise the clip is unchanged. The far plane is 5 % beyond the depth that at most one valid pixel in
/// 10 000 exceeds, in the frames that tell (telling_frames); of a clip that cannot seek, the first ones. What
/// lies beyond it is invalid. A later frame that is damaged tells nothing: the error comes when it is played.
/// An error where no depth is valid. Errors name `file`.
Result<std::unique_ptr<ClipReader>> with_far_plane(std::unique_ptr<ClipReader> clip, bool far_is_open,
                                                   const std::filesystem::path& file);

/// Whether depth without a scale gets one for all frames. Automatic: where it pumps, which some frames tell.
enum class DepthAlignment { automatic, on, off };

/// The clip with codes of one scale for all frames, of 16 bits: near and far are those of the whole clip.
/// All its frames are read once before, so that a frame is the same whichever frames were read before it;
/// where depth does not pump (automatic), and of a clip of one frame, it is the clip as it was. A note says
/// how far what stands still moved, before and after. Refused (`on`) where codes are not evenly spaced in
/// depth or in 1 / depth. The clip is at its beginning, before and after, with its colour.
Result<std::unique_ptr<ClipReader>> with_aligned_depth(std::unique_ptr<ClipReader> clip,
                                                       DepthAlignment wanted);

/// A frame as some thousand cells, in which noise is averaged out: 640x480 pixels are 80x60.
struct CellPicture {
    static constexpr std::int32_t per_code = 16, per_level = 16;
    static constexpr std::int32_t none = -1;
    /// A square of pixels.
    struct Cell {
        /// Mean code, sixteenths; none: of two surfaces, or with a pixel without depth.
        std::int32_t depth = none;
        std::int32_t luma = none;  ///< mean brightness, sixteenths of 255 levels; none: without colour
        bool is_textured = false;  ///< its brightness tells whether what is there moves
    };

    std::vector<Cell> cells;
    bool has_colour = false;
    std::uint16_t least = 0, most = 0;  ///< valid codes; 0 and 0 where there are none
};
CellPicture cell_picture(const RawFrame& frame, const DepthCoding& coding);

/// Ends a wait by poll, from any thread; its descriptor is -1 where the system has none left.
class Wake {
public:
    Wake() : descriptor_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
    ~Wake() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    Wake(const Wake&) = delete;
    Wake& operator=(const Wake&) = delete;
    int descriptor() const { return descriptor_; }
    void forget() const {
        eventfd_t ignored = 0;
        (void)!::eventfd_read(descriptor_, &ignored);
    }
    void wake() const { (void)!::eventfd_write(descriptor_, 1); }

private:
    int descriptor_;
};

/// Frames of before a run are so far apart.
inline constexpr std::int64_t ns_before_a_run = 1000;

/// What every camera's run has: the numbers and times of its frames, before it and in it; how a wait is
/// ended; whether the camera is gone, and what a person should know. One thread, but where it says so.
class CameraRun {
public:
    /// `name`: of the camera, in messages; `kind`: what these call it, where it is no camera.
    explicit CameraRun(std::string name, std::string kind = "camera")
        : name_(std::move(name)), kind_(std::move(kind)) {}

    bool has_begun() const { return zero_ns_.has_value(); }
    /// Frames count from here on; once more after a run that has ended.
    void begin(std::chrono::steady_clock::time_point zero);
    /// Before a run: the number of the frame that comes next.
    Result<void> seek(std::int64_t frame);

    struct Place {
        std::int64_t number = 0, time_ns = 0;
    };
    /// Of the frame that came next, by the camera's count and the time of std::chrono::steady_clock at which
    /// it was taken. In a run the count tells what was left out; where it stands still, or has begun anew,
    /// the next number. Nothing: it was taken before the run.
    std::optional<Place> place(std::uint32_t count, std::int64_t at_ns);

    /// From any thread.
    void interrupt();
    /// For poll: readable once a wait is to end.
    int descriptor() const { return wake_.descriptor(); }
    /// An error of kind interrupted where a wait is to end: in a run after `interrupt`, and before one also
    /// after a signal.
    std::optional<Error> told_to_end() const;

    void gone(const std::string& why);
    bool is_gone() const { return is_gone_; }
    void remark(std::string words);
    /// From any thread.
    std::vector<std::string> remarks() const;

private:
    const std::string name_, kind_;
    Wake wake_;
    std::atomic<bool> interrupted_{false};
    bool is_gone_ = false;
    std::int64_t next_number_ = 0;
    std::optional<std::uint32_t> last_count_;  // of a frame of the run
    std::optional<std::int64_t> zero_ns_;
    std::int64_t last_time_ns_ = -1;
    mutable std::mutex mutex_;
    std::vector<std::string> remarks_;  // guarded by mutex_
};

/// How a camera delivers what it takes. Moments are those of a run, ns.
struct CameraDelivery {
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
    /// A frame, and when it is there.
    struct Frame {
        std::int64_t number = -1;
        std::int64_t at_ns = 0;  ///< of the run, or `never`
    };

    std::optional<FrameRate> rate{};  ///< nothing: the recording's own
    std::int64_t jitter_ns = 0;       ///< the longest time from exposure to delivery
    double drop = 0;                  ///< the share of frames that never come, 0 to below 1
    /// Nothing is delivered between; no end: never again.
    std::optional<std::int64_t> stall_ns{}, resume_ns{};

    /// What comes after `last`: the next frame that is not left out, not before its own time by the
    /// recording's rate. As random as the settings want it, and the same every time.
    Frame after(const Frame& last, const FrameRate& recorded) const;
};

/// A recording that behaves like a camera. Frame n is taken at time_ns = n / rate and comes when
/// CameraDelivery::after says. Frames keep the recording's numbers, so that those left out are gaps.
///
/// Until `begin` it is a clip: every frame is there at once. After it `next` waits for the next delivery, and
/// gives the newest frame where several were delivered before it was asked. A frame is decoded while it is
/// waited for. Frames are held and not interpolated, for none of the future exists.
std::unique_ptr<ClipReader> make_replay_camera(std::unique_ptr<ClipReader> recording,
                                               const CameraDelivery& delivery);

}  // namespace touchable
