// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_clips.hpp"

#include <filesystem>

#include "engine/base/child_process.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "player/run/terminal.hpp"
#include "player/window/window_state.hpp"

namespace touchable {
namespace {

// Interval of attempts to renew a session; few commands come in that time compared to the remaining room.
constexpr std::chrono::seconds renew_pause(20);

/// By a dialog of the desktop; without one, the content of the working folder.
Result<FileList> chosen_file(const std::vector<std::string>& recent) {
    constexpr std::size_t longest_name = 1 << 16;
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"zenity", "--file-selection", "--title=Open a clip"},
          std::vector<std::string>{"kdialog", "--title", "Open a clip", "--getopenfilename", "."}}) {
        TRY_ASSIGN(const auto dialog, ChildProcess::start(words));
        if (!dialog) continue;
        const auto output = dialog->all_output(longest_name);
        auto list = list_files("", recent);
        if (list && output) list->chosen = output->substr(0, output->find('\n'));
        return list;
    }
    return list_files(".", recent);
}

std::string title_of(const std::filesystem::path& file) {
    const std::string name = file.filename().string();
    return name.empty() ? file.string() : name;
}

/// Puts a clip first among the recent ones, unless it is a camera or a stream.
void put_first(std::vector<std::string>& recent, const std::filesystem::path& clip) {
    std::error_code failed;
    std::filesystem::path path = std::filesystem::absolute(clip, failed).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();  // a folder's name ended in a slash
    const std::string file = path.string();
    if (!std::filesystem::exists(file, failed)) return;
    std::erase(recent, file);
    recent.insert(recent.begin(), file);
    recent.resize(std::min(recent.size(), SettingsFile::most_recent));
}

/// Reports faults; of very many, only how many more there are.
void tell_skipped(WindowState& window, std::span<const Error> skipped) {
    const std::size_t told =
        skipped.size() > Notices::most_faults ? Notices::most_faults - 1 : skipped.size();
    for (const Error& error : skipped.first(told)) window.say(error.message, Tone::fault);
    if (told < skipped.size())
        window.say(std::to_string(skipped.size() - told) + " more clips cannot be opened", Tone::fault);
}

/// Adds the session's figures to those of earlier clips.
void count_session(WindowState& window) {
    window.figures.sessions = with_counts_of(window.figures.sessions, window.clip->figures());
}

}  // namespace

bool WindowSettings::has_materials() const {
    const auto& values = in_effect.now().values();
    const auto materials = values.find("materials");
    return materials == values.end() || materials->second == "on";
}

std::string WindowSettings::in_words() const {
    if (!painted || !has_materials()) return in_effect.in_words();
    if (in_effect.now() == SessionSettings{}) return in_effect.b_is_on ? "B: as painted" : "A: as painted";
    return in_effect.in_words() + ", as painted";
}

bool WindowClips::waits_for_wish() const {
    return !window_.clip && window_.options.session.clip.file.empty();
}

std::optional<Error> fault_of(const OpenedClip& clip) {
    const WatchedSession& session = clip.session();
    return session.running() ? session.clip_failure() : session.failure();
}

void WindowClips::keep(const KeptSettings& kept) {
    if (!window_.options.filters_are_stated) settings_.kept = {kept.a, kept.b};
    recent_ = kept.recent;
}

/// The first clip may be open already, to know which files may be written; later openings reopen it.
void WindowClips::ask_for_first() {
    if (waits_for_wish())
        return choosing_.ask("listing", [recent = recent_] { return list_files("", recent); });
    PlayOptions& options = window_.options;
    const ClipChoice first = options.session.clip;
    options.session.clip.shared_clip.reset();
    std::vector<ClipChoice> clips{options.session.clip};
    clips.insert(clips.end(), options.next_clips.begin(), options.next_clips.end());
    // A mode that chooses the clip does not accept another one.
    ask_for_clip(Playlist(std::move(clips), window_.is_unattended()),
                 window_.any(&WindowMode::chooses_clip) ? 0 : 1, first);
}

/// Settings that the clip does not support are kept for another clip but not in effect. The relief's are
/// dropped first.
Result<WindowClips::Ready> WindowClips::open_clip(ClipChoice choice, const TwoSettings& kept) {
    choice.share_clip();
    auto opened = OpenedClip::open(window_.options, choice, kept.now(), *window_.sound);
    if (opened) return Ready{.clip = std::move(*opened), .settings = {kept, kept}};
    const std::string why = opened.error().message;
    TwoSettings tried = kept;
    for (const bool all : {false, true}) {
        TwoSettings in_effect = kept;
        // A camera's clip, or a recorded run, has no relief: that needs a clip's colour.
        in_effect.now().drop(SettingOf::relief);
        if (all) in_effect.now() = {};
        if (in_effect == tried || stop_requested()) continue;
        tried = in_effect;
        opened = OpenedClip::open(window_.options, choice, in_effect.now(), *window_.sound);
        if (!opened) continue;
        return Ready{.clip = std::move(*opened),
                     .settings = {kept, in_effect},
                     .remark = (all ? "felt as the clip says: " : "felt without relief: ") + why};
    }
    return opened.error();
}

