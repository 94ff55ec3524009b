// SPDX-License-Identifier: Apache-2.0
#include "player/window/kiosk_mode.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/draw/overlays.hpp"
#include "player/window/command_table.hpp"
#include "player/window/window_brush.hpp"
#include "player/window/window_input.hpp"

namespace touchable {
namespace {

/// A place, in shares of the picture, above the texts, that is surrounded by surface and as near to the
/// middle as possible. The middle if there is no surface.
glm::dvec2 place_to_show(const HeightField& field, const ViewCamera& camera) {
    constexpr int columns = 13, rows = 8;
    const glm::dvec2 least(0.2, 0.2), most(0.8, 0.55), middle(0.5, 0.44);
    bool drawn[columns][rows];
    const auto place = [&](int i, int j) {
        return glm::mix(least, most, glm::dvec2(i / (columns - 1.0), j / (rows - 1.0)));
    };
    for (int i = 0; i < columns; ++i)
        for (int j = 0; j < rows; ++j) {
            const glm::dvec2 at = place(i, j) * glm::dvec2(camera.width, camera.height);
            const auto met = pick(field, camera, at.x, at.y);
            drawn[i][j] = met && met->drawn;
        }
    glm::dvec2 best = middle;
    double best_score = 0;
    for (int i = 1; i + 1 < columns; ++i)
        for (int j = 1; j + 1 < rows; ++j) {
            int round = 0;
            for (int k = 0; k < 9; ++k) round += drawn[i + k % 3 - 1][j + k / 3 - 1];
            const double score = round - 6 * glm::distance(place(i, j), middle);
            if (round == 0 || score <= best_score) continue;
            best = place(i, j);
            best_score = score;
        }
    return best;
}

/// An overlay's scale for visitors: name and range only, as a kiosk has no texts for more.
Overlays::Scale in_kiosk_words(const Overlays::Scale& scale, Overlay overlay, const KioskTexts& texts) {
    Overlays::Scale told = scale;
    told.spread.clear();
    told.has_map = true;
    told.at_holes.reset();
    const bool is_friction = overlay == Overlay::static_friction || overlay == Overlay::dynamic_friction;
    told.name = is_friction                     ? texts.friction
                : overlay == Overlay::stiffness ? texts.stiffness
                : overlay == Overlay::height    ? texts.height
                                                : texts.depth;
    if (!scale.everywhere().empty())
        told.classes = {{ramp_colour(0.5),
                         short_number(scale.range.least, 4) + " " + scale.unit + ": " + texts.everywhere}};
    return told;
}

/// Overlays that show visitors what they feel.
bool is_for_visitors(Overlay overlay) {
    return overlay == Overlay::colour || overlay == Overlay::depth || overlay == Overlay::stiffness ||
           overlay == Overlay::static_friction || overlay == Overlay::height;
}

/// The next overlay for visitors, cyclically.
Overlay overlay_for_visitors(Overlay now) {
    do now = *overlay_after(now, "");
    while (!is_for_visitors(now));
    return now;
}

}  // namespace

Result<void> KioskMode::open_log() {
    const auto& file = window_.options.kiosk->use_log;
    if (!file) return {};
    TRY_ASSIGN(log_, UseLog::open(*file));
    log_->start(std::chrono::system_clock::now());
    return {};
}

/// Letters of all its texts.
std::string KioskMode::letters() const {
    std::string letters = texts().all();
    for (const TouchLabel& label : window_.options.kiosk->labels.labels)
        if (const std::string* const caption = said_in(label.captions, texts().language)) letters += *caption;
    return letters;
}

/// Warns on the terminal of letters that visitors cannot read.
void KioskMode::begin() {
    window_.sound->set_spoken(window_.options.kiosk->label_sounds);
    if (const std::string& unwritten = picture_.layer().unwritten(); !unwritten.empty())
        window_.tell(
            "no typeface of this machine has these letters of the kiosk's texts; visitors see a sign in "
            "their place: " +
            unwritten);
    if (const std::string reversed = right_to_left_letters(letters()); !reversed.empty())
        window_.tell("the window writes from left to right, and so these letters of the kiosk's texts too: " +
                     reversed);
}

bool KioskMode::handle(const InputEvent& event) {
    if (!allows(event)) return true;
    if (window_.clip && is_a_visit(event)) welcome(event);
    return false;
}

/// Visitors step only through overlays of what they feel, and see no message about a missing clip.
bool KioskMode::handle(const WindowCommand& command) {
    if (!window_.clip && !row_of(command.verb).has(CommandRow::without_clip)) return true;
    if (command.verb != WindowVerb::overlay || !command.word.empty()) return false;
    ClipPicture& surface = picture_.surface();
    surface.set_overlay(overlay_for_visitors(surface.overlay()));
    return true;
}

void KioskMode::look(const WatchedMoment& moment) {
    if (!window_.options.hand || moment.felt.fingers.empty()) return;
    const glm::dvec3 goal = moment.felt.fingers[0].goal, way = goal - hand_seen_at_;
    const double far = window_.clip->sizes().finger_radius / 2;
    if (glm::dot(way, way) < far * far || !(glm::dot(goal, goal) >= 0)) return;
    hand_seen_at_ = goal;
    // After a change of clip or a reset, a resting hand maps to another place of the clip's world.
    constexpr double mapped_s = 0.5;
    const double now_s = window_.time.now_s();
    if (now_s > restored_s_ + mapped_s) came(now_s);
}

/// Starts the invitation and the reset after a visit.
void KioskMode::tick(double now_s) {
    open_again();
    if (input_.holds()) watch_.holds(now_s);
    log_visit(watch_.ended(now_s));
    if (watch_.begins_anew(now_s)) end_visit(now_s);
    // A clip of unknown length cannot loop, so it is restarted; a camera does not restart.
    const OpenedClip& clip = *window_.clip;
    const bool has_ended =
        clip.frames() == 0 && !clip.is_camera() && clip.session().playback().at_end && repeats_clip();
    if (has_ended && window_.time.now_s() > restored_s_ + 1) restore();
    invite(now_s);
}

void KioskMode::invite(double now_s) {
    const auto invited = watch_.invites(now_s);
    window_.sound->silence_fingers(invited.has_value());  // the demonstration is silent
    if (!invited && is_inviting_) input_.leave_picture();
    is_inviting_ = invited.has_value();
}

void KioskMode::end_visit(double) {
    restore();
    if (clips_.wanted_list().place() == 0) return;
    Playlist list = clips_.list();
    list.go_to(0);
    clips_.open_instead(std::move(list), 1);
}

void KioskMode::restore() {
    restored_s_ = window_.time.now_s();
    OpenedClip& clip = *window_.clip;
    input_.lift_touches();
    for (WindowMode* const mode : window_.modes) mode->begin_anew();
    clip.fingers().set_count(KeptSettings().fingers);
    clip.fingers().lift();
    // Releases buttons still pressed on the surface or the panel.
    if (!is_inviting_) input_.leave_picture();
    input_.release_panel();
    clip.device()->set_force(true);
    if (HandControl* const control = clip.control()) control->begin_anew();
    picture_.surface().set_overlay(Overlay::colour);
    window_.sound->set_muted(false);
    if (!clip.is_camera())
        window_.say(window_.playback->begin_anew(window_.options.session.playback, repeats_clip()));
    clips_.play_next();
}

/// Reopens a failed clip, as its disk may be back, or its file complete.
void KioskMode::open_again() {
    const OpenedClip& clip = *window_.clip;
    const auto failure = fault_of(clip);
    if (!failure && clip.session().running()) return;
    if (failure && !window_.is_told(failure->message)) window_.say(failure->message, Tone::fault);
    const double now_s = window_.time.now_s();
    if (now_s < tried_again_s_ + window_.options.kiosk->times.reset_s || clips_.is_busy()) return;
    tried_again_s_ = now_s;
    clips_.open_again();
}

/// Called on any visitor input. The first input of a visit, a press or a touch switches the mouse's stopped
/// force on again, silently.
void KioskMode::welcome(const InputEvent& event) {
    tick(window_.time.now_s());  // time while the machine stood still does not count for the visitor
    const bool has_come = !watch_.is_there();
    came(window_.time.now_s());
    tick(window_.time.now_s());  // the demonstrating finger leaves first
    const bool presses =
        has_come || event.kind == InputEvent::Kind::pressed || event.kind == InputEvent::Kind::touch_began;
    if (presses && !window_.options.hand) window_.clip->set_force(true);
}

/// During the invitation, moves a finger over the picture; it really touches, even if forces were stopped. It
/// stays nearer to the middle where the surface ends. With a haptic device there is no such finger.
void KioskMode::prepare(const Seen& seen) {
    if (!is_inviting_ || window_.options.hand) return;
    OpenedClip& clip = *window_.clip;
    clip.set_force(true);
    constexpr double goes_nearer = 0.03;  // a picture, of its path
    const ShownStroke stroke = stroke_at(watch_.invites(window_.time.now_s()).value_or(0));
    const glm::dvec2 size(seen.camera.width, seen.camera.height);
    if (!stroke.pressed) {
        const glm::dvec2 there = place_to_show(seen.field, seen.camera);
        shown_from_ += glm::clamp(there - shown_from_, glm::dvec2(-goes_nearer), glm::dvec2(goes_nearer));
    }
    const auto place = [&](double share) { return (shown_from_ + stroke.off * share) * size; };
    double share = 1;
    for (const double tried : {1.0, 0.75, 0.5, 0.25, 0.0}) {
        const auto met = pick(seen.field, seen.camera, place(tried).x, place(tried).y);
        if (!met || !met->drawn) continue;
        share = tried;
        break;
    }
    shown_share_ += std::clamp(share - shown_share_, -goes_nearer, goes_nearer);
    clip.fingers().set_pointer(place(shown_share_));
    clip.fingers().press(stroke.pressed);
}

/// Announces the label under a resting finger, as a caption and as a spoken sound.
void KioskMode::look_for_labels(const WatchedMoment& moment) {
    const TouchLabels& labels = window_.options.kiosk->labels;
    const OpenedClip& clip = *window_.clip;
    if (labels.labels.empty() || clip.choice().file != window_.options.session.clip.file)
        return resting_.reset();
    constexpr double reach = 0.03;  // of the picture's width
    if (!resting_) resting_.emplace(reach * clip.scene().width);
    std::vector<LabelledFinger> fingers;
    const auto count = std::min(moment.felt.fingers.size(), static_cast<std::size_t>(clip.shown()));
    for (std::size_t k = 0; k < count && !is_inviting_; ++k) {
        const Contact& met = moment.felt.fingers[k].contact;
        LabelledFinger& finger = fingers.emplace_back(LabelledFinger{{met.pixel_x, met.pixel_y}, {}});
        if (met.touching && std::isfinite(met.pixel_x) && std::isfinite(met.pixel_y))
            finger.label = labels.at(finger.pixel, moment.held.pair.prev.number,
                                     brush_.segment_name(moment, finger.pixel));
    }
    if (const auto said = resting_->take(fingers, window_.time.now_s())) window_.sound->say(*said);
}

void KioskMode::draw(PanelFacts& facts, const Seen& seen) {
    look_for_labels(seen.moment);
    const PlayOptions::Kiosk& kiosk = *window_.options.kiosk;
    const OpenedClip& clip = *window_.clip;
    KioskFacts& shown =
        facts.kiosk.emplace(KioskFacts{.texts = kiosk.texts,
                                       .by = window_.options.hand ? TouchedBy::device : kiosk.touched_by,
                                       .invited_s = watch_.invites(window_.time.now_s()),
                                       .is_turned = !clip.view().own(),
                                       .has_bar = kiosk.has_bar,
                                       .is_still = clip.is_still()});
    if (facts.scale) shown.scale = in_kiosk_words(*facts.scale, picture_.surface().overlay(), kiosk.texts);
    if (resting_ && resting_->shown())
        if (const auto* const caption =
                said_in(kiosk.labels.labels[*resting_->shown()].captions, kiosk.texts.language))
            shown.caption = *caption;
    if (!facts.hand) return;
    HandState& state = facts.hand->state;
    // The device's own remark is for the operator.
    const bool waits = !state.remark.empty() && !state.has_to_come_out;
    state.what = state_of(state.what);
    state.words = kiosk.texts.of_device(waits ? HandState::What::away : state.what);
    if (state.has_to_come_out) state.remark = kiosk.texts.come_out;
}

void KioskMode::log_visit(const std::optional<KioskWatch::Visit>& visit) {
    if (!log_ || !visit) return;
    const std::chrono::duration<double> ago(window_.time.now_s() - visit->came_s);
    using WallClock = std::chrono::system_clock;
    log_->visit(WallClock::now() - std::chrono::duration_cast<WallClock::duration>(ago), visit->seconds);
}

/// A lasting or repeated fault is logged once an hour.
void KioskMode::note_fault(const std::string& fault) {
    constexpr double again_s = 3600;
    constexpr std::size_t most_known = 100;
    if (!log_) return;
    const double now_s = window_.time.now_s();
    std::erase_if(logged_faults_, [&](const auto& known) { return now_s >= known.second + again_s; });
    if (logged_faults_.size() >= most_known || !logged_faults_.try_emplace(fault, now_s).second) return;
    log_->fault(std::chrono::system_clock::now(), fault);
}

/// The fault that ended the window is the log's last row but one.
void KioskMode::close(const Result<void>& ended) {
    log_visit(watch_.end());
    if (!log_) return;
    if (!ended) note_fault(ended.error().message);
    log_->end(std::chrono::system_clock::now());
    const auto written = log_->finish();
    log_.reset();
    if (!written && window_.is_new_fault(written.error())) window_.tell(written.error().message);
}

}  // namespace touchable
