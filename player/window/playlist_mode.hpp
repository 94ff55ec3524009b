#pragma once

#include "player/window/user_files.hpp"
#include "player/window/window_mode.hpp"

namespace touchable {

/// The list of clips, and the place in it: a person goes through it by keys, and at the end of a clip that
/// does not repeat the window goes on by itself.
class PlaylistMode final : public WindowMode {
public:
    using WindowMode::WindowMode;

    const Playlist& list() const { return list_; }
    void set_list(Playlist list) { list_ = std::move(list); }
    /// One on, or back.
    void go(int by);
    /// From the clip's end to the next clip. A clip that is over in a blink rests first. The clip also stays
    /// while it is touched or painted, or something of the panel is dragged, and some seconds after that.
    void go_on(double now_s) override;
    void begin_clip(bool goes_on) override;
    void draw(PanelFacts& facts, const Seen&) override { facts.clips = list_.size(); }

private:
    bool is_touched() const;

    Playlist list_;                    // of the clip that is there
    std::optional<double> went_on_s_;  // to the next clip by itself, or tried to: at this end
    double shown_s_ = 0;               // since when the clip is
    std::optional<double> touched_s_;  // when a clip was last touched, painted or measured
};

}  // namespace touchable
