#pragma once

#include <glm/vec2.hpp>
#include <optional>

#include "player/window/input_event.hpp"

namespace touchable {

/// For a window in a public place: after how many seconds without input it invites to touch it, and after how
/// many it begins anew.
struct KioskTimes {
    double invite_s = 20, reset_s = 60;
};

/// Whether somebody is there. Times are the window's own, seconds, and do not go backward.
class KioskWatch {
public:
    explicit KioskWatch(const KioskTimes& times) : times_(times) {}

    /// Somebody did something.
    void came(double now_s) {
        if (!is_there_) began_s_ = now_s;
        is_there_ = true;
        last_s_ = input_s_ = now_s;
        was_visited_ = true;
    }
    /// A finger is still pressed: somebody is there, even one who does nothing, until it is so long that a
    /// button may be stuck.
    void holds(double now_s) {
        if (is_there_ && now_s - input_s_ < times_.reset_s) last_s_ = now_s;
    }
    /// Whether a visit has begun and not ended.
    bool is_there() const { return is_there_; }
    /// Whether somebody has been there since it began, or began anew.
    bool was_visited() const { return was_visited_; }
    struct Visit {
        double came_s = 0, seconds = 0;  ///< from the first thing that somebody did to the last
    };
    /// The visit that has ended, once: nobody has done anything for as long as until it invites.
    std::optional<Visit> ended(double now_s);
    /// Likewise the one that goes on, where the window closes.
    std::optional<Visit> end();
    /// For how many seconds the window has been inviting; nothing while somebody is there.
    std::optional<double> invites(double now_s) const;
    /// Whether to begin anew now: once after each visit.
    bool begins_anew(double now_s);

private:
    KioskTimes times_;
    double began_s_ = 0, input_s_ = 0, last_s_ = 0;
    bool is_there_ = false, was_visited_ = false;
};

/// Whether a visitor may do this. A visitor may not close the window, open or write files, or change
/// settings.
bool is_for_visitors(const InputEvent& event);
/// Whether it shows that somebody is there.
bool is_a_visit(const InputEvent& event);

/// The finger that shows a visitor how to touch, so many seconds after it began: its distance from the middle
/// of what there is to see, in shares of the picture's width and height, and whether it presses. It comes
/// down, strokes, and leaves, again and again.
struct ShownStroke {
    glm::dvec2 off{0.0};
    bool pressed = false;
};
ShownStroke stroke_at(double seconds);

}  // namespace touchable
