#include "player/window/window_core.hpp"

#include "engine/base/try.hpp"
#include "player/run/terminal.hpp"
#include "player/window/command_table.hpp"
#include "player/window/kiosk_mode.hpp"

namespace touchable {

void warn_on_terminal(const std::string& words) {
    say_on_stderr("warning: " + words);
}

Result<void> WindowCore::open() {
    TRY(open_mode());
    if (options.settings_file) settings_file_ = SettingsFile(*options.settings_file);
    const KeptSettings& kept = settings_file_.read();
    clips_.keep(kept);
    if (!settings_file_.message().empty()) say(settings_file_.message(), Tone::fault);
    TRY_ASSIGN(sound_,
               WindowSound::create(!options.headless, options.sound, options.existing, options.names.sound));
    sound_->set_volume(kept.volume);
    if (options.is_offline()) sound_->wait_for_decoding();
    if (options.rumble && !options.headless) sound_->begin_rumble();
    TRY(open_screen(kept));
    clips_.ask_for_first();
    TRY(picture_.open(kept));
    screen_->set_title(clips_.waits_for_wish() ? "touchable" : clips_.words() + " ... - touchable");
    return picture_.draw_opening();
}

/// Opens the mode that the window was opened for, which comes first.
Result<void> WindowCore::open_mode() {
    if (!options.kiosk) return {};
    std::unique_ptr<KioskMode> kiosk;
    if (options.study) {
        TRY_ASSIGN(kiosk, open_study(*this));
    } else {
        kiosk = std::make_unique<KioskMode>(*this, options.kiosk->times);
    }
    modes_.insert(modes_.begin(), kiosk.get());
    const Result<void> opened = kiosk->open_log();
    kiosk_ = std::move(kiosk);
    return opened;
}

Result<void> WindowCore::open_screen(const KeptSettings& kept) {
    ScreenOptions wanted = options.screen;
    if (!options.size_is_stated && kept.width > 0) {
        wanted.width = kept.width;
        wanted.height = kept.height;
    }
    input_.set_fullscreen(wanted.fullscreen);
    wanted.at_once = [this](InputEvent& event) { hand_.stop_at_once(event); };
    if (options.make_screen)
        screen_ = options.make_screen(wanted);
    else if (options.headless)
        screen_ = make_headless_screen(wanted);
    else
        TRY(assign(screen_, open_glfw_screen(wanted)));
    if (!options.gpu)
        options.gpu = std::make_shared<RunGpu>(options.session.builder.gpu, screen_->extensions());
    // One device for the surface and its picture, so that surfaces are drawn without copying.
    options.session.gpu = options.gpu;
    options.session.drawn = !options.headless || options.painter != "cpu";
    return {};
}

void WindowCore::set_clip(std::unique_ptr<OpenedClip> clip) {
    clip_ = std::move(clip);
    playback_.emplace(
        clip_->scene().rate, clip_->frames(), [clip = clip_.get()] { return clip->session().playback(); },
        [clip = clip_.get()](auto... command) { return clip->session().ask(command...); });
    hand_.lead();
}

void WindowCore::tell(const std::string& fault) {
    constexpr std::size_t most_told = 100;
    const bool for_visitors = is_unattended();
    const bool is_known = for_visitors && (told_.size() == most_told || !told_.insert(fault).second);
    if ((options.headless || for_visitors) && !is_known) warn_on_terminal(fault);
}

void WindowCore::take(const InputEvent& event) {
    for (WindowMode* const mode : modes_)
        if (mode->handle(event)) return;
    input_.take(event);
}

void WindowCore::take(const WindowCommand& command) {
    time.note_event();
    for (WindowMode* const mode : modes_)
        if (mode->handle(command)) return;
    const CommandRow& row = row_of(command.verb);
    if (!clip_ && !row.has(CommandRow::without_clip))
        return say(
            clips_.is_opening() ? "there is no clip yet" : "there is no clip yet: drop one on the window",
            Tone::refusal);
    if (options.hand && row.has(CommandRow::of_pointer))
        return say("this is for the mouse; the " + options.hand->name() + " moves the fingers");
    if (!options.hand && row.has(CommandRow::of_hand))
        return say("this is for a haptic device; the mouse moves the finger");
    row.handler(*this, command);
}

void WindowCore::leave() {
    if (quits_ || std::exchange(picture_.panel().help_shown, false) || notices.dismiss()) return;
    if (clips_.close_files() || picture_.panel().leave()) return;
    if (std::exchange(picture_.panel().hidden, false)) return;
    notices.clear_passing();  // the hint of a tool being put away
    for (WindowMode* const mode : modes_)
        if (mode->leave()) return;
    input_.fullscreen() ? input_.turn_fullscreen() : quit();
}

}  // namespace touchable