/// Opens `choice`, the list's current clip; if it cannot be opened, tries the others in steps of `by`, each
/// once; 0: no other.
Result<WindowClips::Ready> WindowClips::open_first(Playlist list, int by, ClipChoice choice,
                                                   const TwoSettings& kept) {
    std::vector<Error> skipped;
    for (std::size_t tries = list.size(); tries > 0; --tries) {
        auto opened = open_clip(std::move(choice), kept);
        if (!opened && (opened.error().kind == ErrorKind::interrupted || stop_requested()))
            return opened.error();
        if (!opened) skipped.push_back(opened.error());
        const ClipChoice* const other = !opened && by != 0 ? list.go(by) : nullptr;
        if (other) {
            choice = *other;
            continue;
        }
        Ready ready = opened ? std::move(*opened) : Ready{};
        ready.list = std::move(list);
        ready.skipped = std::move(skipped);
        return ready;
    }
    return Ready{.skipped = std::move(skipped)};
}

/// Drops a pending change, which is requested again once the clip is there.
void WindowClips::begin_asking() {
    ready_.reset();
    asked_settings_.reset();
    wanted_list_.reset();
    next_is_paused_ = false;
}

/// Arguments as in open_first.
void WindowClips::ask_for_clip(const Playlist& list, int by, const ClipChoice& choice) {
    begin_asking();
    wanted_list_ = list;
    opening_.ask("opening " + title_of(choice.file), [this, list, by, choice, kept = settings_.kept] {
        return open_first(list, by, choice, kept);
    });
}

/// Lists folders off the window's thread, as their disk may not answer.
void WindowClips::ask_for_named(std::vector<std::string> named) {
    begin_asking();
    const std::string words = "opening " + title_of(named.front());
    const auto open = [this, named = std::move(named), kept = settings_.kept,
                       wraps = window_.is_unattended()]() -> Result<Ready> {
        const auto files = unless_stopped([named, list = window_.options.clips_of] {
            std::vector<std::filesystem::path> all;
            for (const std::string& name : named)
                for (auto& file : list(name)) all.push_back(std::move(file));
            return all;
        });
        if (!files) return interrupted_error();
        std::vector<ClipChoice> clips;
        for (const auto& file : *files) clips.emplace_back().file = file;
        Playlist list(std::move(clips), wraps);
        const ClipChoice first = list.now();
        return open_first(std::move(list), 1, first, kept);
    };
    opening_.ask(words, open);
}

void WindowClips::ask_for_change(const WindowSettings& wanted) {
    opening_.ask("changing to " + wanted.in_words(), [clip = window_.clip.get(), wanted]() -> Result<Ready> {
        TRY_ASSIGN(auto change, clip->prepare(wanted.in_effect.now(), wanted.painted));
        return Ready{.clip = nullptr, .change = std::move(change), .settings = wanted};
    });
}

Result<void> WindowClips::go_on() {
    if (auto made = opening_.take()) TRY(take_made(std::move(*made)));
    if (const auto chosen = choosing_.take()) {
        if (!*chosen)
            window_.say(chosen->error());
        else if (files_ = **chosen; !files_.chosen.empty())
            open_others({files_.chosen});
    }
    return {};
}

std::optional<WindowClips::Ready> WindowClips::take_ready(bool may_go) {
    if (!ready_ || !(ready_->clip ? may_go : window_.clip->has_come_to(*ready_->change))) return {};
    return std::exchange(ready_, std::nullopt);
}

/// Keeps the first failure of the named clips for the program's end. If none can be opened, the window
/// closes, or stays empty.
Result<void> WindowClips::take_made(Result<Ready> made) {
    const bool is_change = asked_settings_.has_value(), is_named = !window_.clip && !waits_for_wish();
    if (is_change && !made && wanted_settings_ == asked_settings_) wanted_settings_.reset();  // refused
    asked_settings_.reset();
    if (!made) {
        forget_wish();
        if (is_named) return go_on_without_clip(made.error());
        is_change ? window_.say(made.error()) : window_.say(made.error().message, Tone::fault);
        return {};
    }
    std::span<const Error> skipped = made->skipped;
    if (is_named && !skipped.empty() && !failure_) failure_ = skipped.front();
    const bool is_none = !made->clip && !made->change;
    if (is_none) forget_wish();
    if (is_none && is_named) {
        tell_skipped(window_, skipped.first(skipped.size() - 1));
        return go_on_without_clip(skipped.back());
    }
    tell_skipped(window_, skipped);
    if (!is_none) ready_ = std::move(*made);
    return {};
}

