#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/vec2.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "player/draw/overlays.hpp"
#include "player/window/brush.hpp"
#include "player/window/finger_halos.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/measure.hpp"
#include "player/window/persistent_device.hpp"
#include "player/window/session_settings.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// How a window says something.
enum class Tone {
    remark,   ///< what was done: goes by itself
    refusal,  ///< what cannot be done, though it was just asked for: goes by itself
    fault     ///< what went wrong: stays until it is dismissed
};

/// What a fault is about: it goes with that.
enum class About { window, clip };

/// What a window has to say to a person. Times are the window's own, seconds, and do not go backward.
class Notices {
public:
    static constexpr double shown_s = 4;           ///< what goes by itself
    static constexpr std::size_t most_faults = 5;  ///< that wait: the newest of more

    void say(std::string words, Tone tone, double now_s, About about = About::window) {
        if (tone != Tone::fault) {
            passing_ = std::move(words);
            is_refusal_ = tone == Tone::refusal;
            said_s_ = now_s;
            return;
        }
        if (std::ranges::find(faults_, words) != faults_.end()) return;
        if (faults_.size() == most_faults) dismiss();
        if (about == About::clip) of_clip_.insert(words);
        faults_.push_back(std::move(words));
    }
    /// Another clip takes the place of the one that is there: what was said so far goes, but for faults of
    /// the window.
    void leave_clip() {
        clear_passing();
        std::erase_if(faults_, [this](const std::string& fault) { return of_clip_.contains(fault); });
        of_clip_.clear();
    }
    /// What has been there long enough goes.
    void pass(double now_s) {
        if (now_s - said_s_ > shown_s) passing_.clear();
    }
    /// What goes by itself goes now.
    void clear_passing() { passing_.clear(); }
    /// The fault that is shown was read; whether there was one.
    bool dismiss() {
        if (faults_.empty()) return false;
        of_clip_.erase(faults_.front());
        faults_.pop_front();
        return true;
    }

    const std::string& passing() const { return passing_; }  ///< empty: nothing
    bool is_refusal() const { return is_refusal_; }          ///< `passing`
    const std::deque<std::string>& faults() const { return faults_; }

private:
    std::string passing_;
    bool is_refusal_ = false;
    double said_s_ = 0;
    std::deque<std::string> faults_;  // the first one is shown
    std::set<std::string> of_clip_;   // those of them that are about the clip
};

/// What the panel shows of the settings of what is felt.
struct SettingsFacts {
    std::map<std::string, std::string> by_hand,
        in_effect;            ///< as SessionSettings and `settings_in_effect` have them
    std::string filters;      ///< each filter with its reason, in words
    std::string relief{};     ///< what keeps the relief; empty: there is none
    bool b_is_on = false;     ///< of the two sets
    bool has_device = false;  ///< one is held
};

/// What is shown of the brush of materials.
struct BrushFacts {
    BrushTool tool = BrushTool::touch;
    std::string material{};         ///< in hand
    bool is_there = false;          ///< segments are known
    std::string otherwise{};        ///< material of all that is not painted; empty: guesses
    bool materials_are_on = false;  ///< felt
    bool can_undo = false, can_redo = false;
    std::size_t segments = 0;        ///< that are seen anywhere in the clip
    std::vector<glm::dvec2> line{};  ///< that was begun, pixels of the window
};

/// What a participant of a study has before him, in his language.
struct StudyFacts {
    bool is_page = true;  ///< over all of the window; otherwise a strip below the picture that is touched
    bool shows_force = false;          ///< of a strip: whether forces are to be seen
    std::string title, words;          ///< either may be empty; of a question the words
    std::vector<std::string> answers;  ///< of a question; empty: it is none
    bool is_scale = false;             ///< they are numbers in a row, between two ends
    std::string low, high;             ///< what those mean
    std::optional<std::size_t> chosen{};
    std::string go_on;  ///< on the button; empty: there is none
    bool may_go_on = false;
    int wait_s = 0;         ///< seconds until it may, which are said on the button; 0: no time is waited for
    double share_done = 0;  ///< of the study, 0 to 1
    std::string fault;      ///< that a participant is to call for help; empty: all is well
};

/// Under the pointer, in words; empty where there is nothing to say.
struct PlaceFacts {
    std::vector<std::string> lines;
    std::optional<glm::ivec2> pixel{};  ///< of the clip; nothing: no surface
};

/// What a kiosk shows beside the picture.
struct KioskFacts {
    const KioskTexts& texts;
    TouchedBy by = TouchedBy::mouse;
    std::optional<double> invited_s{};  ///< since when it invites to touch, seconds; nothing: it does not
    std::string caption{};              ///< of what a finger rests on; empty: none
    bool is_turned = false;             ///< the view is not the clip's own
    bool has_bar = true;                ///< KioskBar, while a visitor does something
    bool is_still = false;              ///< the clip is one picture
    std::optional<Overlays::Scale>
        scale{};  ///< what colours mean, in its words; nothing: they are the clip's
};

/// What the window's own words, bars and curves show.
struct PanelFacts {
    std::string clip;  ///< its name
    double seconds = 0, clip_seconds = 0;
    double last_seconds = 0;  ///< moment of its last frame, where the seek bar ends
    std::vector<double>
        cuts;  ///< seconds, where the picture's depth changed all at once, as far as it was seen
    std::int64_t frame = 0;
    bool playing = true, looping = false, at_end = false;
    std::size_t clips = 1;    ///< of the playlist
    bool is_turning = false;  ///< dragging turns the view
    bool has_touch_screen = false;
    double speed = 1;
    std::string overlay;                     ///< of the surface's colours
    const Overlays::Scale* scale = nullptr;  ///< what those mean; null: they are the clip's own
    bool force_on = true;
    std::optional<HandFacts> hand;  ///< nothing: the pointer is the finger
    double pressed_mm = 0;          ///< how deep the finger is meant to be in the surface; below 0 above it
    std::vector<double> forces;     ///< newtons, by finger
    double limit_newtons = 10;      ///< that none of them is beyond
    bool is_dented = true;          ///< whether a surface that gives way is drawn so
    std::vector<FingerHalo> halos;
    PlaceFacts place;
    SettingsFacts settings;
    BrushFacts brush;
    MeasureFacts measure;
    std::vector<std::string> figures;  ///< of the machine, a line each
    std::int64_t late_ticks = 0, dropped_frames = 0;
    std::string message;  ///< of the moment: what a key did, or why a file cannot be opened
    bool message_is_bad = false;
    std::vector<std::string> faults;  ///< that are not dismissed yet; the first is shown
    int volume = 100;
    bool is_empty = false;            ///< no clip was named yet
    std::optional<KioskFacts> kiosk;  ///< only what a visitor needs; nothing: it is none
    std::optional<StudyFacts> study;  ///< of a kiosk whose visitors are participants
};

}  // namespace touchable
