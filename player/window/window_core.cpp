// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_core.hpp"

#include "engine/base/try.hpp"
#include "player/run/terminal.hpp"
#include "player/window/command_table.hpp"
#include "player/window/kiosk_mode.hpp"

namespace touchable {
namespace {

/// Reports guesses about the clip's camera and unit: with others the surface would have another size.
void tell_guesses(WindowState& window) {
    std::string guessed, doubt;
    for (const Remark& remark : window.clip->scene().remarks) {
        const bool is_doubt = remark.kind == RemarkKind::unit_doubt;
        if (!remark.is_guess && !is_doubt && remark.hints.empty()) continue;
        say_on_stderr(window.options.names.remark(remark));
        if (is_doubt) doubt = remark.what;
        if (!remark.is_guess) continue;
        const bool is_unit =
            std::ranges::find(remark.hints, Setting::depth_unit, &Hint::setting) != remark.hints.end();
        const std::string_view what = remark.kind == RemarkKind::camera ? "the camera"
                                      : is_unit                         ? "the unit"
                                                                        : "";
        if (guessed.find(what) == std::string::npos)
            guessed += std::string(guessed.empty() ? "" : " and ") + std::string(what);
    }
    if (window.is_unattended() || (doubt.empty() && guessed.empty())) return;
    window.say((doubt.empty() ? "guessed: " + guessed : doubt) +
               (window.clip->is_camera() ? "; the terminal tells how to say it"
                                         : "; touchable info tells how to say it"));
}

}  // namespace

void warn_on_terminal(const std::string& words) {
    say_on_stderr("warning: " + words);
}

void WindowState::tell(const std::string& fault) {
    constexpr std::size_t most_told = 100;
    const bool for_visitors = is_unattended();
    const bool is_known = for_visitors && (told_.size() == most_told || !told_.insert(fault).second);
    if ((options.headless || for_visitors) && !is_known) warn_on_terminal(fault);
}

Result<void> WindowCore::open() {
    TRY(open_mode());
    PlayOptions& options = state.options;
    if (options.settings_file) state.settings_file = SettingsFile(*options.settings_file);
    const KeptSettings& kept = state.settings_file.read();
    clips.keep(kept);
    if (!state.settings_file.message().empty()) state.say(state.settings_file.message(), Tone::fault);
    TRY_ASSIGN(state.sound,
               WindowSound::create(!options.headless, options.sound, options.existing, options.names.sound));
    state.sound->set_volume(kept.volume);
    if (options.is_offline()) state.sound->wait_for_decoding();
    if (options.rumble && !options.headless) state.sound->begin_rumble();
    TRY(open_screen(kept));
    clips.ask_for_first();
    TRY(picture.open(kept));
    state.screen->set_title(clips.waits_for_wish() ? "touchable" : clips.words() + " ... - touchable");
    return picture.draw_opening();
}

/// Opens the mode that the window was opened for, which comes first.
Result<void> WindowCore::open_mode() {
    const auto& options = state.options;
    if (!options.kiosk) return {};
    const KioskMode::Parts parts{input, clips, picture, brush.brush()};
    std::unique_ptr<KioskMode> kiosk;
    if (options.study) {
        TRY_ASSIGN(kiosk, open_study(state, parts));
    } else {
        kiosk = std::make_unique<KioskMode>(state, parts, options.kiosk->times);
    }
    state.modes.insert(state.modes.begin(), kiosk.get());
    const Result<void> opened = kiosk->open_log();
    kiosk_ = std::move(kiosk);
    return opened;
}

Result<void> WindowCore::open_screen(const KeptSettings& kept) {
    PlayOptions& options = state.options;
    ScreenOptions wanted = options.screen;
    if (!options.size_is_stated && kept.width > 0) {
        wanted.width = kept.width;
        wanted.height = kept.height;
    }
    input.set_fullscreen(wanted.fullscreen);
    wanted.at_once = [this](InputEvent& event) { hand.stop_at_once(event); };
    if (options.make_screen)
        state.screen = options.make_screen(wanted);
    else if (options.headless)
        state.screen = make_headless_screen(wanted);
    else
        TRY(assign(state.screen, open_glfw_screen(wanted)));
    if (!options.gpu)
        options.gpu = std::make_shared<RunGpu>(options.session.builder.gpu, state.screen->extensions());
    // One device for the surface and its picture, so that surfaces are drawn without copying.
    options.session.gpu = options.gpu;
    options.session.drawn = !options.headless || options.painter != "cpu";
    return {};
}

void WindowCore::take(const InputEvent& event) {
    for (WindowMode* const mode : state.modes)
        if (mode->handle(event)) return;
    if (event.kind == InputEvent::Kind::close) state.close();
    if (const auto command = input.take(event)) take(*command);
}

void WindowCore::take(const WindowCommand& command) {
    state.time.note_event();
    for (WindowMode* const mode : state.modes)
        if (mode->handle(command)) return;
    const CommandRow& row = row_of(command.verb);
    if (!state.clip && !row.has(CommandRow::without_clip))
        return state.say(
            clips.is_opening() ? "there is no clip yet" : "there is no clip yet: drop one on the window",
            Tone::refusal);
    const auto& device = state.options.hand;
    if (device && row.has(CommandRow::of_pointer))
        return state.say("this is for the mouse; the " + device->name() + " moves the fingers");
    if (!device && row.has(CommandRow::of_hand))
        return state.say("this is for a haptic device; the mouse moves the finger");
    row.handler(*this, command);
}

void WindowCore::leave() {
    if (state.quits() || std::exchange(panel.help_shown, false) || state.notices.dismiss()) return;
    if (clips.close_files() || panel.leave()) return;
    if (std::exchange(panel.hidden, false)) return;
    state.notices.clear_passing();  // the hint of a tool being put away
    for (WindowMode* const mode : state.modes)
        if (mode->leave()) return;
    input.fullscreen() ? input.turn_fullscreen() : state.quit();
}

Result<void> WindowCore::go_on_with_clips() {
    TRY(clips.go_on());
    // Finishes the brush's work before its clip goes.
    if (auto ready = clips.take_ready(!brush.brush().is_changing())) {
        const bool is_named = !state.clip && !clips.waits_for_wish();
        const Result<void> taken = take_ready(std::move(*ready));
        if (!taken && is_named) return taken;
        state.say(taken);
    }
    if (state.clip) clips.go_on_changing();
    return {};
}

Result<void> WindowCore::take_ready(WindowClips::Ready ready) {
    if (ready.clip) {
        TRY(show(ready));
        if (!ready.remark.empty()) state.say(std::move(ready.remark), Tone::refusal);
        return {};
    }
    const Result<void> changed = clips.change(ready);
    hand.lead();
    if (changed) picture.forget_session();
    return changed;
}

/// Replaces the current clip, if there is one.
Result<void> WindowCore::show(WindowClips::Ready& ready) {
    input.lift_touches();
    // A visitor's choices hold for all clips.
    const bool is_first = !state.clip, goes_on = !is_first && state.any(&WindowMode::keeps_view);
    TRY(clips.replace(ready, goes_on));
    hand.lead();
    OpenedClip& clip = *state.clip;
    if (is_first)
        for (const WindowMode* const mode : state.modes) TRY(mode->check(clip));
    clip.begin_sound();
    state.notices.leave_clip();
    picture.begin_clip(goes_on);
    clips.begin_playback();
    input.begin_clip();
    state.screen->set_title(clip.name() + " - touchable");
    for (WindowMode* const mode : state.modes) mode->begin_clip(goes_on);
    tell_guesses(state);
    return {};
}

}  // namespace touchable