/// None of the named clips can be opened: the window closes, or stays empty.
Result<void> WindowClips::go_on_without_clip(const Error& why) {
    PlayOptions& options = window_.options;
    if (!options.stays_without_clip || why.kind == ErrorKind::interrupted) return why;
    if (!failure_) failure_ = why;
    std::filesystem::path& file = options.session.clip.file;
    window_.screen->set_title(title_of(file) + " cannot be opened - touchable");
    file.clear();
    window_.say(why.message, Tone::fault);
    return {};
}

void WindowClips::go_on_changing() {
    const OpenedClip& clip = *window_.clip;
    const bool was_seen = window_.figures.pictures > changed_at_ || !clip.session().running();
    if (window_.any(&WindowMode::keeps_session) || !was_seen || is_busy()) return;
    if (!wanted_settings_) {
        const auto now = WindowClock::now();
        if (now <= renew_after_ || !clip.is_nearly_full()) return;
        renew_after_ = now + renew_pause;
        return ask_for_change(settings_);
    }
    // Painted materials that are not felt change nothing.
    if (wanted_settings_->in_effect.now() == clip.settings() &&
        (wanted_settings_->painted == clip.painted() || !wanted_settings_->has_materials())) {
        const WindowSettings before = std::exchange(settings_, *wanted_settings_);
        wanted_settings_.reset();
        if (before.in_effect.in_words() != settings_.in_effect.in_words()) window_.say(settings_.in_words());
        return;
    }
    asked_settings_ = wanted_settings_;
    ask_for_change(*wanted_settings_);
}

Result<void> WindowClips::change(Ready& ready) {
    changed_at_ = window_.figures.pictures;
    const bool is_another = settings_.in_effect.in_words() != ready.settings.in_effect.in_words();
    settings_ = ready.settings;
    if (wanted_settings_ == ready.settings) wanted_settings_.reset();
    const bool had_failed = window_.clip->failure().has_value();
    TRY(window_.clip->take(std::move(*ready.change)));
    const bool has_failed = !had_failed && note_failure();
    if (is_another && !has_failed) window_.say(settings_.in_words());
    return {};
}

Result<void> WindowClips::replace(Ready& ready, bool goes_on) {
    changed_at_ = window_.figures.pictures;
    settings_ = ready.settings;
    OpenedClip* const before = window_.clip.get();
    OpenedClip& clip = *ready.clip;
    if (goes_on) clip.view().look_as(before->view());
    if (before) {
        if (auto finished = before->finish(); !finished) window_.say(finished);
        note_failure();
        clip.fingers().set_count(before->fingers().count());
        // Stopped forces stay stopped for every clip.
        clip.device()->set_force(before->device()->force_is_on());
    } else {
        clip.fingers().set_count(window_.settings_file.read().fingers);
    }
    if (auto begun = clip.begin(); !begun) {
        forget_wish();  // the current clip has ended; an unattended window reopens it
        return begun;
    }
    // Unattended, a fault that is over is a row of the log and no exit code.
    if (before && window_.is_unattended() && ready.skipped.empty()) failure_.reset();
    if (before) count_session(window_);
    window_.playback.emplace(
        clip.scene().rate, clip.frames(), [&clip] { return clip.session().playback(); },
        [&clip](auto... command) { return clip.session().ask(command...); });
    window_.clip = std::move(ready.clip);
    list_ = std::move(ready.list);
    wanted_list_.reset();
    slow_reading_ = {};
    is_told_of_reading_ = false;
    if (wanted_settings_) wanted_settings_->painted.reset();
    put_first(recent_, clip.choice().file);
    return {};
}

void WindowClips::begin_playback() {
    const OpenedClip& clip = *window_.clip;
    if (window_.any(&WindowMode::repeats_clip) && !clip.session().playback().loops && clip.seconds() >= 0.1)
        window_.say(window_.playback->toggle_loop());
    if (std::exchange(next_is_paused_, std::nullopt).value_or(false))
        window_.say(window_.playback->pause(true));
}

/// Whether the clip's session failed: the window reports it, and so does the program at its end.
bool WindowClips::note_failure() {
    const auto& failure = window_.clip->failure();
    if (!failure) return false;
    if (!failure_) failure_ = failure;
    window_.say(failure->message, Tone::fault, About::clip);
    return true;
}

