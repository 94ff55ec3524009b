#pragma once

// Cameras that are there now, as live sources.
//
// A PluggedChoice names one: a V4L2 node, a program that sends framesets by a pipe or a connection
// (docs/streaming.md), or a stream. open_plugged_camera opens it as a ClipReader whose frames have the times
// at which they were taken. SharedCamera is one camera for several runs of a window, one after the other: it
// stays open while the next run is made ready. cameras_in_words lists what is plugged in, for a person.
//
// A reader is read by one thread. A SharedCamera's readers may be on different threads.

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>

#include "engine/base/result.hpp"
#include "engine/camera/frameset_camera.hpp"
#include "engine/camera/v4l2_camera.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/stream/receiving.hpp"

namespace touchable {

/// The lines of a program on how to touch a camera by its name, such as "v4l2:/dev/video0", and by the name
/// with which its colour is seen as well; empty: it has none.
using HowToTouch = std::function<std::string(const std::string& camera, const std::string& with_colour)>;

/// For a person: each camera that is plugged in, what it offers, how it is touched, and what is missing where
/// it cannot be. Lines; with no camera one, which says what to do.
std::string cameras_in_words(VideoSystem& system, const HowToTouch& how);

/// A camera that is there now, or a stream, by whom its frames come.
using PluggedChoice = std::variant<V4l2Choice, FramesetChoice, StreamSource>;

/// As a person names it: its node, "pipe:CMD", "tcp://HOST:PORT", a stream's address.
std::string name_of(const PluggedChoice& choice);

/// As `open_v4l2_camera`, `open_frameset_camera` and `open_live_stream`, which says itself what its depth
/// means.
Result<std::unique_ptr<ClipReader>> open_plugged_camera(
    const PluggedChoice& choice, const std::optional<SourceDescription>& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

/// One camera for several runs, one after the other: while one goes on the next is made ready with frames
/// that the camera gave to the first, for a camera has but one stream. The camera stays open until the last
/// reader is gone.
class SharedCamera : public std::enable_shared_from_this<SharedCamera> {
public:
    /// The first opens the camera as `open_plugged_camera` does. Until its run begins, every later one has
    /// the newest frame of the run that goes on; its own may begin once that has ended.
    Result<std::unique_ptr<ClipReader>> open(const PluggedChoice& choice,
                                             const std::optional<SourceDescription>& known = {},
                                             const std::optional<std::filesystem::path>& scene_file = {});

private:
    class Reader;
    Result<std::optional<RawFrame>> read();
    Result<RawFrame> newest();

    std::unique_ptr<ClipReader> camera_;
    std::mutex mutex_;
    std::condition_variable came_;
    std::optional<RawFrame> newest_;  // guarded by mutex_
    std::int64_t next_number_ = 0;    // of the camera; of the thread that reads
};

}  // namespace touchable
