#include <chrono>
#include <utility>

#include "player/run/interrupt.hpp"
#include "player/window/window_loop.hpp"

// What differs in a window as long as there is no clip: nobody has named one yet, or it is being opened.

namespace touchable {

bool WindowLoop::needs_clip(WindowVerb verb) {
    switch (verb) {
        case WindowVerb::next:
        case WindowVerb::previous:
        case WindowVerb::mute:
        case WindowVerb::volume:
        case WindowVerb::louder:
        case WindowVerb::help:
        case WindowVerb::dismiss:
        case WindowVerb::leave:
        case WindowVerb::fullscreen:
        case WindowVerb::size:
        case WindowVerb::screenshot:
        case WindowVerb::open:
        case WindowVerb::quit:
            return false;
        default:
            return true;
    }
}

/// A visitor is told nothing: the clip is soon there.
void WindowLoop::refuse_without_clip() {
    if (!kiosk_)
        say(opening_.is_busy() ? "there is no clip yet" : "there is no clip yet: drop one on the window",
            Tone::refusal);
}

/// Until there is a clip. A finger behind the eye makes graphics ready for those that will touch, and half
/// the size for a governor that will want it: compiling what they are drawn by would make a picture come
/// late. What is shown counts as the window's first picture only where no clip was named for it.
Result<void> WindowLoop::draw_opening() {
    const auto since = seconds_between(last_picture_, Clock::now());
    last_picture_ = Clock::now();
    first_event_.reset();
    const ScreenSize size = screen_->size();
    if (size.width < 1 || size.height < 1) {  // minimised
        events_.clear();
        return {};
    }
    notices_.pass(time_s_);
    if (auto fitted = fit_words(size); !fitted.ok()) return fitted;
    WindowGraphics& graphics = picture_.graphics();
    if (auto begun = graphics.begin(); !begun.ok()) return begun;
    Scene scene;
    scene.width = scene.height = 2;
    scene.camera = {1, 1, 0.5, 0.5};
    const glm::dvec3 behind(0, 0, 10);
    FingerMark finger{behind, behind, {0, 0, 1}, true, {behind, behind + 1.0}};
    finger.under = UnderFinger{behind, {0, 0, 1}};
    finger.given_way = {0, 0, -1};
    const int part = graphics.can_stretch() ? 2 : 1;
    const ViewCamera camera =
        own_view(scene, std::max(size.width / part, 1), std::max(size.height / part, 1), 0.1);
    if (auto drawn = graphics.draw(camera, {{finger}}, {}, size.width, size.height); !drawn.ok())
        return drawn;
    PanelFacts facts;
    facts.is_empty = waits_for_wish() && !opening_.is_busy();
    if (!kiosk_) {
        facts.message_is_bad = !notices_.passing().empty() && notices_.is_refusal();
        if (!notices_.passing().empty())
            facts.message = notices_.passing();
        else if (opening_.is_busy())
            facts.message = opening_.words() + " ...";
        facts.faults = {notices_.faults().begin(), notices_.faults().end()};
    }
    for (int k = 0; k < 2; ++k) {  // a box of words has its size the second time
        layer_->begin(size.width, size.height, k == 0 ? since : 1e-3, std::exchange(events_, {}));
        panel_->draw_without_clip(facts, size.width, size.height, asked_);
        layer_->end();
    }
    if (auto shown = graphics.finish(); !shown.ok()) return shown;
    if (!begun_ && waits_for_wish()) {
        begun_ = Clock::now();
        begun_cpu_ms_ = thread_cpu_ms();
        figures_.first_picture_ms = 1000 * seconds_between(asked_for_, *begun_);
    }
    if (begun_) ++figures_.pictures;
    return {};
}

/// Closed while the first clip was opened, or waited for; or it cannot be opened.
Result<PlayFigures> WindowLoop::end_without_clip(Result<void> ended) {
    opening_.let_go();
    const bool is_kept = ended.ok() && begun_ && options_.screenshot && !interrupted();
    if (is_kept) {
        ended = draw_opening();
        if (ended.ok()) ended = keep_picture(*options_.screenshot);
    }
    if (ended = finish_screenshots(is_kept, std::move(ended)); !ended.ok()) return ended.error();
    if (interrupted()) return interruption();
    if (failure_) return *failure_;
    figures_.seconds = now_s();
    return std::move(figures_);
}

}  // namespace touchable
