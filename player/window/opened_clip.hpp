#pragma once

#include <memory>
#include <optional>
#include <string>

#include "device/pointer_device.hpp"
#include "haptics_cpu/force_hash.hpp"
#include "player/session/recording.hpp"
#include "player/session/watched_session.hpp"
#include "player/view/finger_marks.hpp"
#include "player/window/finger_trails.hpp"
#include "player/window/play_window.hpp"
#include "player/window/pointer_fingers.hpp"
#include "player/window/touch_listener.hpp"
#include "player/window/window_view.hpp"

namespace touchable {

/// A clip in the window: its session, the pointer that touches it, and from where it is seen.
class OpenedClip {
public:
    /// As `options` say, over `clip`; a recording of it is begun where one is asked for.
    /// `sound` outlives it, and hears it from `begin_sound` on.
    static Result<std::unique_ptr<OpenedClip>> open(const PlayOptions& options, const ClipChoice& clip,
                                                    WindowSound& sound);
    /// Once no other clip is heard any more.
    void begin_sound() { listener_->begin(); }

    WatchedSession& session() { return *session_; }
    const WatchedSession& session() const { return *session_; }
    PointerDevice& device() { return *device_; }
    PointerFingers& fingers() { return *fingers_; }
    const PointerFingers& fingers() const { return *fingers_; }
    FingerTrails& trails() { return trails_; }
    WindowView& view() { return *view_; }
    const Scene& scene() const { return *scene_; }
    const MarkSizes& sizes() const { return sizes_; }
    const std::string& name() const { return name_; }
    std::int64_t frames() const { return frames_; }  ///< 0 where nobody knows
    double seconds() const { return static_cast<double>(scene_->rate.time_ns(frames_)) * 1e-9; }
    const PointerDevice& device() const { return *device_; }
    /// Ends the session, and completes its recording.
    Result<void> finish();

private:
    OpenedClip() = default;
    Result<void> begin(const PlayOptions& options, SessionOptions session, WindowSound& sound);

    /// `--record`, and the hash that its forces must have again.
    class Record final : public TouchSink {
    public:
        explicit Record(std::unique_ptr<RecordingFile> to) : file(std::move(to)) {}
        Result<void> take(const TouchTick& tick) override;
        std::unique_ptr<RecordingFile> file;
        ForceHash hash;
    };
    std::string name_;
    std::int64_t frames_ = 0;
    std::shared_ptr<PointerDevice> device_;
    std::optional<Scene> scene_;
    std::unique_ptr<Record> record_;
    std::optional<TouchListener> listener_;
    std::optional<PointerFingers> fingers_;
    std::optional<WindowView> view_;
    FingerTrails trails_;
    MarkSizes sizes_{};
    std::unique_ptr<WatchedSession> session_;  // ends before what it works on
};

}  // namespace touchable
