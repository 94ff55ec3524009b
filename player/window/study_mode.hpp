#pragma once

#include "player/window/kiosk_mode.hpp"
#include "player/window/study.hpp"

namespace touchable {

/// A kiosk whose visitors are the participants of a study (study.hpp): leads them through its screens, by
/// keys, by buttons and by a held device, and gives forces and sound where a screen says so.
class StudyMode final : public KioskMode {
public:
    /// Refused where results cannot be written.
    static Result<std::unique_ptr<KioskMode>> open(WindowCore& core);

    bool handle(const InputEvent& event) override;
    bool handle(const WindowCommand& command) override;
    void go_on(double now_s) override;
    void draw(PanelFacts& facts, const Seen& seen) override;
    Result<void> finish() override;
    bool is_at_work() const override { return run_->is_beginning(); }
    bool repeats_clip() const override { return true; }
    bool keeps_view() const override { return false; }
    bool chooses_clip() const override { return true; }
    /// What a participant touches is measured in one piece.
    bool keeps_session() const override { return run_->screen() && run_->screen()->is_touch(); }
    bool hides_forces() const override { return !run_->gives_force(); }
    double strip_below(const ScreenSize& size) const override;
    std::string letters() const override {
        return KioskMode::letters() + run_->study().all_words(texts().language) + "(0123456789)";  // seconds
    }
    std::vector<Error> faults() const override;

private:
    StudyMode(WindowCore& core, std::unique_ptr<StudyRun> run)
        : KioskMode(core, {run->study().idle_s, run->study().idle_s}), run_(std::move(run)) {}
    bool allows(const InputEvent& event) const override;
    void end_visit(double now_s) override;
    /// Its start screen invites.
    void invite(double) override {}
    HandState::What state_of(HandState::What what) const override {
        return !run_->gives_force() && what == HandState::What::off ? HandState::What::has_no_force : what;
    }

    bool has_page() const;
    bool clip_is_there() const;
    void ask_for_clip();
    void take_buttons();
    bool take_key(const InputEvent& event);
    void go_to_next();
    StudyFacts page_facts() const;

    struct AskedClip {
        std::size_t clip;
        double at_s;
    };
    const std::unique_ptr<StudyRun> run_;
    std::size_t turn_ = 0;            // that the window has begun
    bool had_force_ = false;          // asked for, of a device
    std::optional<AskedClip> asked_;  // which has not come yet
};

}  // namespace touchable
