#pragma once

#include <cstdint>
#include <deque>
#include <glm/vec2.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "device/haptic_device.hpp"
#include "engine/base/result.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/audio/window_sound.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/run/run_files.hpp"
#include "player/session/touch_setup.hpp"
#include "player/window/play_window.hpp"
#include "player/window/pointer.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {

/// The fingers of a moment as a picture shows them, with the ways they went since they last touched.
class FingerTrails {
public:
    /// Once a picture. Fingers from `count` on are not shown, nor one whose place is unknown, nor one that
    /// touches nothing and is nearer to the clip's camera than this share of the way to the surface.
    std::vector<FingerMark> marks(const WatchedTick& tick, int count, const HeightField& field,
                                  double nearest_share = 0.5);

private:
    struct Place {
        std::int64_t tick;
        glm::dvec2 pixel;  // of the clip, which a surface that moves carries along
    };
    std::vector<std::deque<Place>> trails_;
};

/// A clip in the window: its session, the pointer or the held device that touches it, and from where it is
/// seen.
class OpenedClip {
public:
    /// As `options` say, which outlive it, over `clip` and by these settings; ready to be begun. `sound`
    /// outlives it too. Takes long; on any thread.
    static Result<std::unique_ptr<OpenedClip>> open(const PlayOptions& options, const ClipChoice& clip,
                                                    const SessionSettings& settings, WindowSound& sound);
    /// Begins its session, and a recording of it where one is asked for. Once, when no other clip runs any
    /// more.
    Result<void> begin();
    /// Whether the session will soon take no more commands: a change to the same settings begins another one.
    bool is_nearly_full() const { return session_->commands() > WatchedSession::most_commands * 15 / 16; }
    /// Once no other clip is heard any more.
    void begin_sound() {
        if (!clip_.is_camera()) sound_.open_clip(sound_file_of(session_->setup().feed->reader()));
        begin_listening();
    }

    /// The same clip by other settings, or with other materials, ready to be changed to.
    struct Change {
        SessionSettings settings;
        std::shared_ptr<const PaintedSegments> painted;
        std::unique_ptr<TouchSetup> setup;
        PlaybackState state;          // that the clip was in when its begin was chosen
        std::int64_t begin_ns = 0;    // of the clip, where it begins
        std::int64_t reading_ns = 0;  // how long its first frames took
    };
    /// Takes long; on any thread, while the session goes on and is not changed. Refused mostly
    /// (ErrorKind::usage) where the clip does not go with the settings.
    Result<Change> prepare(const SessionSettings& settings,
                           std::shared_ptr<const PaintedSegments> painted) const;
    Result<Change> prepare(const SessionSettings& settings) const { return prepare(settings, clip_.painted); }
    /// Whether the clip, as it plays, has come to where the change begins, or will not.
    bool has_come_to(const Change& change) const;
    /// Ends the session, and begins another one by those settings at the moment, speed and loop of now.
    /// Fingers stay where they are, and their forces come by the guard's ramp; those of a held device once
    /// they have been free. In a recording it is another part.
    Result<void> take(Change change);

    WatchedSession& session() { return *session_; }
    const WatchedSession& session() const { return *session_; }
    PointerDevice& device() { return *device_; }
    std::shared_ptr<PointerDevice> shared_device() const { return device_; }
    PointerFingers& fingers() { return *fingers_; }
    const PointerFingers& fingers() const { return *fingers_; }
    /// That leads the fingers; null: the pointer does.
    const PersistentDevice* hand() const { return options_.hand.get(); }
    /// How many fingers are to be seen.
    int shown() const { return options_.hand ? options_.hand->fingers() : fingers_->shown(); }
    /// That device's view in the session; null without a device.
    HandControl* control() const { return control_; }
    void set_force(bool on) {
        if (control_)
            control_->ask_force(on);
        else
            device_->set_force(on);
    }
    bool force_is_on() const { return control_ ? control_->force_is_asked() : device_->force_is_on(); }
    FingerTrails& trails() { return trails_; }
    /// What the surface is under fingers, and if it is `dented`, how far it gives way: for pictures alone.
    void put_on_surface(std::span<FingerMark> marks, const WatchedTick& felt, const HeightField& field,
                        bool dented) const;
    WindowView& view() { return *view_; }
    const WindowView& view() const { return *view_; }
    const Scene& scene() const { return *scene_; }
    const MarkSizes& sizes() const { return sizes_; }
    const std::string& name() const { return name_; }
    /// Those that it was opened with or changed to; what they make of the clip; and its filters, each with
    /// the reason.
    const SessionSettings& settings() const { return settings_; }
    /// What its segments feel like where these settings do not say otherwise; null: as the clip says.
    const std::shared_ptr<const PaintedSegments>& painted() const { return clip_.painted; }
    const ClipChoice& choice() const { return clip_; }
    const std::map<std::string, std::string>& in_effect() const { return in_effect_; }
    const std::string& filters() const { return filters_; }
    /// Why this builder makes the surface; empty: it was asked for.
    const std::string& builder_why() const { return builder_why_; }
    /// What a person should know of its camera's run, such as that it was unplugged.
    std::vector<std::string> remarks() const { return session_->remarks(); }
    /// Moments of its cuts that have come by so far, seconds.
    std::vector<double> cuts() const;
    bool is_still() const { return frames_ == 1; }
    bool is_camera() const { return clip_.is_camera(); }
    std::int64_t frames() const { return frames_; }  ///< 0 where it is not known
    double seconds() const { return static_cast<double>(scene_->rate.time_ns(frames_)) * 1e-9; }
    const PointerDevice& device() const { return *device_; }
    /// Of all its sessions.
    WatchedFigures figures() const;
    /// Ends the session, and completes its recording.
    Result<void> finish();
    /// Why the first of its sessions that ended by itself did, or lost ticks, or its clip broke off; known of
    /// each once it has ended.
    const std::optional<Error>& failure() const { return failure_; }
    /// Why the recording gets no more ticks; nothing where it does, or there is none.
    std::optional<Error> record_fault() const;

private:
    OpenedClip(const PlayOptions& options, const ClipChoice& clip, WindowSound& sound);
    SessionOptions session_options(const SessionSettings& settings,
                                   std::shared_ptr<const PaintedSegments> painted) const;
    Result<void> make_ready(const SessionSettings& settings);
    bool goes_on_to(const Change& change, const PlaybackState& now) const;
    std::vector<PlaybackCommand> choose_begin(Change& change, std::int64_t reading_ns) const;
    bool is_left_behind(const Change& change) const;
    void take_over(const TouchSetup& setup, const SessionSettings& settings);
    Result<void> start_session(std::unique_ptr<TouchSetup> setup);
    void end_session() {
        session_->stop();
        if (!failure_) failure_ = session_->failure();
    }
    void begin_listening() {
        listener_->begin(session_->clock(), frames_ > 0 ? scene_->rate.time_ns(frames_) : latest_moment_ns);
    }
    void lead_from(const Change& change, const PlaybackState& to);
    nlohmann::ordered_json facts_of_part() const;
    Result<void> open_film(TouchSetup& setup);
    Result<void> finish_film();
    MarkSizes sizes_for(double max_newtons) const;
    int fingers_of_hand() const { return options_.hand ? options_.hand->fingers() : PointerFingers::most; }

