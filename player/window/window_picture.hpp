#pragma once

// The window's pictures: when one is due, what it shows, and what was measured of it. Each shows the clip at
// the moment that the hand is at, with fingers, words and panels; as long as there is no clip, what is said.
//
// A picture is due when the clip has another frame; while the same one is seen, when something has moved or a
// person does something, and there is time for it before the next. How large and how fine it is drawn follows
// from how long drawing takes (PictureGovernor). Where the GPU is lost, it goes on once with new graphics.
//
// By the window's thread. A film is encoded on a thread of its own (WindowFilm).

#include "player/draw/view.hpp"
#include "player/window/clip_picture.hpp"
#include "player/window/imgui_layer.hpp"
#include "player/window/window_clock.hpp"
#include "player/window/window_files.hpp"
#include "player/window/window_panel.hpp"

namespace touchable {

class OpenedClip;
class WindowCore;
struct KeptSettings;

/// How large words, lines and bars are in a window, as ScreenSize::scale: the display's, and more where the
/// window has more room than 1280x720 of such pixels. By the root of that, because a larger window is meant
/// to show more; `from_afar`, as visitors of a kiosk look, by all of it. In steps of a quarter, so that a
/// window that is being resized seldom changes them.
double words_scale(const ScreenSize& size, bool from_afar);

class WindowPicture {
public:
    explicit WindowPicture(WindowCore& core) : core_(core) {}

    /// What draws; there is a screen.
    Result<void> open(const KeptSettings& kept);
    /// Draws the moment, if that is due. Null: nothing of the clip is there to be seen.
    Result<void> draw_if_due(const WatchedMoment* moment);
    /// With all that was done until now.
    Result<void> draw_newest();
    Result<void> draw_opening();
    /// For how long no picture is due where nothing comes, ms.
    double left_ms() const { return pause_ms() - 1000 * Clock::seconds_between(last_picture_, Clock::now()); }
    /// Keeps what was drawn last as a file.
    Result<void> keep(const std::filesystem::path& name);
    /// What a person asked the panel for.
    std::vector<WindowCommand> take_asked() { return std::exchange(asked_, {}); }

    ClipPicture& surface() { return surface_; }
    ImGuiLayer& layer() { return *layer_; }
    WindowPanel& panel() { return *panel_; }
    const std::unique_ptr<WindowFilm>& film() const { return film_; }  ///< null: none is made
    bool panel_covers(const glm::dvec2& at) const { return panel_->covers(at.x, at.y); }
    bool is_bar(const glm::dvec2& at) const { return panel_->is_bar(at.x, at.y); }
    /// Whether something of the panel is being pressed or dragged.
    bool holds_pointer() const { return layer_->holds_pointer(); }

    /// Whether a surface that gives way is drawn so.
    bool is_dented() const { return is_dented_; }
    void set_dented(bool on) { is_dented_ = on; }

    /// `goes_on`: with the colours of the clip before.
    void begin_clip(bool goes_on);
    /// Another session of the clip comes.
    void forget_session() {
        surface_.forget();
        frames_shown_.forget();
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
    double pause_ms() const;
    double frame_ms() const;
    ViewCamera drawn_camera(const ScreenSize& size) const;
    int vertex_step(const ViewCamera& camera);
    bool pointer_is_on_bar() const;
    Result<void> draw_what_is_there(const WatchedMoment* moment);
    Result<void> draw(const WatchedMoment& moment);
    PanelFacts facts_of(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera);
    void add_message(PanelFacts& facts) const;
    void note_picture(const PanelFacts& facts, Clock::time_point begin);
    void note_frame(const WatchedMoment& moment, bool is_new);

    WindowCore& core_;
    std::optional<ImGuiLayer> layer_;
    ClipPicture surface_;
    std::optional<WindowPanel> panel_;
    std::unique_ptr<WindowFilm> film_;
    std::vector<WindowCommand> asked_;
    bool is_dented_ = true;
    std::optional<Clock::time_point> lost_at_;  // when graphics were last
    DrawnState seen_;
    Clock::time_point last_picture_, frame_came_at_;
    double last_draw_ms_ = 0;
    std::string shown_message_;
    std::size_t place_lines_ = 0;
    RedrawEstimator redraw_;
    FramesShown frames_shown_;
    PictureGovernor governor_;
    bool coarse_saves_ = false;  // vertices of the last picture, if it is coarse
};

/// What keeps the relief that is felt; empty: there is none.
std::string relief_words(WindowCore& core);

}  // namespace touchable
