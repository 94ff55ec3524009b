// SPDX-License-Identifier: Apache-2.0
#include "engine/base/try.hpp"
#include "player/window/command_table.hpp"
#include "player/window/kiosk_mode.hpp"
#include "player/window/panel_parts.hpp"
#include "player/window/study.hpp"

namespace touchable {
namespace {

std::chrono::system_clock::time_point by_the_clock() {
    return std::chrono::system_clock::now();
}

/// The answer for a digit: a number on a scale, or a position among choices.
std::optional<std::size_t> answer_of(const std::string& key, const StudyQuestion& question) {
    if (key.size() != 1 || key[0] < '0' || key[0] > '9') return std::nullopt;
    if (!question.is_scale) return key[0] == '0' ? std::nullopt : std::optional<std::size_t>(key[0] - '1');
    for (std::size_t k = 0; k < question.answers.size(); ++k)
        if (question.answers[k].value == key) return k;
    return std::nullopt;
}

/// A kiosk whose visitors are a study's participants (study.hpp): guides them through its screens, with keys,
/// buttons and a haptic device, and gives forces and sound if a screen allows them.
class StudyMode final : public KioskMode {
public:
    StudyMode(WindowState& window, const Parts& parts, std::unique_ptr<StudyRun> run)
        : KioskMode(window, parts, {run->study().idle_s, run->study().idle_s}), run_(std::move(run)) {}

    bool handle(const InputEvent& event) override {
        if (KioskMode::handle(event)) return true;
        return window_.clip && event.kind == InputEvent::Kind::key && take_key(event);
    }
    bool handle(const WindowCommand& command) override {
        if (KioskMode::handle(command)) return true;
        switch (command.verb) {
            case WindowVerb::answer:
                run_->choose(static_cast<std::size_t>(command.number) - 1);
                return true;
            case WindowVerb::go_on:
                go_to_next();
                return true;
            case WindowVerb::open:
                window_.say("a study shows only its own clips", Tone::refusal);
                return true;
            default:
                return false;
        }
    }
    /// Requests the needed clip, polls the device's buttons, advances time.
    void go_on(double now_s) override {
        if (!window_.time.begun) return;
        ask_for_clip();
        if (run_->screen() && run_->screen()->is_touch() && !clip_is_there()) run_->wait(now_s);
        take_buttons();
        run_->pass(now_s, by_the_clock());
        if (run_->turn() != std::exchange(turn_, run_->turn())) {
            restore();
            window_.time.note_event();
        }
        const bool is_page = has_page();
        window_.sound->set_muted(is_page);
        window_.sound->silence_fingers(!run_->gives_force());
        if (HandControl* const control = window_.clip->control())
            control->allow_force(run_->gives_force() && !is_page);
    }
    void draw(PanelFacts& facts, const Seen& seen) override {
        KioskMode::draw(facts, seen);
        facts.kiosk->invited_s.reset();
        facts.study = page_facts();
    }
    Result<void> finish() override { return run_->end(window_.time.now_s(), by_the_clock()); }
    bool is_at_work() const override { return run_->is_beginning(); }
    bool repeats_clip() const override { return true; }
    bool keeps_view() const override { return false; }
    bool chooses_clip() const override { return true; }
    /// A touch trial is measured in one session.
    bool keeps_session() const override { return run_->screen() && run_->screen()->is_touch(); }
    bool hides_forces() const override { return !run_->gives_force(); }
    /// Share of the picture's height below the picture that a participant touches.
    double strip_below(const ScreenSize& size) const override {
        if (has_page()) return 0;
        const auto height = static_cast<float>(size.height);
        return static_cast<double>(study_strip_height(static_cast<float>(size.width), height) / height);
    }
    std::string letters() const override {
        return KioskMode::letters() + run_->study().all_words(texts().language) + "(0123456789)";  // seconds
    }
    std::vector<Error> faults() const override {
        std::vector<Error> all = KioskMode::faults();
        if (const auto fault = run_->fault()) all.push_back(*fault);
        return all;
    }

private:
    /// Every key belongs to the study.
    bool allows(const InputEvent& event) const override {
        return (window_.clip && event.kind == InputEvent::Kind::key) || KioskMode::allows(event);
    }
    void end_visit(double now_s) override { run_->leave(now_s, by_the_clock()); }
    /// The study's start screen is its invitation.
    void invite(double) override {}
    HandState::What state_of(HandState::What what) const override {
        return !run_->gives_force() && what == HandState::What::off ? HandState::What::has_no_force : what;
    }

