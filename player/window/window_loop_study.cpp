#include <chrono>
#include <cmath>
#include <utility>

#include "engine/base/try.hpp"
#include "player/draw/under_finger.hpp"
#include "player/window/window_loop.hpp"

// A kiosk whose visitors are the participants of a study.

namespace touchable {
namespace {

using Kind = InputEvent::Kind;

std::chrono::system_clock::time_point by_the_clock() {
    return std::chrono::system_clock::now();
}

/// What a participant may do while he touches: what everybody has before him is the same, so nobody colours,
/// pauses or silences it.
bool is_for_participants(WindowVerb verb) {
    switch (verb) {
        case WindowVerb::deeper:
        case WindowVerb::point_right:
        case WindowVerb::point_down:
        case WindowVerb::clutch:
        case WindowVerb::recentre:
        case WindowVerb::home:
        case WindowVerb::turn:
        case WindowVerb::tilt:
        case WindowVerb::nearer:
            return true;
        default:
            return false;
    }
}

/// Of a digit: the number on a scale, or the place among choices.
std::optional<std::size_t> answer_of(const std::string& key, const StudyQuestion& question) {
    if (key.size() != 1 || key[0] < '0' || key[0] > '9') return std::nullopt;
    if (!question.is_scale) return key[0] == '0' ? std::nullopt : std::optional<std::size_t>(key[0] - '1');
    for (std::size_t k = 0; k < question.answers.size(); ++k)
        if (question.answers[k].value == key) return k;
    return std::nullopt;
}

}  // namespace

Result<void> WindowLoop::open_study() {
    if (!options_.study) return {};
    const KioskOptions& kiosk = *options_.kiosk;
    const bool by_touch = kiosk.touched_by == TouchedBy::touch_screen;
    TRY_ASSIGN(auto disk, DiskWork::start("study", "that writes a study's results"));
    TRY_ASSIGN(auto run,
               StudyRun::open(options_.study->study, options_.study->results, kiosk.texts.language,
                              options_.hand ? options_.hand->name() : (by_touch ? "touch-screen" : "mouse"),
                              std::move(disk)));
    study_ = std::move(run);
    options_.meter = study_->meter();
    const double idle_s = study_->study().idle_s;
    kiosk_.emplace(KioskTimes{idle_s, idle_s});
    return {};
}

/// Whether something is before the participant that has all of the window.
bool WindowLoop::study_has_page() const {
    const StudyScreen* const screen = study_->screen();
    return !screen || !screen->is_touch() || !study_clip_is_there();
}

bool WindowLoop::study_clip_is_there() const {
    return study_->clip() == playlist_.place() && !ready_ && !opening_.is_busy();
}

/// Once a turn: the clip that is wanted, the device's buttons, time that has passed.
void WindowLoop::go_on_in_study() {
    constexpr double again_s = 5;  // to open a clip that could not be opened
    const double now = now_s();
    const std::size_t wanted = study_->clip();
    if (study_clip_is_there()) study_asked_.reset();
    const bool has_asked =
        study_asked_ && study_asked_->clip == wanted && time_s_ < study_asked_->at_s + again_s;
    if (!study_clip_is_there() && !opening_.is_busy() && !ready_ && !has_asked) {
        study_asked_ = {wanted, time_s_};
        Playlist list = playlist_;
        list.go_to(wanted);
        open_instead(std::move(list), 0);
    }
    if (study_->screen() && study_->screen()->is_touch() && !study_clip_is_there()) study_->wait(now);
    take_of_study_hand();
    study_->pass(now, by_the_clock());
    if (study_->turn() != std::exchange(study_turn_, study_->turn())) {
        begin_anew();
        last_event_ = Clock::now();
    }
    const bool has_page = study_has_page();
    sound_->set_muted(has_page);
    sound_->silence_fingers(!study_->gives_force());
    if (HandControl* const control = clip_->control())
        control->allow_force(study_->gives_force() && !has_page);
}

/// The first button says "continue" to a page. The second one goes through a question's answers; in a touch
/// it stops forces, and where there are none says "continue".
void WindowLoop::take_of_study_hand() {
    HandControl* const control = clip_->control();
    if (!control) return;
    const bool had_force = std::exchange(study_had_force_, control->force_is_asked());
    const bool first = control->take_presses(0) > 0, second = control->take_presses(1) > 0;
    const bool has_page = study_has_page();
    if (second && has_page) study_->choose_by(1);
    if ((first && has_page) || (second && !has_page && !had_force)) study_->go_on(now_s(), by_the_clock());
    if (!first && !second) return;
    kiosk_->came(now_s());
    last_event_ = Clock::now();
}

/// Whether the study takes the event: every key but those by which a participant touches, turns the view, or
/// stops the force.
bool WindowLoop::take_of_study(const InputEvent& event) {
    if (event.kind != Kind::key) return false;
    const bool has_page = study_has_page();
    const StudyScreen* const screen = study_->screen();
    if (has_page && screen && screen->question)
        if (const auto answer = answer_of(event.word, *screen->question)) study_->choose(*answer);
    if (has_page && (event.word == "left" || event.word == "up")) study_->choose_by(-1);
    if (has_page && (event.word == "right" || event.word == "down")) study_->choose_by(1);
    if (!event.repeated && (event.word == "enter" || (has_page && event.word == "space")))
        study_->go_on(now_s(), by_the_clock());
    last_event_ = Clock::now();
    if (has_page) return !event.stopped_force;  // the window says that the force is off
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    if (!binding) return true;
    // Whoever holds a device can always stop it.
    if (binding->verb == WindowVerb::force && options_.hand)
        return !clip_->force_is_on() && !study_->gives_force();
    return !is_for_participants(binding->verb);
}

void WindowLoop::take_of_study(const WindowCommand& command) {
    if (!study_) return say("there is no study in this window", Tone::refusal);
    if (command.verb == WindowVerb::answer)
        study_->choose(static_cast<std::size_t>(command.number) - 1);
    else
        study_->go_on(now_s(), by_the_clock());
}

/// Without its force a finger is on the surface where the hand is: nothing holds it back, and nothing gives
/// way.
void WindowLoop::hide_forces(std::vector<FingerMark>& marks, const HeightField& field) const {
    for (FingerMark& mark : marks) {
        if (mark.touching)
            if (const auto under = under_finger(field, mark.goal, clip_->sizes().finger_radius)) {
                mark.proxy = under->foot;
                mark.under = UnderFinger{under->foot, under->normal, 0};
            }
        mark.goal = mark.proxy;
        mark.force = mark.given_way = glm::dvec3(0.0);
        mark.touching = false;
        mark.trail.clear();
    }
}

/// What of the picture's height is below the picture that a participant touches.
double WindowLoop::study_strip(const ScreenSize& size) const {
    if (!study_ || study_has_page()) return 0;
    const auto height = static_cast<float>(size.height);
    return static_cast<double>(study_strip_height(static_cast<float>(size.width), height) / height);
}

StudyFacts WindowLoop::study_facts() const {
    const KioskTexts& texts = options_.kiosk->texts;
    const auto said = [&](const StudyWords& words) {
        const std::string* const found = said_in(words, study_->language());
        return found ? *found : std::string();
    };
    StudyFacts facts;
    facts.is_page = study_has_page();
    facts.shows_force = study_->gives_force();
    facts.go_on = texts.study_continue;
    facts.may_go_on = study_->may_go_on(now_s());
    facts.share_done = study_->share_done();
    if (study_->wait_s(now_s()) > 0 && study_->screen() &&
        study_->screen()->step->least_s > StudyRun::least_s)
        facts.wait_s = static_cast<int>(std::ceil(study_->wait_s(now_s())));
    if (study_->fault()) facts.fault = texts.study_not_kept;
    const StudyScreen* const screen = study_->screen();
    if (!screen) {
        facts.title = said(study_->study().title);
        facts.words = said(study_->study().words);
        facts.go_on = texts.study_begin;
        return facts;
    }
    if (facts.is_page && screen->is_touch()) {
        facts.words = texts.study_wait;
        facts.go_on.clear();
        return facts;
    }
    facts.title = said(screen->step->title);
    facts.words = said(screen->question ? screen->question->words : screen->step->words);
    facts.chosen = study_->chosen();
    if (!screen->question) return facts;
    facts.is_scale = screen->question->is_scale;
    facts.low = said(screen->question->low);
    facts.high = said(screen->question->high);
    for (const StudyAnswer& answer : screen->question->answers) facts.answers.push_back(said(answer.words));
    return facts;
}

}  // namespace touchable
