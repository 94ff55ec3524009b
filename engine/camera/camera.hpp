// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras and streams that are live now, as live sources.
//
// A PluggedChoice names a source: a V4L2 node, a program that sends framesets by a pipe or a connection
// (docs/streaming.md), or a stream. open_plugged_camera opens it as a ClipReader whose frames have the times
// at which they were taken. SharedCamera is one camera for several runs of a window, one after the other: it
// stays open while the next run is made ready. cameras_in_words lists what is plugged in, for the user.
//
// Threads: one uses a reader; a SharedCamera's readers may be on different ones.

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

/// Returns a program's lines on how to touch a camera, by its name, such as "v4l2:/dev/video0", and by its
/// name with colour; empty: it has no colour.
using HowToTouch = std::function<std::string(const std::string& camera, const std::string& with_colour)>;

/// Lines for the user: each camera that is plugged in, what it offers, how to touch it, and what is missing
/// if that is impossible. Without a camera, one line says what to do.
std::string cameras_in_words(VideoSystem& system, const HowToTouch& how);

/// The same for programs: {"touchable_cameras": 1, "cameras": [{"node", "card", "driver", "bus", "formats":
/// [{"code", "is_depth", "modes": ["640x480 at 30 frames/s", ...]}, ...]}, ...]}; a node that cannot be
/// opened has "why_not" beside "node".
std::string cameras_in_json(VideoSystem& system);

/// A camera or a stream, by the origin of its frames.
using PluggedChoice = std::variant<V4l2Choice, FramesetChoice, StreamSource>;

/// The user's name for it: its node, "pipe:CMD", "tcp://HOST:PORT", a stream's address.
std::string name_of(const PluggedChoice& choice);

/// Calls `open_v4l2_camera`, `open_frameset_camera` or `open_live_stream`; a stream itself states what its
/// depth means.
Result<std::unique_ptr<ClipReader>> open_plugged_camera(
    const PluggedChoice& choice, const SourceDescription& known = {},
    const std::optional<std::filesystem::path>& scene_file = {});

/// One camera for several runs, one after the other: as a camera has only one stream, the next run is
/// prepared with frames of the current one. The camera stays open until the last reader is destroyed.
class SharedCamera : public std::enable_shared_from_this<SharedCamera> {
public:
    /// The first call opens the camera as `open_plugged_camera` does. Until its run begins, a later reader
    /// returns the newest frame of the current run; its own may begin once that has ended.
    Result<std::unique_ptr<ClipReader>> open(const PluggedChoice& choice, const SourceDescription& known = {},
                                             const std::optional<std::filesystem::path>& scene_file = {});

private:
    class Reader;
    Result<std::optional<RawFrame>> read();
    Result<RawFrame> newest();

    std::unique_ptr<ClipReader> camera_;
    std::mutex mutex_;
    std::condition_variable came_;
    std::optional<RawFrame> newest_;  // guarded by mutex_
    std::int64_t next_number_ = 0;    // of the camera; used by the reading thread
};

}  // namespace touchable
