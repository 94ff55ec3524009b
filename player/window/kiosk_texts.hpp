#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "player/window/hand_state.hpp"

namespace touchable {

/// What a visitor touches a kiosk by.
enum class TouchedBy { mouse, touch_screen, device };

/// All words that a kiosk shows to visitors. In English as they are here.
struct KioskTexts {
    std::string language = "en";  ///< of a label's captions and sounds that come first
    std::string invitation = "Touch the picture";
    std::string how_by_mouse = "Move, hold the button, and feel";
    std::string how_by_touch_screen = "One finger touches, two turn it";
    std::string how_by_device = "Take the handle, and feel";
    std::string force_is_off = "Force is off";
    std::string again_by_mouse = "Press to feel again";
    std::string again_by_touch_screen = "Touch to feel again";
    std::string device_is_on = "You feel what you touch";
    std::string device_is_off = "Forces are off: press the button of the handle, or F";
    std::string device_is_away = "The device is away: one moment, please";
    std::string device_has_no_force = "You see what you touch";
    std::string device_is_moved = "No force while the handle is moved back";
    std::string come_out = "Lift the finger off the surface: then you feel it";
    std::string turn_back = "Turn it back";  ///< of a button, as are the next
    std::string touch = "Touch";             ///< what dragging does from then on
    std::string turn = "Turn";
    std::string pause = "Pause";
    std::string play = "Play";
    std::string colours = "Colours";
    std::string next = "Next";    ///< clip
    std::string limit = "limit";  ///< of the largest force
    std::string depth = "Depth";  ///< what colours may mean, as are the next
    std::string stiffness = "Stiffness";
    std::string friction = "Friction";
    std::string height = "Height";
    std::string everywhere = "the same everywhere";
    std::string study_begin = "Begin";
    std::string study_continue = "Continue";
    std::string study_wait = "One moment, please";
    std::string study_not_kept = "Answers cannot be kept. Please call whoever looks after this.";
    bool operator==(const KioskTexts&) const = default;

    /// One after the other, for their letters.
    std::string all() const;
    const std::string& how(TouchedBy by) const;
    const std::string& again(TouchedBy by) const;
    /// Of a device that is held, in place of what whoever set it up would read.
    const std::string& of_device(HandState::What what) const;
};

/// A longer file is refused, bytes.
inline constexpr std::size_t largest_kiosk_texts = std::size_t{64} << 10;

/// An object of the members of KioskTexts, and "touchable_kiosk_texts": 1; what is left out is English. Each
/// is a line of up to 200 bytes of UTF-8. Refused (ErrorKind::input, beginning with `where`) where that
/// cannot be.
Result<KioskTexts> parse_kiosk_texts(std::string_view json, std::string_view where);

/// "de" of the person who is logged in, by the environment's LC_ALL, LC_MESSAGES or LANG; "en" where these
/// say nothing of a language.
std::string own_language();

}  // namespace touchable
