#include "player/window/measure_mode.hpp"

#include <cstdio>

#include "player/window/window_core.hpp"

namespace touchable {

void MeasureMode::take(const WindowCommand& command) {
    if (command.word == "off") return let_go();
    if (command.places.empty()) {
        tool_.hold(!tool_.is_held());
        if (!tool_.is_held()) return;
        core_.take_button(*this);
        return core_.say("measure: click two places of the surface, or drag from one to the other");
    }
    OpenedClip& clip = *core_.clip();
    const Scene& scene = clip.scene();
    for (const PixelOfFrame& place : command.places)
        if (place.x >= scene.width || place.y >= scene.height)
            return core_.say("measure: there is no pixel " + std::to_string(place.x) + ", " +
                                 std::to_string(place.y) + "; the depth has " + std::to_string(scene.width) +
                                 "x" + std::to_string(scene.height),
                             Tone::refusal);
    tool_.set({command.places[0].x, command.places[0].y}, {command.places[1].x, command.places[1].y});
    const ScreenSize size = core_.screen().size();
    if (const WatchedMoment* const newest = clip.session().look())
        prepare(
            {*newest, HeightField(scene, newest->held.pair), clip.view().camera(size.width, size.height)});
}

bool MeasureMode::handle_pointer(const InputEvent& event, bool is_of_panel) {
    return !is_of_panel && tool_.take(event, core_.input().pointer());
}

bool MeasureMode::leave() {
    if (!tool_.is_held() && !tool_.has_line()) return false;
    let_go();
    return true;
}

/// What is measured in the picture of this moment.
void MeasureMode::prepare(const Seen& seen) {
    const FramePair& pair = seen.moment.held.pair;
    tool_.look({.field = seen.field,
                .pair = pair,
                .camera = seen.camera,
                .stored = seen.moment.stored ? seen.moment.stored->depth : PlaneView{},
                .frame = pair.blend < 0.5 ? pair.prev.number : pair.next.number,
                .pointer = core_.input().pointer_over_picture()});
    constexpr std::size_t most_told = 1000;
    for (MeasureTool::News& news : tool_.take_news()) {
        if (news.is_bad)
            core_.say(std::move(news.words), Tone::refusal);
        else if (lines_.size() < most_told)
            lines_.push_back(std::move(news.words));
    }
}

void MeasureMode::draw(PanelFacts& facts, const Seen& seen) {
    facts.measure = tool_.facts(seen.camera, core_.clip()->scene());
}

}  // namespace touchable