    /// Whether a page covers the whole window.
    bool has_page() const {
        const StudyScreen* const screen = run_->screen();
        return !screen || !screen->is_touch() || !clip_is_there();
    }
    bool clip_is_there() const { return run_->clip() == clips_.list().place() && !clips_.is_busy(); }
    /// Requests the needed clip, unless it is there or being opened.
    void ask_for_clip() {
        constexpr double again_s = 5;  // retry interval for a clip that could not be opened
        if (clip_is_there()) return asked_.reset();
        const std::size_t wanted = run_->clip();
        const double now_s = window_.time.script_s;
        if (clips_.is_busy() || (asked_ && asked_->clip == wanted && now_s < asked_->at_s + again_s)) return;
        asked_ = {wanted, now_s};
        Playlist list = clips_.list();
        list.go_to(wanted);
        clips_.open_instead(std::move(list), 0);
    }
    /// The first button continues on a page. The second one steps through a question's answers; during a
    /// touch it stops forces, and without forces continues.
    void take_buttons() {
        HandControl* const control = window_.clip->control();
        if (!control) return;
        const bool had_force = std::exchange(had_force_, control->force_is_asked());
        const bool first = control->take_presses(0) > 0, second = control->take_presses(1) > 0;
        const bool is_page = has_page();
        if (second && is_page) run_->choose_by(1);
        if ((first && is_page) || (second && !is_page && !had_force)) go_to_next();
        if (!first && !second) return;
        came(window_.time.now_s());
        window_.time.note_event();
    }
    /// Whether the study takes the key: all but those with which a participant touches, turns the view, or
    /// stops the force.
    bool take_key(const InputEvent& event) {
        const bool is_page = has_page();
        const StudyScreen* const screen = run_->screen();
        if (is_page && screen && screen->question)
            if (const auto answer = answer_of(event.word, *screen->question)) run_->choose(*answer);
        if (is_page && (event.word == "left" || event.word == "up")) run_->choose_by(-1);
        if (is_page && (event.word == "right" || event.word == "down")) run_->choose_by(1);
        if (!event.repeated && (event.word == "enter" || (is_page && event.word == "space"))) go_to_next();
        window_.time.note_event();
        if (is_page) return !event.stopped_force;  // the window reports that the force is off
        const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
        if (!binding) return true;
        // A device's user can always stop its force.
        if (binding->verb == WindowVerb::force && window_.options.hand)
            return !window_.clip->force_is_on() && !run_->gives_force();
        return !row_of(binding->verb).has(CommandRow::for_participants);
    }
    void go_to_next() { run_->go_on(window_.time.now_s(), by_the_clock()); }
    StudyFacts page_facts() const {
        const KioskTexts& texts = this->texts();
        const double now_s = window_.time.now_s();
        const auto said = [&](const StudyWords& words) {
            const std::string* const found = said_in(words, run_->language());
            return found ? *found : std::string();
        };
        StudyFacts facts;
        facts.is_page = has_page();
        facts.shows_force = run_->gives_force();
        facts.go_on = texts.study_continue;
        facts.may_go_on = run_->may_go_on(now_s);
        facts.share_done = run_->share_done();
        if (run_->wait_s(now_s) > 0 && run_->screen() && run_->screen()->step->least_s > StudyRun::least_s)
            facts.wait_s = static_cast<int>(std::ceil(run_->wait_s(now_s)));
        if (run_->fault()) facts.fault = texts.study_not_kept;
        const StudyScreen* const screen = run_->screen();
        if (!screen) {
            facts.title = said(run_->study().title);
            facts.words = said(run_->study().words);
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
        facts.chosen = run_->chosen();
        if (!screen->question) return facts;
        facts.is_scale = screen->question->is_scale;
        facts.low = said(screen->question->low);
        facts.high = said(screen->question->high);
        for (const StudyAnswer& answer : screen->question->answers)
            facts.answers.push_back(said(answer.words));
        return facts;
    }

    struct AskedClip {
        std::size_t clip;
        double at_s;
    };
    const std::unique_ptr<StudyRun> run_;
    std::size_t turn_ = 0;            // the turn that the window has begun
    bool had_force_ = false;          // the device's force was requested
    std::optional<AskedClip> asked_;  // requested, not yet open
};

}  // namespace

Result<std::unique_ptr<KioskMode>> open_study(WindowState& window, const KioskMode::Parts& parts) {
    PlayOptions& options = window.options;
    const PlayOptions::Kiosk& kiosk = *options.kiosk;
    const bool by_touch = kiosk.touched_by == TouchedBy::touch_screen;
    TRY_ASSIGN(auto run,
               StudyRun::open(*options.study, options.study_results, kiosk.texts.language,
                              options.hand ? options.hand->name() : (by_touch ? "touch-screen" : "mouse"),
                              std::make_unique<BackgroundWriter>("study", "a study's results")));
    options.meter = run->meter();
    return std::make_unique<StudyMode>(window, parts, std::move(run));
}

}  // namespace touchable
