#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "player/draw/colour_ramp.hpp"
#include "player/draw/surface_pick.hpp"
#include "player/window/window_loop.hpp"

// A window that nobody watches over.

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

}  // namespace

Result<void> WindowLoop::open_kiosk() {
    kiosk_.emplace(options_.kiosk->times);
    if (auto opened = open_study(); !opened.ok()) return opened;
    if (!options_.kiosk->use_log) return {};
    TRY_ASSIGN(auto log, UseLog::open(*options_.kiosk->use_log));
    use_log_ = std::move(log);
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

/// Whoever set it up learns what its visitors could not read.
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

/// Invites when nobody has been there for a while, and forgets what the last visitor did.
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
    sound_->silence_fingers(invited.has_value());  // nobody is there to hear what shows how
    if (!invited && is_inviting_) pointer_.leave(clip_->fingers());
    is_inviting_ = invited.has_value();
}

/// A clip that did not say how long it is could not be told to loop; a camera does not begin again.
void WindowLoop::begin_anew_at_end() {
    const bool ended =
        clip_->frames() == 0 && !clip_->is_camera() && clip_->session().playback().at_end && clip_repeats();
    if (ended && now_s() > begun_anew_s_ + 1) begin_anew();
}

/// Somebody did something. Of the mouse's force no visitor has to know how it was stopped.
void WindowLoop::welcome(const InputEvent& event) {
    watch_over();  // of a time in which the machine stood still nothing is the visitor's
    const bool has_come = !kiosk_->is_there();
    kiosk_->came(now_s());
    watch_over();  // the finger that showed how goes before the visitor's comes
    const bool presses =
        has_come || event.kind == InputEvent::Kind::pressed || event.kind == InputEvent::Kind::touch_began;
    if (presses && !options_.hand) clip_->set_force(true);
}

/// Says what a finger rests on: to be read, and to be heard by whoever cannot.
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

namespace {

/// What colours mean to a visitor: its name, and where it lies; nothing more, as a kiosk has no words for it.
OverlayScale in_kiosk_words(const OverlayScale& scale, Overlay overlay, const KioskTexts& texts) {
    OverlayScale told = scale;
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

}  // namespace

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
    // What it waits for is said to whoever set it up.
    const bool waits = !state.remark.empty() && !state.has_to_come_out;
    if (study_ && !study_->gives_force() && state.what == HandState::What::off)
        state.what = HandState::What::has_no_force;
    state.words = texts.of_device(waits ? HandState::What::away : state.what);
    if (state.has_to_come_out) state.remark = texts.come_out;
}

void WindowLoop::log_visit(const std::optional<KioskWatch::Visit>& visit) {
    if (!use_log_ || !visit) return;
    const std::chrono::duration<double> ago(now_s() - visit->came_s);
    using Clock = std::chrono::system_clock;
    use_log_->visit(Clock::now() - std::chrono::duration_cast<Clock::duration>(ago), visit->seconds);
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
    if (!ended.ok()) log_fault(ended.error().message);
    use_log_->end(std::chrono::system_clock::now());
    const auto written = use_log_->finish();
    use_log_.reset();
    if (!written.ok() && file_faults_.insert(written.error().message).second) tell(written.error().message);
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

/// A finger that goes by itself over the picture, and really touches it, whoever stopped forces: nearer to
/// the middle where there is nothing to touch farther out. Where a device is held there is none.
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

/// As it was at the start.
void WindowLoop::begin_anew() {
    begun_anew_s_ = now_s();
    lift_touches();
    clip_->view().go_home();
    is_turning_ = false;
    clip_->fingers().set_count(KeptSettings().fingers);
    clip_->fingers().lift();
    // A button that nobody has let go of: on the surface, or on something of the panel, where it clicks
    // nothing, as the pointer goes before it.
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
    if (!study_ && wanted_list_.value_or(playlist_).place() != 0) go_to_first();
}

}  // namespace touchable
