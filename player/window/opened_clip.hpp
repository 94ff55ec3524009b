// SPDX-License-Identifier: Apache-2.0
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
#include "player/session/clip_choice.hpp"
#include "player/session/watched_session.hpp"
#include "player/view/pointer.hpp"
#include "player/window/play_window.hpp"
#include "player/window/session_settings.hpp"

namespace touchable {

/// The fingers of a moment for a picture, with their paths since they last touched.
class FingerTrails {
public:
    /// Once a picture. Hides fingers from `count` on, those without a position, and those that hover nearer
    /// to the clip's camera than this share of the distance to the surface.
    std::vector<FingerMark> marks(const WatchedTick& tick, int count, const HeightField& field,
                                  double nearest_share = 0.5);

private:
    struct Place {
        std::int64_t tick;
        glm::dvec2 pixel;  // of the clip, so that a moving surface carries it along
    };
    std::vector<std::deque<Place>> trails_;
};

/// The figures of the newest session, with the counts of earlier ones.
WatchedFigures with_counts_of(const WatchedFigures& earlier, WatchedFigures newest);

/// A clip in the window: its session, the pointer or haptic device that touches it, and its view.
class OpenedClip {
public:
    /// Opens `clip` with `options`, which must outlive it, and these settings; ready for `begin`. `sound`
    /// must outlive it too. Slow; any thread.
    static Result<std::unique_ptr<OpenedClip>> open(const PlayOptions& options, const ClipChoice& clip,
                                                    const SessionSettings& settings, WindowSound& sound);
    /// Begins its session, and a recording if requested. Once, after any other clip has ended.
    Result<void> begin();
    /// Whether the session soon accepts no more commands: a change to the same settings begins another.
    bool is_nearly_full() const { return session_->commands() > WatchedSession::most_commands * 15 / 16; }
    /// Call once no other clip's sound plays.
    void begin_sound() {
        if (!clip_.is_camera()) sound_.open_clip(sound_file_of(session_->setup().feed->reader()));
        begin_listening();
    }

    /// The same clip with other settings or materials, prepared for the change.
    struct Change {
        SessionSettings settings;
        std::shared_ptr<const PaintedSegments> painted;
        std::unique_ptr<TouchSetup> setup;
        PlaybackState state;          // the clip's when begin_ns was chosen
        std::int64_t begin_ns = 0;    // the clip's time where it begins
        std::int64_t reading_ns = 0;  // time taken to read its first frames
    };
    /// Slow; any thread, while the session continues unchanged. Fails mostly (ErrorKind::usage) because the
    /// clip does not support the settings.
    Result<Change> prepare(const SessionSettings& settings,
                           std::shared_ptr<const PaintedSegments> painted) const;
    /// Whether the playing clip has reached the change's start, or never will.
    bool has_come_to(const Change& change) const;
    /// Ends the session, and begins another one with those settings at the current moment, speed and loop.
    /// Fingers stay in place, and their forces return by the guard's ramp; those of a haptic device once they
    /// have been free. A recording gets another part.
    Result<void> take(Change change);

