#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// A frame that a camera gave.
struct CapturedFrame {
    std::int64_t number = 0, time_ns = 0;
    bool operator==(const CapturedFrame&) const = default;
};
using CapturedFrames = std::vector<CapturedFrame>;

/// Keeps what a camera gave as a clip, so that what was felt can be repeated without it: frame n of the clip
/// is the n-th that was given. Depth keeps every value. It is written by a thread of its own. Where its disk
/// becomes full it ends there, and what is given after that is not kept.
class CameraCapture {
public:
    /// `described`: the camera.
    explicit CameraCapture(SceneDescription described) : described_(std::move(described)) {}
    ~CameraCapture();  ///< without `finish` nothing is left behind
    CameraCapture(const CameraCapture&) = delete;
    CameraCapture& operator=(const CameraCapture&) = delete;

    /// Where it goes, and that of frames that were kept before. Once.
    Result<void> open(const std::filesystem::path& file, Existing existing);
    /// By the thread that reads. Waits while the disk is far behind; the camera's frames meanwhile are lost.
    Result<void> keep(const RawFrame& frame);
    /// Any thread: `keep` waits no more.
    void interrupt();
    /// Why it gets no more frames; any thread.
    std::optional<Error> fault() const;
    /// In place of `open`: nothing is kept.
    void give_up(const Error& why);
    /// Completes it, once no more is kept. Where it has a fault there may be none, without any frame.
    Result<void> finish();

    const std::filesystem::path& file() const { return file_; }
    /// All that were kept; once it is finished.
    const CapturedFrames& frames() const { return frames_; }
    /// Of them the last one's number; -1: there is none.
    std::int64_t last_frame() const { return frames_.empty() ? -1 : frames_.back().number; }

private:
    void write();
    void stop();

    const SceneDescription described_;
    std::filesystem::path file_;
    CapturedFrames frames_;
    std::unique_ptr<ClipWriter> writer_;
    std::thread thread_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<RawFrame> waiting_;  // guarded by mutex_, as are those below
    bool open_ = false, ended_ = false, interrupted_ = false;
    std::optional<Error> failure_;
    std::size_t written_ = 0;  // frames
    bool is_broken_ = false;   // by the failure: it cannot be completed
};

/// Where the film of a recording's first, second ... part is: beside it, "run.rec.mkv", "run.rec.2.mkv".
std::filesystem::path film_beside(std::filesystem::path record, int part = 1);

/// A camera whose frames are kept as they are given.
std::unique_ptr<ClipReader> with_film(std::unique_ptr<ClipReader> camera,
                                      std::shared_ptr<CameraCapture> film);

/// A film in place of its camera: its frames have the camera's numbers and times. `file`: as messages call
/// it.
Result<std::unique_ptr<ClipReader>> make_filmed_camera(std::unique_ptr<ClipReader> film,
                                                       CapturedFrames frames,
                                                       const std::filesystem::path& file);

}  // namespace touchable
