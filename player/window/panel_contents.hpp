#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "player/draw/overlays.hpp"
#include "player/window/finger_halos.hpp"
#include "player/window/hand_state.hpp"
#include "player/window/kiosk_texts.hpp"
#include "player/window/materials_panel.hpp"
#include "player/window/measure_tool.hpp"
#include "player/window/settings_panel.hpp"
#include "player/window/study_page.hpp"

namespace touchable {

/// Under the pointer, in words; empty where there is nothing to say.
struct PlaceFacts {
    std::vector<std::string> lines;
    std::optional<glm::ivec2> pixel{};  ///< of the clip; nothing: no surface
};

/// What a kiosk shows beside the picture.
struct KioskFacts {
    const KioskTexts& texts;
    TouchedBy by = TouchedBy::mouse;
    std::optional<double> invited_s{};    ///< since when it invites to touch, seconds; nothing: it does not
    std::string caption{};                ///< of what a finger rests on; empty: none
    bool is_turned = false;               ///< the view is not the clip's own
    bool has_bar = true;                  ///< KioskBar, while somebody does something
    bool is_still = false;                ///< the clip is one picture
    std::optional<OverlayScale> scale{};  ///< what colours mean, in its words; nothing: they are the clip's
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
    std::string overlay;                  ///< of the surface's colours
    const OverlayScale* scale = nullptr;  ///< what those mean; null: they are the clip's own
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
    std::vector<std::string> faults;  ///< that nobody has read yet; the first is shown
    int volume = 100;
    bool is_empty = false;            ///< nobody has said yet what to show
    std::optional<KioskFacts> kiosk;  ///< only what a visitor needs; nothing: it is none
    std::optional<StudyFacts> study;  ///< of a kiosk whose visitors are participants
};

}  // namespace touchable
