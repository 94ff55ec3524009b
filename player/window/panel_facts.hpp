// SPDX-License-Identifier: Apache-2.0
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
#include "player/window/user_files.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// Kind of a message.
enum class Tone {
    remark,   ///< a result: disappears by itself
    refusal,  ///< a refused request: disappears by itself
    fault     ///< a fault: stays longer, or until dismissed
};

/// A message of a kept screenshot begins so.
inline const std::string saved_as = "saved as ";

/// The subject of a fault: the fault disappears with it.
enum class About { window, clip };

/// A window's messages for the user. Times are the window's, seconds, monotonic.
class Notices {
public:
    static constexpr double shown_s = 4, fault_s = 30;  ///< of passing messages and of each fault
    static constexpr std::size_t most_faults = 5;  ///< waiting: the newest of more

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
    /// The clip changes: removes all messages but faults of the window.
    void leave_clip() {
        clear_passing();
        std::erase_if(faults_, [this](const std::string& fault) { return of_clip_.contains(fault); });
        of_clip_.clear();
    }
    /// Removes the passing message after `shown_s`, and the shown fault after `fault_s`.
    void pass(double now_s) {
        if (now_s - said_s_ > shown_s) passing_.clear();
        if (faults_.empty()) return fault_since_s_.reset();
        if (!fault_since_s_) fault_since_s_ = now_s;
        if (now_s - *fault_since_s_ > fault_s) dismiss();
    }
    /// Removes the passing message now.
    void clear_passing() { passing_.clear(); }
    /// Dismisses the shown fault; returns whether there was one.
    bool dismiss() {
        if (faults_.empty()) return false;
        fault_since_s_.reset();
        of_clip_.erase(faults_.front());
        faults_.pop_front();
        return true;
    }

    const std::string& passing() const { return passing_; }  ///< empty: none
    bool is_refusal() const { return is_refusal_; }          ///< of `passing`
    const std::deque<std::string>& faults() const { return faults_; }

private:
    std::string passing_;
    bool is_refusal_ = false;
    double said_s_ = 0;
    std::optional<double> fault_since_s_;
    std::deque<std::string> faults_;  // the first one is shown
    std::set<std::string> of_clip_;   // the faults about the clip
};

/// The panel's facts about the settings of touch.
struct SettingsFacts {
    std::map<std::string, std::string> by_hand,
        in_effect;            ///< as in SessionSettings and `settings_in_effect`
    std::string filters;      ///< each filter with its reason, as text
    std::string relief{};     ///< command that makes a clip of the relief; empty: none
    bool b_is_on = false;     ///< set B is in effect
    bool has_device = false;  ///< a haptic device is used
};

/// The panel's facts about the brush of materials.
struct BrushFacts {
    BrushTool tool = BrushTool::touch;
    std::string material{};         ///< selected
    bool is_there = false;          ///< segments are known
    std::string otherwise{};        ///< material of all unpainted segments; empty: guesses
    bool materials_are_on = false;  ///< felt
    bool can_undo = false, can_redo = false;
    std::size_t segments = 0;        ///< visible anywhere in the clip
    std::vector<glm::dvec2> line{};  ///< the unfinished input, pixels of the window
    std::string work{};              ///< in progress, if it takes long
};

/// The screen of a study's participant, in that participant's language.
struct StudyFacts {
    bool is_page = true;               ///< over all of the window; otherwise a strip below the picture
    bool shows_force = false;          ///< of a strip: whether forces are shown
    std::string title, words;          ///< either may be empty; the question, if there is one
    std::vector<std::string> answers;  ///< of a question; empty: no question
    bool is_scale = false;             ///< the answers are a row of numbers between two ends
    std::string low, high;             ///< meaning of the ends
    std::optional<std::size_t> chosen{};
    std::string go_on;  ///< the button's text; empty: no button
    bool may_go_on = false;
    int wait_s = 0;         ///< seconds until it may, shown on the button; 0: none
    double share_done = 0;  ///< of the study, 0 to 1
    std::string fault;      ///< asks the participant to call the staff; empty: no fault
};

/// The values at the pointer, as text; empty: none.
struct PlaceFacts {
    std::vector<std::string> lines;
    std::optional<glm::ivec2> pixel{};  ///< of the clip; nullopt: no surface
};

/// A kiosk's content beside the picture.
struct KioskFacts {
    const KioskTexts& texts;
    TouchedBy by = TouchedBy::mouse;
    std::optional<double> invited_s{};  ///< seconds since the invitation began; nullopt: none
    std::string caption{};              ///< of the label under a resting finger; empty: none
    bool is_turned = false;             ///< the view is not the clip's own
    bool has_bar = true;                ///< KioskBar, during visitor input
    bool is_still = false;              ///< the clip is a single picture
    std::optional<Overlays::Scale>
        scale{};  ///< the colours' meaning in the kiosk's texts; nullopt: the clip's own colours
};

/// The content of the window's texts, bars and curves.
struct PanelFacts {
    std::string clip;  ///< its name
    double seconds = 0, clip_seconds = 0;
    double last_seconds = 0;  ///< time of its last frame, where the seek bar ends
    std::vector<double>
        cuts;  ///< seconds; moments at which the picture's depth changes suddenly, as found so far
    std::int64_t frame = 0;
    bool playing = true, looping = false, at_end = false;
    bool is_live = false;     ///< a camera or a stream, whose time only goes on
    std::string silence{};    ///< of its source: no frame comes, and why; empty: frames come
    std::size_t clips = 1;    ///< of the playlist
    bool is_turning = false;  ///< dragging turns the view
    bool can_undo_view = false;
    bool has_touch_screen = false;
    double speed = 1;
    std::string overlay;                     ///< of the surface's colours
    const Overlays::Scale* scale = nullptr;  ///< of the overlay; null: the clip's own colours
    bool force_on = true;
    std::optional<HandFacts> hand;  ///< nullopt: the pointer is the finger
    double pressed_mm = 0;          ///< intended depth of the finger in the surface; below 0 above it
    std::vector<double> forces;     ///< newtons, by finger
    double limit_newtons = 10;      ///< the greatest force
    bool is_dented = true;          ///< dents are drawn
    Lighting light = Lighting::off;
    std::vector<FingerHalo> halos;
    PlaceFacts place;
    SettingsFacts settings;
    BrushFacts brush;
    MeasureFacts measure;
    std::vector<std::string> figures;  ///< performance, one per line
    std::int64_t late_ticks = 0, dropped_frames = 0;
    std::string message;  ///< passing: a key's effect, or why a file cannot be opened
    bool message_is_bad = false;
    std::vector<std::string> faults;  ///< not dismissed yet; the first is shown
    int volume = 100;
    bool is_empty = false;            ///< no clip was named yet
    FileList files;                   ///< to choose from
    std::optional<KioskFacts> kiosk;  ///< the visitor's view; nullopt: no kiosk
    std::optional<StudyFacts> study;  ///< for a kiosk whose visitors are participants
};

}  // namespace touchable