    /// `--record`, and the hash that the forces of a part must have again.
    class Record final : public TouchSink {
    public:
        explicit Record(std::unique_ptr<RecordingFile> to) : file(std::move(to)) { hash.emplace(); }
        Result<void> take(const TouchTick& tick) override;
        std::unique_ptr<RecordingFile> file;
        std::optional<ForceHash> hash;
    };
    const PlayOptions& options_;
    ClipChoice clip_;
    WindowSound& sound_;
    SessionSettings settings_;
    std::map<std::string, std::string> in_effect_;
    std::string name_, filters_, builder_why_;
    std::set<std::int64_t> cuts_;  // frames, of sessions before this one
    std::int64_t frames_ = 0;
    int films_ = 0;                  // of a camera that is recorded
    bool film_is_given_up_ = false;  // the newest: its recording had ended before
    std::shared_ptr<PointerDevice> device_;
    std::shared_ptr<HapticDevice> held_;  // the same, for sessions that come and go
    HandControl* control_ = nullptr;      // the session's
    std::optional<Scene> scene_;
    Workspace workspace_;  // before the scale of a hand: the same for all settings, so that they compare
    std::unique_ptr<Record> record_;
    std::optional<TouchListener> listener_;
    std::optional<PointerFingers> fingers_;
    std::optional<WindowView> view_;
    FingerTrails trails_;
    glm::dvec3 middle_{0.0};  // of what is seen, at first
    MarkSizes sizes_{};
    std::unique_ptr<TouchSetup> ready_;  // until it is begun
    WatchedFigures ended_;               // of the sessions before
    std::optional<Error> failure_;
    std::int64_t reading_ns_ = 30'000'000;     // of the clip's first frames after a change, as far as known
    std::unique_ptr<WatchedSession> session_;  // ends before what it works on
};

/// What a person does to the time of the clip in the window. Errors (ErrorKind::usage) are what the clip's
/// clock refuses.
class PlaybackControl {
public:
    static constexpr double slowest = 0.1, fastest = 4;  ///< times the clip's own speed

    /// `clip` outlives it.
    explicit PlaybackControl(OpenedClip& clip) : clip_(&clip) {}

    /// From the end it plays again from the beginning.
    Result<void> play_or_pause();
    Result<void> pause(bool on) { return ask(on ? PlaybackVerb::pause : PlaybackVerb::play); }
    void seek_to(double seconds);
    void seek_by(double seconds) {
        const std::int64_t from = wanted_ns_.value_or(clip_->session().playback().moment.time_ns);
        seek_to(static_cast<double>(from) * 1e-9 + seconds);
    }
    /// A frame on, or back where `frames` is below 0; and pause.
    Result<void> step(double frames);
    /// Kept within slowest and fastest.
    Result<void> set_speed(double times) {
        return ask(PlaybackVerb::rate, std::lround(std::clamp(times, slowest, fastest) * 1000));
    }
    Result<void> change_speed(double factor) {
        return set_speed(factor * static_cast<double>(clip_->session().playback().rate) / 1000);
    }
    /// As the clip began: by the commands that it was given at first, and playing; `loops`: at least the
    /// whole of it, if it is long enough.
    Result<void> begin_anew(std::span<const PlaybackCommand> first, bool loops);
    /// From the beginning again at the end, or not.
    Result<void> toggle_loop();
    /// Once a turn of the window: goes to where it is to go, one place after the other. So a person who drags
    /// the seek bar sees every place that there is time for, and in the end the last. `moment`: what is seen
    /// now.
    Result<void> go_on(const WatchedMoment* moment);

private:
    Result<void> ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0) {
        return clip_->session().ask(verb, first, second);
    }

    OpenedClip* clip_;
    std::optional<std::int64_t> wanted_ns_;  // of the clip, to be gone to
};

}  // namespace touchable
