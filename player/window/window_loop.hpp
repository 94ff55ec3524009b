#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "player/audio/window_sound.hpp"
#include "player/window/clip_picture.hpp"
#include "player/window/double_click.hpp"
#include "player/window/frames_shown.hpp"
#include "player/window/imgui_layer.hpp"
#include "player/window/kept_settings.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/long_work.hpp"
#include "player/window/measure_tool.hpp"
#include "player/window/notices.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/picture_governor.hpp"
#include "player/window/play_window.hpp"
#include "player/window/playback_control.hpp"
#include "player/window/playlist.hpp"
#include "player/window/pointer_input.hpp"
#include "player/window/redraw_estimator.hpp"
#include "player/window/resting_fingers.hpp"
#include "player/window/screenshots.hpp"
#include "player/window/slow_reading.hpp"
#include "player/window/study_run.hpp"
#include "player/window/touch_input.hpp"
#include "player/window/use_log.hpp"
#include "player/window/window_brush.hpp"
#include "player/window/window_clock.hpp"
#include "player/window/window_film.hpp"
#include "player/window/window_panel.hpp"

namespace touchable {

/// The window of `touchable play`: its parts, and the loop that drives them.
class WindowLoop {
public:
    explicit WindowLoop(PlayOptions options)
        : options_(std::move(options)), asked_for_(Clock::now()), screenshots_(options_.existing) {}
    /// Whatever it ends by: the hand is unpowered before anything is waited for.
    ~WindowLoop() { power_hand_off(); }

    Result<PlayFigures> run();

private:
    using Clock = WindowClock;

