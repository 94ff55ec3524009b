#pragma once

#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <map>
#include <set>
#include <span>

#include "engine/base/threads.hpp"
#include "player/audio/window_sound.hpp"
#include "player/window/clip_picture.hpp"
#include "player/window/imgui_layer.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/long_work.hpp"
#include "player/window/measure.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/play_window.hpp"
#include "player/window/pointer.hpp"
#include "player/window/screen.hpp"
#include "player/window/study.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_brush.hpp"
#include "player/window/window_files.hpp"
#include "player/window/window_panel.hpp"

namespace touchable {

/// The window's clock: std::chrono::steady_clock, which a test can put forward, so that a day of a kiosk
/// takes minutes. Sessions and their forces go by their own.
class WindowClock {
public:
    using duration = std::chrono::steady_clock::duration;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::steady_clock::time_point;
    static constexpr bool is_steady = true;

    static time_point now() {
        return std::chrono::steady_clock::now() + duration(ahead_.load(std::memory_order_relaxed));
    }
    static void put_forward(duration by) { ahead_.fetch_add(by.count(), std::memory_order_relaxed); }
    /// For how long the machine has been suspended so far, which `now` sleeps through; a test can suspend it.
    static duration slept() {
        const auto steady = std::chrono::steady_clock::now().time_since_epoch();
        return std::chrono::nanoseconds(boot_ns()) - steady +
               duration(asleep_.load(std::memory_order_relaxed));
    }
    static void suspend(duration by) { asleep_.fetch_add(by.count(), std::memory_order_relaxed); }

private:
    static inline std::atomic<rep> ahead_{0}, asleep_{0};
};

/// Tells the second of two quick presses at the same place from presses that touch.
class DoubleClick {
public:
    static constexpr double longest_s = 0.3;    ///< from press to press
    static constexpr double farthest_px = 6.0;  ///< between the two presses

    /// Whether the press of that moment, at that place, is a second one; a third is a first again.
    bool press(double now_s, const glm::dvec2& at) {
        const bool is_second =
            first_s_ && now_s - *first_s_ <= longest_s && glm::distance(at, at_) <= farthest_px;
        first_s_ = is_second ? std::nullopt : std::optional(now_s);
        at_ = at;
        return is_second;
    }
    /// What comes next belongs to no press before it.
    void forget() { first_s_.reset(); }

private:
    std::optional<double> first_s_;
    glm::dvec2 at_{0.0};
};

/// How large words, lines and bars are in a window, as ScreenSize::scale: the display's, and more where the
/// window has more room than 1280x720 of such pixels. By the root of that, because whoever has a large window
/// wants to see more in it; `from_afar`, as visitors of a kiosk look, by all of it. In steps of a quarter, so
/// that a window that is being resized seldom changes them.
double words_scale(const ScreenSize& size, bool from_afar);

/// The window of `touchable play`: its parts, and the loop that drives them.
class WindowLoop {
public:
    explicit WindowLoop(PlayOptions options) : options_(std::move(options)), asked_for_(Clock::now()) {}
    /// On every exit path the hand is unpowered before anything is waited for.
    ~WindowLoop() { power_hand_off(); }

    Result<PlayFigures> run();

private:
    using Clock = WindowClock;

    /// A and B as they are kept, and as they are in effect: without what the clip would not go with; and
    /// what a brush painted.
    struct WindowSettings {
        TwoSettings kept, in_effect;
        std::shared_ptr<const PaintedSegments> painted{};
        bool operator==(const WindowSettings&) const = default;
    };
    /// What was made ready on a thread of its own: another clip, or a change of the one that is there.
    /// Neither: none of the clips could be opened.
    struct Ready {
        std::unique_ptr<OpenedClip> clip{};
        std::optional<OpenedClip::Change> change{};
        WindowSettings settings{};     // to be in effect then
        std::string remark{};          // that something is not as it was wanted
        Playlist list{};               // in which the clip is now
        std::vector<Error> skipped{};  // why the clips before it are not open
    };

    // Begin, turns, end, what is said (window_loop.cpp).
    Result<void> open();
    Result<void> open_screen(const KeptSettings& kept);
    Result<void> open_parts();
    double scale_of_words(const ScreenSize& size) const;
    Result<void> fit_words(const ScreenSize& size);
    Result<std::unique_ptr<WindowGraphics>> make_graphics();
    Result<void> open_graphics();
    Result<void> open_graphics_anew(const Error& error);
    Result<void> turn();
    void go_on_with_clip();
    bool is_at_work() const;
    void take_script();
    double now_s() const;
    static double thread_cpu_ms();
    static double seconds_between(Clock::time_point from, Clock::time_point to) {
        return std::chrono::duration<double>(to - from).count();
    }
    void note_sound();
    void note_slow_reading();
    void note_screenshots();
    void note_files();
    Result<void> keep_picture(const std::filesystem::path& name);
    void say(std::string words, Tone tone = Tone::remark, About about = About::window);
    /// What was refused, or went wrong.
    void say(const Error& error);
    void say(const Result<void>& done);
    void tell(const std::string& fault);
    bool has_to_stay();
    Result<PlayFigures> end(Result<void> ended);
    Result<PlayFigures> end_without_clip(Result<void> ended);
    Result<void> write_settings() const;
    KeptSettings to_keep() const;
    void note_last_failure();
    Result<void> finish_screenshots(bool is_kept, Result<void> kept);
    Result<void> finish_brush();
    Error interruption() const;
    void sum_up();
    std::string relief_words() const;
    void count_session();