    WatchedSession& session() { return *session_; }
    const WatchedSession& session() const { return *session_; }
    const std::shared_ptr<PointerDevice>& device() const { return device_; }
    PointerFingers& fingers() { return *fingers_; }
    const PointerFingers& fingers() const { return *fingers_; }
    /// The device that moves the fingers; null: the pointer does.
    const PersistentDevice* hand() const { return options_.hand.get(); }
    /// Number of fingers to show.
    int shown() const { return options_.hand ? options_.hand->fingers() : fingers_->shown(); }
    /// The haptic device's view in the session; null without a device.
    HandControl* control() const { return control_; }
    void set_force(bool on) {
        if (control_)
            control_->ask_force(on);
        else
            device_->set_force(on);
    }
    bool force_is_on() const { return control_ ? control_->force_is_asked() : device_->force_is_on(); }
    FingerTrails& trails() { return trails_; }
    /// Adds the surface under fingers, and if `dented`, its displacement, and drops error bars that do not
    /// hold: for pictures only.
    void put_on_surface(std::span<FingerMark> marks, const WatchedTick& felt, const HeightField& field,
                        bool dented) const;
    /// error_bars_hold; false where depth was not measured.
    bool error_bars_hold_at(double depth) const {
        return depth <= error_bars_to(clip_.measured, scene_->filter);
    }
    WindowView& view() { return *view_; }
    const WindowView& view() const { return *view_; }
    const Scene& scene() const { return *scene_; }
    const MarkSizes& sizes() const { return sizes_; }
    const std::string& name() const { return name_; }
    /// The current settings; their values in effect in the clip; its filters, each with the reason.
    const SessionSettings& settings() const { return settings_; }
    /// Its segments' materials, unless the settings say otherwise; null: the clip's own.
    const std::shared_ptr<const PaintedSegments>& painted() const { return clip_.painted; }
    const ClipChoice& choice() const { return clip_; }
    const std::map<std::string, std::string>& in_effect() const { return in_effect_; }
    const std::string& filters() const { return filters_; }
    /// Why this builder makes the surface; empty: it was requested.
    const std::string& builder_why() const { return builder_why_; }
    /// Remarks for the user on its camera's run, such as that it was unplugged.
    std::vector<std::string> remarks() const { return session_->remarks(); }
    /// Times of its cuts found so far, seconds.
    std::vector<double> cuts() const;
    bool is_still() const { return frames_ == 1; }
    bool is_camera() const { return clip_.is_camera(); }
    std::int64_t frames() const { return frames_; }  ///< 0 if unknown
    double seconds() const { return static_cast<double>(scene_->rate.time_ns(frames_)) * 1e-9; }
    /// Sum over its sessions.
    WatchedFigures figures() const { return session_ ? with_counts_of(ended_, session_->figures()) : ended_; }
    /// Ends the session, and completes its recording.
    Result<void> finish();
    /// Why the first session ended by itself, lost ticks, or its clip broke off; known once a session has
    /// ended.
    const std::optional<Error>& failure() const { return failure_; }
    /// Why the recording gets no more ticks; nullopt: it does, or there is none.
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
    Result<void> open_film(TouchSetup& setup);
    Result<void> finish_film();
    MarkSizes sizes_for(double max_newtons) const;
    int fingers_of_hand() const { return options_.hand ? options_.hand->fingers() : PointerFingers::most; }

    /// `--record`, and the hash that a replay of the part's forces must match.
    class Record final : public TouchSink {
    public:
        explicit Record(std::unique_ptr<RecordingFile> to) : file(std::move(to)) { hash.emplace(); }
        Result<void> consume(const TouchTick& tick) override;
        std::unique_ptr<RecordingFile> file;
        std::optional<ForceHash> hash;
    };
    const PlayOptions& options_;
    ClipChoice clip_;
    WindowSound& sound_;
    SessionSettings settings_;
    std::map<std::string, std::string> in_effect_;
    std::string name_, filters_, builder_why_;
    std::set<std::int64_t> cuts_;  // frames, from earlier sessions
    std::int64_t frames_ = 0;
    int films_ = 0;                  // of a recorded camera
    bool film_is_given_up_ = false;  // the newest film: its recording had ended before
    std::shared_ptr<PointerDevice> device_;
    HandControl* control_ = nullptr;      // the session's
    std::optional<Scene> scene_;
    Workspace workspace_;  // before the hand scale: the same for all settings, so that they compare
    std::unique_ptr<Record> record_;
    std::optional<TouchListener> listener_;
    std::optional<PointerFingers> fingers_;
    std::optional<WindowView> view_;
    FingerTrails trails_;
    glm::dvec3 middle_{0.0};  // of the initially visible scene
    MarkSizes sizes_{};
    std::unique_ptr<TouchSetup> ready_;  // until `begin`
    WatchedFigures ended_;               // figures of earlier sessions
    std::optional<Error> failure_;
    std::int64_t reading_ns_ = 30'000'000;     // estimate for the first frames after a change
    std::unique_ptr<WatchedSession> session_;  // ends before the data it uses
};

}  // namespace touchable
