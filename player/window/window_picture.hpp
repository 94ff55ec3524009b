// SPDX-License-Identifier: Apache-2.0
#pragma once

// The window's pictures: when one is due, its content, and its measurements. Each shows the clip at the
// haptic moment, with fingers, messages and panels; before the first clip, only messages.
//
// A picture is due with each new frame of the clip; within a frame, after movement or user input, if there is
// time before the next. While nothing moves, texts and bars alone are made once a second, and drawn if
// they differ; and a turned view is drawn once more with up to 16 samples a pixel. Its size and level of
// detail follow from the drawing time (PictureGovernor). If the GPU is lost, new graphics are opened once.
//
// With a film that is drawn offline (PlayOptions), a picture is due with each of the film's, in full detail,
// however long it takes.
//
// Runs on the window's thread. A film is encoded on a separate thread (WindowFilm).

#include "player/view/view.hpp"
#include "player/window/clip_picture.hpp"
#include "player/window/imgui_layer.hpp"
#include "player/window/window_clock.hpp"
#include "player/window/window_files.hpp"
#include "player/window/window_panel.hpp"

namespace touchable {

class OpenedClip;
class WindowClips;
class WindowInput;
class WindowState;
struct KeptSettings;

/// Scale of text, lines and bars in a window, like ScreenSize::scale: the display's, and more if the window
/// is larger than 1280x720 of such pixels: by the square root of the excess, because a larger window is meant
/// to show more; with `from_afar`, for a kiosk's distant visitors, by all of it. In steps of a quarter, so
/// that resizing a window seldom changes it.
double words_scale(const ScreenSize& size, bool from_afar);

class WindowPicture {
public:
    WindowPicture(WindowState& window, WindowPanel& panel, WindowInput& input, const WindowClips& clips)
        : window_(window), panel_(panel), input_(input), clips_(clips) {}

    /// Opens graphics; needs a screen.
    Result<void> open(const KeptSettings& kept);
    /// Draws the moment, if a picture is due. Null: nothing of the clip is visible.
    Result<void> draw_if_due(const WatchedMoment* moment);
    /// Offline: time begins with the moment, before its picture. Otherwise the first picture begins it.
    void begin_time(WindowClock::time_point at);
    /// Leads the pointer's fingers over the moment. Offline once a tick, otherwise once a picture.
    void lead_fingers(const WatchedMoment& moment);
    /// Draws with the effects of all input so far.
    Result<void> draw_newest();
    Result<void> draw_opening();
    /// Time until the next picture is due without input, ms.
    double left_ms() const { return pause_ms() - 1000 * Clock::seconds_between(last_picture_, Clock::now()); }
    /// Writes the last picture to a file.
    Result<void> keep(const std::filesystem::path& name);
    /// Copies the values last shown at the pointer.
    void copy_values();
    /// Commands from the panel.
    std::vector<WindowCommand> take_asked() { return std::exchange(asked_, {}); }

    ClipPicture& surface() { return surface_; }
    ImGuiLayer& layer() { return *layer_; }
    const std::unique_ptr<WindowFilm>& film() const { return film_; }  ///< null: no film is made

    /// Whether dents of the surface are drawn.
    bool is_dented() const { return is_dented_; }
    void set_dented(bool on) { is_dented_ = on; }

    /// `goes_on`: with the previous clip's colours.
    void begin_clip(bool goes_on);
    /// A new session of the clip begins.
    void forget_session() {
        surface_.forget();
        frames_shown_.forget();
        seen_ = {};  // a picture is due, even if it looks the same
    }
    const FramesShown& frames_shown() const { return frames_shown_; }

private:
    using Clock = WindowClock;

    double scale_of_words(const ScreenSize& size) const;
    Result<void> fit_words(const ScreenSize& size);
    Result<std::unique_ptr<WindowGraphics>> make_graphics();
    Result<void> open_graphics();
    Result<void> open_graphics_anew(const Error& error);
    bool is_due(const WatchedMoment* moment, Clock::time_point now) const;
    bool words_differ(const WatchedMoment* moment);
    int most_samples() const;
    double pause_ms() const;
    double frame_ms() const;
    ViewCamera drawn_camera(const ScreenSize& size) const;
    int vertex_step(const ViewCamera& camera);
    bool pointer_is_on_bar() const;
    Result<void> draw_what_is_there(const WatchedMoment* moment);
    Result<void> add_to_film();
    Result<void> draw(const WatchedMoment& moment);
    PanelFacts facts_of(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera);
    PanelFacts facts_without_clip() const;
    void add_message(PanelFacts& facts) const;
    void note_picture(const PanelFacts& facts, Clock::time_point begin);
    void note_frame(const WatchedMoment& moment, bool is_new);

    WindowState& window_;
    WindowPanel& panel_;
    WindowInput& input_;
    const WindowClips& clips_;
    std::optional<ImGuiLayer> layer_;
    ClipPicture surface_;
    std::unique_ptr<WindowFilm> film_;
    std::vector<WindowCommand> asked_;
    bool is_dented_ = true;
    std::optional<Clock::time_point> lost_at_;  // the last loss of graphics
    DrawnState seen_;
    bool is_offline_ = false;
    Clock::time_point last_picture_, last_words_, frame_came_at_;
    std::vector<FingerHalo> halos_;  // of the last picture
    double last_draw_ms_ = 0;
    bool is_fine_ = false;     // the last picture had all samples that there is room for
    bool is_at_rest_ = false;  // in this picture only words differ from the last one
    std::string shown_message_;
    std::string values_;  // last shown at the pointer
    std::size_t place_lines_ = 0;
    RedrawEstimator redraw_;
    FramesShown frames_shown_;
    PictureGovernor governor_;
    bool coarse_saves_ = false;  // whether coarse drawing reduces the last picture's vertices
};

/// The command that makes a clip with the felt relief; empty: no relief, or unknown.
std::string relief_words(const WindowState& window);

}  // namespace touchable
