// A window that runs unattended, a kiosk, and one whose visitors are the participants of a study.

#include "player/window/window_loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/overlays.hpp"
#include "player/draw/view.hpp"
#include "player/window/keys.hpp"
#include "player/window/panel_parts.hpp"

namespace touchable {
namespace {

/// Where a finger has something to touch all round, as near to the middle as may be: in shares of the
/// picture, above the words. The middle where there is nothing.
glm::dvec2 place_to_show(const HeightField& field, const ViewCamera& camera) {
    constexpr int columns = 13, rows = 8;
    const glm::dvec2 least(0.2, 0.2), most(0.8, 0.55), middle(0.5, 0.44);
    std::array<std::array<bool, rows>, columns> drawn{};
    const auto place = [&](int i, int j) {
        return glm::mix(least, most, glm::dvec2(i / (columns - 1.0), j / (rows - 1.0)));
    };
    for (int i = 0; i < columns; ++i)
        for (int j = 0; j < rows; ++j) {
            const glm::dvec2 at = place(i, j) * glm::dvec2(camera.width, camera.height);
            const auto met = pick(field, camera, at.x, at.y);
            drawn[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = met && met->drawn;
        }
    glm::dvec2 best = middle;
    double best_score = 0;
    for (int i = 1; i + 1 < columns; ++i)
        for (int j = 1; j + 1 < rows; ++j) {
            int round = 0;
            for (int k = 0; k < 9; ++k)
                round +=
                    drawn[static_cast<std::size_t>(i + k % 3 - 1)][static_cast<std::size_t>(j + k / 3 - 1)];
            const double score = round - 6 * glm::distance(place(i, j), middle);
            if (round == 0 || score <= best_score) continue;
            best = place(i, j);
            best_score = score;
        }
    return best;
}

/// What colours mean to a visitor: its name, and where it lies; nothing more, as a kiosk has no words for it.
Overlays::Scale in_kiosk_words(const Overlays::Scale& scale, Overlay overlay, const KioskTexts& texts) {
    Overlays::Scale told = scale;
    told.spread.clear();
    told.has_map = true;
    told.at_holes.reset();
    switch (overlay) {
        case Overlay::stiffness:
            told.name = texts.stiffness;
            break;
        case Overlay::static_friction:
        case Overlay::dynamic_friction:
            told.name = texts.friction;
            break;
        case Overlay::height:
            told.name = texts.height;
            break;
        default:
            told.name = texts.depth;
    }
    if (!scale.everywhere().empty())
        told.classes = {{ramp_colour(0.5),
                         short_number(scale.range.least, 4) + " " + scale.unit + ": " + texts.everywhere}};
    return told;
}

/// Those in whose colours a visitor sees what is felt.
bool is_for_visitors(Overlay overlay) {
    return overlay == Overlay::colour || overlay == Overlay::depth || overlay == Overlay::stiffness ||
           overlay == Overlay::static_friction || overlay == Overlay::height;
}

std::chrono::system_clock::time_point by_the_clock() {
    return std::chrono::system_clock::now();
}

/// What a participant may do during a touch. All participants get the same picture and sound, so colouring,
/// pausing and silencing are not allowed.
bool is_for_participants(WindowVerb verb) {
    using enum WindowVerb;
    return is_one_of(verb, {deeper, point_right, point_down, clutch, recentre, home, turn, tilt, nearer});
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

Result<void> WindowLoop::open_kiosk() {
    kiosk_.emplace(options_.kiosk->times);
    TRY(open_study());
    if (!options_.kiosk->use_log) return {};
    TRY_ASSIGN(use_log_, UseLog::open(*options_.kiosk->use_log));
    use_log_->start(std::chrono::system_clock::now());
    return {};
}

/// Of all that it may have to write.
std::string WindowLoop::kiosk_letters() const {
    if (!options_.kiosk) return {};
    const KioskTexts& texts = options_.kiosk->texts;
    std::string letters = texts.all();
    for (const TouchLabel& label : options_.kiosk->labels.labels)
        if (const std::string* const caption = said_in(label.captions, texts.language)) letters += *caption;
    if (study_) letters += study_->study().all_words(texts.language) + "(0123456789)";  // seconds
    return letters;
}

/// Warns on the terminal of letters that visitors could not read.
void WindowLoop::tell_of_letters() {
    if (const std::string& unwritten = layer_->unwritten(); !unwritten.empty())
        tell(
            "no typeface of this machine has these letters of the kiosk's texts; visitors see a sign in "
            "their place: " +
            unwritten);
    if (const std::string reversed = right_to_left_letters(kiosk_letters()); !reversed.empty())
        tell("the window writes from left to right, and so these letters of the kiosk's texts too: " +
             reversed);
}

/// Whether they go with the clip that they are of.
Result<void> WindowLoop::check_labels() const {
    if (!options_.kiosk || clip_->choice().file != options_.session.clip.file) return {};
    return options_.kiosk->labels.fits(clip_->scene().width, clip_->scene().height, clip_->frames());
}

/// Invites after a while without visitors, and forgets what the last visitor did.
void WindowLoop::watch_over() {
    const double now = now_s();
    try_again();
    if (pointer_.holds() || touches_.holds()) kiosk_->holds(now);
    log_visit(kiosk_->ended(now));
    if (kiosk_->begins_anew(now)) {
        if (study_)
            study_->leave(now, std::chrono::system_clock::now());
        else
            begin_anew();
    }
    begin_anew_at_end();
    if (study_) return;  // whose start screen invites
    const auto invited = kiosk_->invites(now);
    sound_->silence_fingers(invited.has_value());  // no visitor is there to hear the finger that shows how
    if (!invited && is_inviting_) pointer_.leave(clip_->fingers());
    is_inviting_ = invited.has_value();
}

/// A clip that did not say how long it is could not be told to loop; a camera does not begin again.
void WindowLoop::begin_anew_at_end() {
    const bool ended =
        clip_->frames() == 0 && !clip_->is_camera() && clip_->session().playback().at_end && clip_repeats();
    if (ended && now_s() > begun_anew_s_ + 1) begin_anew();
}

/// As it was at the start.
void WindowLoop::begin_anew() {
    begun_anew_s_ = now_s();
    lift_touches();
    clip_->view().go_home();
    is_turning_ = false;
    clip_->fingers().set_count(KeptSettings().fingers);
    clip_->fingers().lift();
    // A button may still be pressed: on the surface, or on something of the panel, where it clicks nothing,
    // as the pointer leaves before it.
    if (!is_inviting_) pointer_.leave(clip_->fingers());
    using Kind = InputEvent::Kind;
    events_.push_back(InputEvent{.kind = Kind::left_window});
    events_.push_back(InputEvent{.kind = Kind::released, .word = "left"});
    if (pointer_is_there_)
        events_.push_back(InputEvent{.kind = Kind::moved, .x = pointer_at_.x, .y = pointer_at_.y});
    clip_->device().set_force(true);
    if (HandControl* const control = clip_->control()) control->begin_anew();
    picture_.set_overlay(Overlay::colour);
    measure_.let_go();
    sound_->set_muted(false);
    if (!clip_->is_camera()) say(playback_->begin_anew(options_.session.playback, clip_repeats()));
    if (next_is_paused_) next_is_paused_ = false;
    if (study_ || wanted_list_.value_or(playlist_).place() == 0) return;
    Playlist list = playlist_;
    list.go_to(0);
    open_instead(std::move(list), 1);
}

/// A clip that broke off may have come back: a disk that was away, a file that was being written.
void WindowLoop::try_again() {
    const auto failure =
        clip_->session().running() ? clip_->session().clip_failure() : clip_->session().failure();
    if (!failure && clip_->session().running()) return;
    if (failure && !told_.contains(failure->message)) say(failure->message, Tone::fault);
    if (now_s() < tried_again_s_ + options_.kiosk->times.reset_s || ready_ || opening_.is_busy()) return;
    tried_again_s_ = now_s();
    ask_for_clip(playlist_, 0, playlist_.now());
}

/// Called on any input of a visitor. The first one of a visit, a press and a touch turn the mouse's force on
/// again without a word, where something had stopped it.
void WindowLoop::welcome(const InputEvent& event) {
    watch_over();  // of a time in which the machine stood still nothing is the visitor's
    const bool has_come = !kiosk_->is_there();
    kiosk_->came(now_s());
    watch_over();  // the finger that showed how goes before the visitor's comes
    const bool presses =
        has_come || event.kind == InputEvent::Kind::pressed || event.kind == InputEvent::Kind::touch_began;
    if (presses && !options_.hand) clip_->set_force(true);
}

/// Moves a finger by itself over the picture; it really touches, even if forces were stopped. It stays nearer
/// to the middle where there is nothing to touch farther out. With a held device there is no such finger.
void WindowLoop::show_how(const HeightField& field, const ViewCamera& camera) {
    if (options_.hand) return;
    clip_->set_force(true);
    constexpr double goes_nearer = 0.03;  // a picture, of its way
    const ShownStroke stroke = stroke_at(kiosk_->invites(now_s()).value_or(0));
    const glm::dvec2 size(camera.width, camera.height);
    if (!stroke.pressed) {
        const glm::dvec2 there = place_to_show(field, camera);
        shown_from_ += glm::clamp(there - shown_from_, glm::dvec2(-goes_nearer), glm::dvec2(goes_nearer));
    }
    const auto place = [&](double share) { return (shown_from_ + stroke.off * share) * size; };
    double share = 1;
    for (const double tried : {1.0, 0.75, 0.5, 0.25, 0.0}) {
        const auto met = pick(field, camera, place(tried).x, place(tried).y);
        if (!met || !met->drawn) continue;
        share = tried;
        break;
    }
    shown_share_ += std::clamp(share - shown_share_, -goes_nearer, goes_nearer);
    clip_->fingers().set_pointer(place(shown_share_));
    clip_->fingers().press(stroke.pressed);
}

/// Says what a finger rests on, as a caption and as a spoken sound.
void WindowLoop::look_for_labels(const WatchedMoment& moment) {
    const TouchLabels& labels = options_.kiosk->labels;
    if (labels.labels.empty() || clip_->choice().file != options_.session.clip.file) return resting_.reset();
    constexpr double reach = 0.03;  // of the picture's width
    if (!resting_) resting_.emplace(reach * clip_->scene().width);
    std::vector<LabelledFinger> fingers;
    const auto count = std::min(moment.felt.fingers.size(), static_cast<std::size_t>(clip_->shown()));
    for (std::size_t k = 0; k < count && !is_inviting_; ++k) {
        const Contact& met = moment.felt.fingers[k].contact;
        LabelledFinger& finger = fingers.emplace_back(LabelledFinger{{met.pixel_x, met.pixel_y}, {}});
        if (met.touching && std::isfinite(met.pixel_x) && std::isfinite(met.pixel_y))
            finger.label = labels.at(finger.pixel, moment.held.pair.prev.number,
                                     brush_.segment_name(moment, finger.pixel));
    }
    if (const auto said = resting_->take(fingers, now_s())) sound_->say(*said);
}

/// After one, for a visitor who goes round.
Overlay WindowLoop::overlay_for_visitors(Overlay now) {
    do now = *overlay_after(now, "");
    while (!is_for_visitors(now));
    return now;
}

KioskFacts WindowLoop::kiosk_facts(const PanelFacts& facts_of_clip) const {
    const KioskOptions& kiosk = *options_.kiosk;
    KioskFacts facts{.texts = kiosk.texts,
                     .by = options_.hand ? TouchedBy::device : kiosk.touched_by,
                     .invited_s = study_ ? std::nullopt : kiosk_->invites(now_s()),
                     .is_turned = !clip_->view().own(),
                     .has_bar = kiosk.has_bar,
                     .is_still = clip_->is_still()};
    if (facts_of_clip.scale)
        facts.scale = in_kiosk_words(*facts_of_clip.scale, picture_.overlay(), kiosk.texts);
    if (resting_ && resting_->shown())
        if (const auto* const caption =
                said_in(kiosk.labels.labels[*resting_->shown()].captions, kiosk.texts.language))
            facts.caption = *caption;
    return facts;
}

/// What a visitor is to know of the device that is held.
void WindowLoop::put_in_kiosk_words(HandState& state) const {
    const KioskTexts& texts = options_.kiosk->texts;
    // Its own remark is for the person who set the device up.
    const bool waits = !state.remark.empty() && !state.has_to_come_out;
    if (study_ && !study_->gives_force() && state.what == HandState::What::off)
        state.what = HandState::What::has_no_force;
    state.words = texts.of_device(waits ? HandState::What::away : state.what);
    if (state.has_to_come_out) state.remark = texts.come_out;
}

void WindowLoop::log_visit(const std::optional<KioskWatch::Visit>& visit) {
    if (!use_log_ || !visit) return;
    const std::chrono::duration<double> ago(now_s() - visit->came_s);
    using WallClock = std::chrono::system_clock;
    use_log_->visit(WallClock::now() - std::chrono::duration_cast<WallClock::duration>(ago), visit->seconds);
}

/// One that goes on, or comes again and again, once an hour.
void WindowLoop::log_fault(const std::string& fault) {
    constexpr double again_s = 3600;
    constexpr std::size_t most_known = 100;
    if (!use_log_) return;
    std::erase_if(logged_faults_, [&](const auto& known) { return now_s() >= known.second + again_s; });
    if (logged_faults_.size() >= most_known || !logged_faults_.try_emplace(fault, now_s()).second) return;
    use_log_->fault(std::chrono::system_clock::now(), fault);
}

/// Whatever ended it is the last but one row.
void WindowLoop::end_log(const Result<void>& ended) {
    if (!use_log_) return;
    if (!ended) log_fault(ended.error().message);
    use_log_->end(std::chrono::system_clock::now());
    const auto written = use_log_->finish();
    use_log_.reset();
    if (!written && file_faults_.insert(written.error().message).second) tell(written.error().message);
}

Result<void> WindowLoop::open_study() {
    if (!options_.study) return {};
    const KioskOptions& kiosk = *options_.kiosk;
    const bool by_touch = kiosk.touched_by == TouchedBy::touch_screen;
    TRY_ASSIGN(study_,
               StudyRun::open(*options_.study, options_.study_results, kiosk.texts.language,
                              options_.hand ? options_.hand->name() : (by_touch ? "touch-screen" : "mouse"),
                              std::make_unique<BackgroundWriter>("study", "a study's results")));
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
    if (event.kind != InputEvent::Kind::key) return false;
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
    // The user of a device can always stop it.
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
                mark.under = FingerMark::Under{under->foot, under->normal, 0};
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
