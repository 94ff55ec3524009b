#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "device/pointer_device.hpp"
#include "haptics_cpu/force_hash.hpp"
#include "player/session/recording.hpp"
#include "player/session/watched_session.hpp"
#include "player/view/finger_marks.hpp"
#include "player/window/felt_settings.hpp"
#include "player/window/finger_trails.hpp"
#include "player/window/play_window.hpp"
#include "player/window/pointer_fingers.hpp"
#include "player/window/touch_listener.hpp"
#include "player/window/window_view.hpp"

namespace touchable {

/// A clip in the window: its session, the pointer that touches it, and from where it is seen.
class OpenedClip {
public:
    /// As `options` say, which outlive it, over `clip` and by these settings; a recording of it is begun
    /// where one is asked for. `sound` outlives it too, and hears it from `begin_sound` on.
    static Result<std::unique_ptr<OpenedClip>> open(const PlayOptions& options, const ClipChoice& clip,
                                                    const FeltSettings& felt, WindowSound& sound);
    /// The same clip by other settings, at the same moment, speed and loop; fingers stay where they are, and
    /// their forces come by the guard's ramp. The session is another one then. Where the clip does not go
    /// with them (ErrorKind::usage mostly) the old one goes on.
    Result<void> change(const FeltSettings& felt);
    /// Once no other clip is heard any more.
    void begin_sound();

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
    /// Those that it was opened with or changed to; what they make of the clip; and its filters, each with
    /// the reason.
    const FeltSettings& felt() const { return felt_; }
    const std::map<std::string, std::string>& in_effect() const { return in_effect_; }
    const std::string& filters() const { return filters_; }
    std::int64_t frames() const { return frames_; }  ///< 0 where nobody knows
    double seconds() const { return static_cast<double>(scene_->rate.time_ns(frames_)) * 1e-9; }
    const PointerDevice& device() const { return *device_; }
    /// Ends the session, and completes its recording.
    Result<void> finish();

private:
    OpenedClip(const PlayOptions& options, const ClipChoice& clip, WindowSound& sound);
    SessionOptions session_options(const FeltSettings& felt) const;
    Result<void> begin(const FeltSettings& felt);
    std::vector<PlaybackCommand> stand_still();
    void take_over(const TouchSetup& setup, const FeltSettings& felt);

    /// `--record`, and the hash that its forces must have again.
    class Record final : public TouchSink {
    public:
        explicit Record(std::unique_ptr<RecordingFile> to) : file(std::move(to)) {}
        Result<void> take(const TouchTick& tick) override;
        std::unique_ptr<RecordingFile> file;
        ForceHash hash;
    };
    const PlayOptions& options_;
    ClipChoice clip_;
    WindowSound& sound_;
    FeltSettings felt_;
    std::map<std::string, std::string> in_effect_;
    std::string name_, filters_;
    std::int64_t frames_ = 0;
    std::shared_ptr<PointerDevice> device_;
    std::shared_ptr<HapticDevice> held_;  // the same, for sessions that come and go
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
