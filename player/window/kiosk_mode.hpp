// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "player/window/kiosk.hpp"
#include "player/window/window_clips.hpp"
#include "player/window/window_picture.hpp"
#include "player/window/window_state.hpp"

namespace touchable {

class WindowBrush;
class WindowInput;

/// A window that runs unattended (kiosk.hpp): restricts visitors' input, demonstrates touching without
/// visitors, resets after each visit, announces labels under fingers, reopens its clip after a failure, and
/// logs its use.
class KioskMode : public WindowMode {
public:
    /// The parts of the window that it uses.
    struct Parts {
        WindowInput& input;
        WindowClips& clips;
        WindowPicture& picture;
        const WindowBrush& brush;
    };
    KioskMode(WindowState& window, const Parts& parts, const KioskTimes& times)
        : WindowMode(window),
          input_(parts.input),
          clips_(parts.clips),
          picture_(parts.picture),
          brush_(parts.brush),
          watch_(times) {}
    /// Opens the usage log, if requested. Fails if the file cannot be one.
    Result<void> open_log();

    bool handle(const InputEvent& event) override;
    bool handle(const WindowCommand& command) override;
    /// Movement of a haptic device counts as a visit.
    void look(const WatchedMoment& moment) override;
    void tick(double now_s) override;
    void prepare(const Seen& seen) override;
    void draw(PanelFacts& facts, const Seen& seen) override;
    void begin() override;
    /// Whether the labels fit their clip.
    Result<void> check(const OpenedClip& clip) const override {
        if (clip.choice().file != window_.options.session.clip.file) return {};
        return window_.options.kiosk->labels.fits(clip.scene().width, clip.scene().height, clip.frames());
    }
    void begin_clip(bool) override { restored_s_ = window_.time.now_s(); }
    void note_fault(const std::string& fault) override;
    void close(const Result<void>& ended) override;
    bool is_unattended() const override { return true; }
    bool moves_by_itself() const override { return is_inviting_; }
    bool repeats_clip() const override { return clips_.list().size() < 2; }
    bool keeps_view() const override { return watch_.was_visited(); }
    std::string letters() const override;
    std::vector<Error> faults() const override {
        const auto missing = log_ ? log_->missing() : std::nullopt;
        return missing ? std::vector{*missing} : std::vector<Error>();
    }

protected:
    /// Whether visitors may do this.
    virtual bool allows(const InputEvent& event) const { return is_for_visitors(event); }
    /// The visitor has left.
    virtual void end_visit(double now_s);
    /// Starts or stops the invitation.
    virtual void invite(double now_s);
    /// The haptic device's state as shown to visitors.
    virtual HandState::What state_of(HandState::What what) const { return what; }

    const KioskTexts& texts() const { return window_.options.kiosk->texts; }
    /// A visitor made an input.
    void came(double now_s) { watch_.came(now_s); }
    /// Resets the clip, its view, fingers, forces and sound.
    void restore();

    WindowInput& input_;
    WindowClips& clips_;
    WindowPicture& picture_;
    const WindowBrush& brush_;

private:
    void welcome(const InputEvent& event);
    void open_again();
    void look_for_labels(const WatchedMoment& moment);
    void log_visit(const std::optional<KioskWatch::Visit>& visit);

    KioskWatch watch_;
    std::optional<RestingFingers> resting_;  // once there is a clip
    std::unique_ptr<UseLog> log_;
    std::map<std::string, double> logged_faults_;  // in the last hour, with their times
    bool is_inviting_ = false;
    glm::dvec3 hand_seen_at_{0.0};  // world, its first finger, at the last visit
    double tried_again_s_ = 0;      // reopening its clip
    double restored_s_ = 0;         // last reset or change of clip
    double shown_share_ = 1;
    glm::dvec2 shown_from_{0.5, 0.44};  // shares of the picture
};

/// A kiosk for the study in the options (study_mode.cpp). Fails if its results cannot be written.
Result<std::unique_ptr<KioskMode>> open_study(WindowState& window, const KioskMode::Parts& parts);

}  // namespace touchable
