#pragma once

#include <map>

#include "player/window/kiosk.hpp"
#include "player/window/window_core.hpp"

namespace touchable {

/// A window that runs unattended (kiosk.hpp): lets visitors do what is theirs, shows how to touch while there
/// is none, begins anew after each, says what a finger rests on, opens its clip again where that broke off,
/// and logs its use.
class KioskMode : public WindowMode {
public:
    KioskMode(WindowCore& core, const KioskTimes& times) : WindowMode(core), watch_(times) {}
    /// The log of use, if one is kept. Refused: a file that cannot be one.
    Result<void> open_log();

    bool handle(const InputEvent& event) override;
    bool handle(const WindowCommand& command) override;
    /// A device that is held shows that a visitor is there.
    void look(const WatchedMoment& moment) override;
    void tick(double now_s) override;
    void prepare(const Seen& seen) override;
    void draw(PanelFacts& facts, const Seen& seen) override;
    void begin() override;
    /// Whether labels go with the clip that they are of.
    Result<void> check(const OpenedClip& clip) const override {
        if (clip.choice().file != core_.options.session.clip.file) return {};
        return core_.options.kiosk->labels.fits(clip.scene().width, clip.scene().height, clip.frames());
    }
    void begin_clip(bool) override { restored_s_ = core_.time.now_s(); }
    void note_fault(const std::string& fault) override;
    void close(const Result<void>& ended) override;
    bool is_unattended() const override { return true; }
    bool moves_by_itself() const override { return is_inviting_; }
    bool repeats_clip() const override { return core_.playlist().list().size() < 2; }
    bool keeps_view() const override { return watch_.was_visited(); }
    std::string letters() const override;
    std::vector<Error> faults() const override {
        const auto missing = log_ ? log_->missing() : std::nullopt;
        return missing ? std::vector{*missing} : std::vector<Error>();
    }

protected:
    /// Whether a visitor may do this.
    virtual bool allows(const InputEvent& event) const { return is_for_visitors(event); }
    /// The visitor has gone.
    virtual void end_visit(double now_s);
    /// Invites the next visitor, or not any more.
    virtual void invite(double now_s);
    /// What visitors see of a device that is held.
    virtual HandState::What state_of(HandState::What what) const { return what; }

    const KioskTexts& texts() const { return core_.options.kiosk->texts; }
    /// A visitor did something.
    void came(double now_s) { watch_.came(now_s); }
    /// The clip, its view, its fingers and forces, and the sound are as at the start.
    void restore();

private:
    void welcome(const InputEvent& event);
    void open_again();
    void look_for_labels(const WatchedMoment& moment);
    void log_visit(const std::optional<KioskWatch::Visit>& visit);

    KioskWatch watch_;
    std::optional<RestingFingers> resting_;  // once there is a clip
    std::unique_ptr<UseLog> log_;
    std::map<std::string, double> logged_faults_;  // in the last hour, and when
    bool is_inviting_ = false;
    glm::dvec3 hand_seen_at_{0.0};  // world, its first finger, when it last was a visit
    double tried_again_s_ = 0;      // to open its clip
    double restored_s_ = 0;         // or another clip came
    double shown_share_ = 1;
    glm::dvec2 shown_from_{0.5, 0.44};  // shares of the picture
};

/// A kiosk of the study that the options have (study_mode.cpp). Refused where its results cannot be written.
Result<std::unique_ptr<KioskMode>> open_study(WindowCore& core);

}  // namespace touchable