void WindowClips::open_others(std::vector<std::string> named) {
    if (window_.options.record)
        return window_.say("the recording is of this clip; another opens in a window that does not record",
                           Tone::refusal);
    window_.notices.clear_passing();
    close_files();
    ask_for_named(std::move(named));
}

void WindowClips::ask_for_file(const std::string& folder) {
    if (window_.is_unattended()) return;
    choosing_.ask("choosing a file", [folder, recent = recent_] {
        return folder.empty() ? chosen_file(recent) : list_files(folder, recent);
    });
}

void WindowClips::open_instead(Playlist list, int by) {
    window_.notices.clear_passing();
    ask_for_clip(list, by, list.now());
}

void WindowClips::open_again() {
    const Playlist& list = list_;
    ask_for_clip(list, 0, list.now());
}

void WindowClips::play_or_pause() {
    if (!next_is_paused_) return window_.say(window_.playback->play_or_pause());
    const PlaybackState there = window_.clip->session().playback();
    // As the button shows: at the end "play", except unattended, where the clip continues by itself.
    const bool pauses = there.playing && (window_.is_unattended() || !there.at_end);
    const Result<void> heard = window_.playback->pause(pauses);
    if (heard) next_is_paused_ = pauses;
    window_.say(heard);
}

void WindowClips::feel(const WindowCommand& command) {
    WindowSettings wanted = wanted_settings();
    const std::size_t space = command.word.find(' ');
    const SessionSetting* const setting = session_setting(command.word.substr(0, space));
    if (setting && setting->of == SettingOf::device && !window_.options.hand)
        return window_.say(setting->name + " applies to a haptic device; none is connected", Tone::refusal);
    const bool is_of_brush = setting && setting->of == SettingOf::brush;
    if (is_of_brush && !wanted.painted)
        return window_.say("nothing is painted yet; P picks up the brush", Tone::refusal);
    const bool to_b = command.word.empty() ? !wanted.in_effect.b_is_on : command.word == "b";
    for (TwoSettings* const settings : {&wanted.kept, &wanted.in_effect}) {
        if (is_of_brush && settings == &wanted.kept) continue;
        if (command.verb == WindowVerb::settings) {
            settings->turn_to(to_b);
        } else if (auto set =
                       settings->now().set(command.word.substr(0, space), command.word.substr(space + 1));
                   !set) {
            return window_.say(set.error());
        }
    }
    wanted_settings_ = wanted;
}

void WindowClips::feel_painted(std::shared_ptr<const PaintedSegments> painted) {
    WindowSettings wanted = wanted_settings();
    wanted.painted = std::move(painted);
    if (!(wanted == wanted_settings())) wanted_settings_ = std::move(wanted);
}

void WindowClips::compare_with_before() {
    WindowSettings wanted = wanted_settings();
    TwoSettings& two = wanted.in_effect;
    SessionSettings before = two.now();
    (void)before.set("materials", "off");
    if (two.b_is_on)
        two.a = before;
    else
        two.b = before;
    wanted_settings_ = std::move(wanted);
}

void WindowClips::reset() {
    WindowSettings anew;
    anew.painted = wanted_settings().painted;
    wanted_settings_ = anew;
    if (anew.painted) compare_with_before();
}

/// Reports once per clip that pictures compressed by other programs are slow to read, and the remedy.
void WindowClips::note_slow_reading() {
    const OpenedClip& clip = *window_.clip;
    const Scene& scene = clip.scene();
    if (!scene.folder || clip.is_still() || is_told_of_reading_) return;
    const double period_ms = 1000 / scene.rate.per_second();
    slow_reading_.add(clip.figures(), period_ms);
    if (!slow_reading_.is_why()) return;
    is_told_of_reading_ = true;
    const std::string help = window_.options.names.faster(clip.choice().file.string());
    std::string words = "frames come late: reading the pictures of one takes " +
                        short_number(slow_reading_.read_ms(), 3) + " ms, and it is shown for " +
                        short_number(period_ms, 3) + " ms" + (help.empty() ? "" : "; " + help);
    if (window_.figures.slow_reading.empty()) window_.figures.slow_reading = words;
    window_.say(std::move(words));
}

void WindowClips::note_end() {
    count_session(window_);
    if (!failure_) failure_ = window_.clip->failure();
    const auto& hand = window_.options.hand;
    if (!failure_ && hand && (hand->is_gone() || hand->is_looked_for()))
        if (const auto health = hand->health(); !health) failure_ = health.error();
}

}  // namespace touchable