    // Pictures (window_picture.cpp).
    void watch(const WatchedMoment* moment, Clock::time_point now);
    bool is_due(const WatchedMoment* moment, Clock::time_point now) const;
    double pause_ms() const;
    double frame_ms() const;
    ViewCamera drawn_camera(const ScreenSize& size) const;
    int vertex_step(const ViewCamera& camera);
    Result<void> draw_what_is_there(const WatchedMoment* moment);
    Result<void> draw_newest();
    bool pointer_is_on_bar() const;
    Result<void> draw(const WatchedMoment& moment);
    PanelFacts words_of(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera);
    void note_picture(const PanelFacts& facts, Clock::time_point begin);
    void note_frame(const WatchedMoment& moment, bool is_new);
    Result<void> draw_opening();

    // What a person does (window_input.cpp).
    void take(const InputEvent& event);
    void take_of_pointer(const InputEvent& event);
    TouchInput::Ground ground_at(double x, double y);
    void take_of_touch(const InputEvent& event);
    void lift_touches();
    void lift_after_sleep();
    bool has_touch_screen() const;
    bool clicks_for_full_screen(const InputEvent& event, bool is_of_panel);
    void turn_full_screen();
    bool bar_is_wanted() const;
    void take(const WindowCommand& command);
    void refuse_without_clip();
    void take_of_time(const WindowCommand& command);
    void play_or_pause();
    void take_of_view(const WindowCommand& command);
    void set_turning(bool on);
    void take_of_fingers(const WindowCommand& command);
    void take_of_window(const WindowCommand& command);
    void set_overlay(const std::string& name);
    bool leave_what_is_in_front();
    void take_of_sound(const WindowCommand& command);
    void take_of_measure(const WindowCommand& command);
    void measure(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera);
    void take_of_brush(const WindowCommand& command);
    void take_of_hand(const WindowCommand& command);
    void change_scale(double times);
    void look_after_hand(const WatchedMoment* moment);
    void power_hand_off();
    void stop_force_at_once(InputEvent& event);
    void lead_force();

    // Clips and settings that come and go (window_clips.cpp).
    bool waits_for_wish() const { return !clip_ && options_.session.clip.file.empty(); }
    void ask_for_first_clip();
    Result<Ready> open_clip(ClipChoice choice, const TwoSettings& kept);
    Result<Ready> open_first(Playlist list, int by, ClipChoice choice, const TwoSettings& kept);
    void ask_for_clip(const Playlist& list, int by, const ClipChoice& choice);
    void ask_for_named(std::vector<std::string> named);
    void ask_for_change(const WindowSettings& wanted);
    Result<void> go_on_opening();
    Result<void> take_made(Result<Ready> made);
    Result<void> go_on_without_clip(const Error& why);
    void go_on_changing();
    Result<void> take(Ready& ready);
    Result<void> show(Ready& ready);
    bool note_failure();
    void tell_guesses();
    void open_others(std::vector<std::string> named);
    void open_instead(Playlist list, int by);
    void go_in_list(int by);
    void go_on_in_list(const WatchedMoment* moment);
    void tell_skipped(std::span<const Error> skipped);
    void say_place_in_list();
    /// In effect, or to be.
    const WindowSettings& wanted_settings() const { return wanted_settings_ ? *wanted_settings_ : settings_; }
    void feel(const WindowCommand& command);
    void heed_brush();
    void compare_with_before();
    void reset();
    static bool has_materials(const WindowSettings& settings);
    static std::string in_words(const WindowSettings& settings);

    // A kiosk, and a study in it (window_kiosk.cpp).
    Result<void> open_kiosk();
    std::string kiosk_letters() const;
    void tell_of_letters();
    Result<void> check_labels() const;
    void watch_over();
    void begin_anew();
    void begin_anew_at_end();
    bool clip_repeats() const { return playlist_.size() < 2 || study_; }
    void try_again();
    void welcome(const InputEvent& event);
    void show_how(const HeightField& field, const ViewCamera& camera);
    void look_for_labels(const WatchedMoment& moment);
    static Overlay overlay_for_visitors(Overlay now);
    KioskFacts kiosk_facts(const PanelFacts& facts) const;
    void put_in_kiosk_words(HandState& state) const;
    void log_visit(const std::optional<KioskWatch::Visit>& visit);
    void log_fault(const std::string& fault);
    void end_log(const Result<void>& ended);
    Result<void> open_study();
    bool study_has_page() const;
    bool study_clip_is_there() const;
    void go_on_in_study();
    void take_of_study_hand();
    bool take_of_study(const InputEvent& event);
    void take_of_study(const WindowCommand& command);
    void hide_forces(std::vector<FingerMark>& marks, const HeightField& field) const;
    double study_strip(const ScreenSize& size) const;
    StudyFacts study_facts() const;