    Result<void> open();
    Result<void> open_screen(const KeptSettings& kept);
    Result<std::unique_ptr<WindowGraphics>> make_graphics();
    Result<void> open_graphics();
    Result<void> open_graphics_anew(const Error& error);
    Result<void> open_parts();
    double scale_of_words(const ScreenSize& size) const;
    Result<void> fit_words(const ScreenSize& size);
    void ask_for_first_clip();
    Result<void> turn();
    void go_on_with_clip();
    bool is_at_work() const;
    void take_script();
    void take(const InputEvent& event);
    void take_of_pointer(const InputEvent& event);
    void take_of_touch(const InputEvent& event);
    void lift_touches();
    void lift_after_sleep();
    TouchInput::Ground ground_at(double x, double y);
    void take(const WindowCommand& command);
    void take_of_time(const WindowCommand& command);
    void play_or_pause();
    void take_of_view(const WindowCommand& command);
    void set_turning(bool on);
    void take_of_fingers(const WindowCommand& command);
    void take_of_window(const WindowCommand& command);
    void take_of_sound(const WindowCommand& command);
    Result<void> draw_newest();
    bool leave_what_is_in_front();
    bool clicks_for_full_screen(const InputEvent& event, bool is_of_panel);
    void turn_full_screen();
    bool bar_is_wanted() const;
    void take_of_hand(const WindowCommand& command);
    void change_scale(double times);
    void stop_force_at_once(InputEvent& event);
    void lead_force();
    void look_after_hand(const WatchedMoment* moment);
    void power_hand_off();
    void set_overlay(const std::string& name);
    static Overlay overlay_for_visitors(Overlay now);
    void take_of_measure(const WindowCommand& command);
    void measure(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera);
    void open_others(std::vector<std::string> named);
    void open_instead(Playlist list, int by);
    void go_in_list(int by);
    void go_on_in_list(const WatchedMoment* moment);
    void go_to_first();
    void say_place_in_list();
    void tell_skipped(std::span<const Error> skipped);
    Result<void> keep_picture(const std::filesystem::path& name);
    /// A and B as they are kept, and as they are in effect: without what the clip would not go with; and
    /// what a brush painted.
    struct WindowSettings {
        TwoSettings kept, in_effect;
        std::shared_ptr<const PaintedSegments> painted{};
        bool operator==(const WindowSettings&) const = default;
    };
    static bool has_materials(const WindowSettings& settings);
    static std::string in_words(const WindowSettings& settings);
    void feel(const WindowCommand& command);
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
    Result<Ready> open_clip(ClipChoice choice, const TwoSettings& kept, const std::stop_token& given_up);
    Result<Ready> open_first(Playlist list, int by, ClipChoice choice, const TwoSettings& kept,
                             const std::stop_token& given_up);
    void ask_for_clip(const Playlist& list, int by, const ClipChoice& choice);
    void ask_for_named(std::vector<std::string> named);
    void ask_for_change(const WindowSettings& wanted);
    bool waits_for_wish() const { return !clip_ && options_.session.clip.file.empty(); }
    static bool needs_clip(WindowVerb verb);
    void refuse_without_clip();
    Result<void> go_on_without_clip(const Error& why);
    Result<PlayFigures> end_without_clip(Result<void> ended);
    Result<void> go_on_opening();
    void go_on_changing();
    Result<void> take_made(Result<Ready> made);
    Result<void> take(Ready& ready);
    Result<void> show(Ready& ready);
    bool note_failure();
    void tell_guesses();
    std::string words_of_opening() const;
    void reset();
    void take_of_brush(const WindowCommand& command);
    void heed_brush();
    void compare_with_before();
    bool has_to_stay();
    Result<void> finish_brush();
    Result<void> open_kiosk();
    std::string kiosk_letters() const;
    void tell_of_letters();
    Result<void> check_labels() const;
    void watch_over();
    void look_for_labels(const WatchedMoment& moment);
    KioskFacts kiosk_facts(const PanelFacts& facts) const;
    bool has_touch_screen() const;
    void put_in_kiosk_words(HandState& state) const;
    void log_visit(const std::optional<KioskWatch::Visit>& visit);
    void log_fault(const std::string& fault);
    void end_log(const Result<void>& ended);
    void welcome(const InputEvent& event);
    void show_how(const HeightField& field, const ViewCamera& camera);
    void begin_anew();
    void begin_anew_at_end();
    void try_again();
    bool clip_repeats() const { return playlist_.size() < 2 || study_; }  // in a kiosk
    Result<void> open_study();
    bool study_has_page() const;
    bool study_clip_is_there() const;
    void go_on_in_study();
    void take_of_study_hand();
    bool take_of_study(const InputEvent& event);
    void take_of_study(const WindowCommand& command);
    bool pointer_is_on_bar() const;
    void hide_forces(std::vector<FingerMark>& marks, const HeightField& field) const;
    StudyFacts study_facts() const;
    double study_strip(const ScreenSize& size) const;
    void note_sound();
    void note_slow_reading();
    void note_files();
    void note_screenshots();
    KeptSettings to_keep() const;
    Result<PlayFigures> end(Result<void> ended);
    Result<void> write_settings() const;
    void note_last_failure();
    Result<void> finish_screenshots(bool is_kept, Result<void> kept);
    Error interruption() const;
    void say(std::string words, Tone tone = Tone::remark, About about = About::window);
    /// What was refused, or went wrong.
    void say(const Error& error);
    void tell(const std::string& fault);
    void say(const Result<void>& done);
    void sum_up();
    std::string relief_words() const;
    void count_session();
    double pause_ms() const;
    double frame_ms() const;
    void watch(const WatchedMoment* moment, Clock::time_point now);
    bool is_due(const WatchedMoment* moment, Clock::time_point now) const;
    ViewCamera drawn_camera(const ScreenSize& size) const;
    int vertex_step(const ViewCamera& camera);
    Result<void> draw_opening();
    Result<void> draw_what_is_there(const WatchedMoment* moment);
    Result<void> draw(const WatchedMoment& moment);
    PanelFacts words_of(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera);
    void note_picture(const PanelFacts& facts, Clock::time_point begin);
    static double thread_cpu_ms();
    void note_frame(const WatchedMoment& moment, bool is_new);
    double now_s() const;
    static double seconds_between(Clock::time_point from, Clock::time_point to) {
        return std::chrono::duration<double>(to - from).count();
    }

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
    Screenshots screenshots_;
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
