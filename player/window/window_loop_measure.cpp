#include <utility>

#include "player/window/window_loop.hpp"

// Measuring between two places of the surface.

namespace touchable {

void WindowLoop::take_of_measure(const WindowCommand& command) {
    if (command.word == "off") return measure_.let_go();
    if (command.places.empty()) {
        measure_.hold(!measure_.is_held());
        if (measure_.is_held()) set_turning(false);
        if (measure_.is_held() && brush_.is_held())
            take(WindowCommand{.verb = WindowVerb::tool, .word = name_of(BrushTool::touch)});
        if (measure_.is_held())
            say("measure: click two places of the surface, or drag from one to the other");
        return;
    }
    const Scene& scene = clip_->scene();
    for (const PixelOfFrame& place : command.places)
        if (place.x >= scene.width || place.y >= scene.height)
            return say("measure: there is no pixel " + std::to_string(place.x) + ", " +
                           std::to_string(place.y) + "; the depth has " + std::to_string(scene.width) + "x" +
                           std::to_string(scene.height),
                       Tone::refusal);
    measure_.set({command.places[0].x, command.places[0].y}, {command.places[1].x, command.places[1].y});
    const ScreenSize size = screen_->size();
    if (const WatchedMoment* const newest = clip_->session().look())
        measure(*newest, HeightField(scene, newest->held.pair),
                clip_->view().camera(size.width, size.height));
}

/// What is measured in the picture of this moment.
void WindowLoop::measure(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera) {
    const FramePair& pair = moment.held.pair;
    const bool is_there = pointer_is_there_ && !panel_->covers(pointer_at_.x, pointer_at_.y);
    measure_.look({.field = field,
                   .pair = pair,
                   .camera = camera,
                   .stored = moment.stored ? moment.stored->depth : PlaneView{},
                   .frame = pair.blend < 0.5 ? pair.prev.number : pair.next.number,
                   .pointer = is_there ? std::optional(pointer_at_) : std::nullopt});
    constexpr std::size_t most_told = 1000;
    for (MeasureTool::News& news : measure_.take_news()) {
        if (news.is_bad)
            say(std::move(news.words), Tone::refusal);
        else if (measured_.size() < most_told)
            measured_.push_back(std::move(news.words));
    }
}

}  // namespace touchable