    PlayOptions options_;
    const Clock::time_point asked_for_;
    /// What gives forces now. The screen's thread stops them too; it ends before this does.
    struct ForceGivers {
        std::shared_ptr<PointerDevice> pointer{};
        std::shared_ptr<HandControl> control{};  // null: the pointer leads
    };
    std::mutex force_mutex_;
    ForceGivers force_givers_;  // guarded by force_mutex_
    std::unique_ptr<Screen> screen_;
    std::optional<ImGuiLayer> layer_;
    ClipPicture picture_;
    BackgroundWriter screenshots_{"screenshots", "pictures of the window", most_screenshots};
    std::optional<Clock::time_point> lost_at_;  // when graphics were last
    std::optional<WindowPanel> panel_;
    std::unique_ptr<WindowSound> sound_;
    std::unique_ptr<WindowFilm> film_;
    std::unique_ptr<OpenedClip> clip_;
    std::optional<PlaybackControl> playback_;
    std::optional<KioskWatch> kiosk_;
    std::optional<RestingFingers> resting_;  // once there is a clip
    std::unique_ptr<UseLog> use_log_;
    std::unique_ptr<StudyRun> study_;
    std::size_t study_turn_ = 0;    // that the window has begun
    bool study_had_force_ = false;  // asked for, of a device
    struct AskedClip {
        std::size_t clip;
        double at_s;
    };
    std::optional<AskedClip> study_asked_;         // which has not come yet
    std::map<std::string, double> logged_faults_;  // in the last hour, and when
    std::optional<double> went_on_s_;              // to the next clip by itself, or tried to: at this end
    bool is_inviting_ = false;
    bool hand_is_gone_ = false;
    glm::dvec3 hand_seen_at_{0.0};  // world, its first finger, when it last was a visit
    std::set<std::string> told_;    // on the terminal, by a kiosk: once each
    double tried_again_s_ = 0;      // to open its clip
    double begun_anew_s_ = 0, shown_share_ = 1;
    glm::dvec2 shown_from_{0.5, 0.44};  // shares of the picture
    SettingsFile settings_file_;
    WindowSettings settings_;
    std::optional<WindowSettings> wanted_settings_;  // to be changed to
    std::optional<WindowSettings> asked_settings_;   // that `opening_` makes ready
    Clock::time_point renew_after_;                  // the session, by one that takes more commands
    std::int64_t changed_at_ = 0;                    // figures_.pictures at the last change
    std::optional<Error> failure_;                   // the first of all clips
    PointerInput pointer_;
    MeasureTool measure_;
    TouchInput touches_;
    bool was_touched_ = false;  // by a finger on a touch screen
    glm::dvec2 pointer_at_{0.0};
    bool pointer_is_there_ = false;     // in the window
    std::vector<InputEvent> events_;    // since the last picture
    std::vector<std::string> dropped_;  // at once
    DoubleClick full_screen_click_;
    double time_s_ = 0;  // of the script, and of what a person does: it stands still where the machine does
    double stirred_s_ = 0;                 // when a person last did something
    Playlist playlist_;                    // of the clip that is there
    std::optional<Playlist> wanted_list_;  // of one that is asked for, and its place
    std::optional<bool> next_is_paused_;   // whether it is to be; nothing: no clip is asked for
    double shown_s_ = 0;                   // since when the clip is
    std::optional<double> touched_s_;      // when a clip was last touched, painted or measured
    std::vector<WindowCommand> asked_;
    std::size_t scripted_ = 0;
    ScriptClock script_clock_;
    std::optional<Clock::time_point> begun_;  // with the first picture
    double begun_cpu_ms_ = 0;
    Clock::time_point last_picture_, last_event_;
    Clock::duration slept_ = Clock::slept();
    std::optional<Clock::time_point> first_event_;  // not in a picture yet
    DrawnState seen_;
    SlowReading slow_reading_;  // of this clip
    bool is_told_of_reading_ = false;
    Notices notices_;
    std::string shown_message_, sound_fault_;
    std::set<std::string> file_faults_;  // that were said
    std::size_t place_lines_ = 0;
    bool quit_ = false, fullscreen_ = false;
    bool is_turning_ = false;                           // dragging turns the view
    bool is_dented_ = true;                             // a surface that gives way is drawn so
    bool is_leaving_ = false, leaves_at_once_ = false;  // after `quit_`, while the brush is at work
    double last_draw_ms_ = 0;
    RedrawEstimator redraw_;
    Clock::time_point frame_came_at_;
    FramesShown frames_shown_;
    PictureGovernor governor_;
    bool coarse_saves_ = false;  // vertices of the last picture, if it is coarse
    PlayFigures figures_;
    std::vector<std::string> measured_;  // lines between two places, in words
    WindowBrush brush_{options_};
    std::optional<Ready> ready_;  // a change, until the clip has come to where it begins
    LongWork<Ready> opening_{"clip-opening", "that opens clips"};  // ends before what it works on
};

}  // namespace touchable
