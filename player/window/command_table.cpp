// SPDX-License-Identifier: Apache-2.0
#include "player/window/command_table.hpp"

#include "player/window/window_core.hpp"

namespace touchable {
namespace {

using Command = const WindowCommand&;
using Window = WindowCore&;

void turn_over(bool& shown) {
    shown = !shown;
}
void turn_sound(Window window, Command) {
    WindowSound& sound = *window.state.sound;
    sound.set_muted(!sound.is_muted());
    window.state.say(sound.state());
}
void take_recentre(Window window, Command) {
    window.state.clip->control()->recentre();
    window.state.say("the middle is now where the hand is");
}
/// The scale of finger motion is a setting, changed in steps.
void change_scale(Window window, Command command) {
    const std::string name = "hand-scale";
    const auto chosen = window.clips.wanted_settings().in_effect.now().values();
    const auto found = chosen.find(name);
    const std::string now = found != chosen.end() ? found->second : window.state.clip->in_effect().at(name);
    const SettingRange& range = session_setting(name)->range;
    const double scale = std::clamp(parsed_number(now).value_or(1) * command.number, range.least, range.most);
    window.clips.feel({WindowVerb::feel, 0, name + " " + std::to_string(scale)});
}
void set_volume(Window window, double volume) {
    WindowSound& sound = *window.state.sound;
    sound.set_volume(static_cast<int>(std::lround(volume)));
    window.state.say("volume " + std::to_string(sound.volume()) + " %" +
                     (sound.is_muted() ? "; M: sound on" : ""));
}

void set_overlay(Window window, Command command) {
    ClipPicture& surface = window.picture.surface();
    const auto overlay = overlay_after(surface.overlay(), command.word);
    if (!overlay) return window.state.say(overlay.error());
    surface.set_overlay(*overlay);
}

void set_light(Window window, Command command) {
    ClipPicture& surface = window.picture.surface();
    const auto light = light_after(surface.light(), command.word);
    if (!light) return window.state.say(light.error());
    surface.set_light(*light);
    window.state.say("light on colours: " + std::string(light_names[static_cast<std::size_t>(*light)]));
}

void hide_words(Window window, Command) {
    turn_over(window.panel.hidden);
    if (window.panel.hidden) window.state.say("H shows bars and words again");
}

void keep_screenshot(Window window, Command command) {
    Notices& notices = window.state.notices;
    if (notices.passing().starts_with(saved_as)) notices.clear_passing();  // of an earlier one
    if (auto drawn = window.picture.draw_newest(); !drawn) return window.state.say(drawn);
    window.state.say(window.picture.keep(command.word));
}

void reset_all(Window window, Command) {
    window.clips.reset();
    window.panel.shown = false;
    window.picture.set_dented(KeptSettings().dent);
    window.state.clip->fingers().set_count(KeptSettings().fingers);
    window.state.sound->set_volume(KeptSettings().volume);
    window.picture.surface().set_overlay(Overlay::colour);
    window.picture.surface().set_light(KeptSettings().light);
    window.measure.let_go();
    const ScreenOptions& screen = window.state.options.screen;
    if (!window.input.fullscreen()) window.state.screen->set_size(screen.width, screen.height);
}

void take_setting(Window window, Command command) {
    window.clips.feel(command);
}
void take_brush(Window window, Command command) {
    window.brush.take(command);
}
void refuse_study(Window window, Command) {
    window.state.say("there is no study in this window", Tone::refusal);
}

/// In the order of the help page.
std::vector<CommandRow> all_rows() {
    using enum WindowVerb;
    using enum CommandRow::Words;
    using enum CommandRow::Rule;
    using enum CommandRow::Topic;
    constexpr double long_s = 1e6, far_px = 10000;
    std::vector<CommandRow> rows;
    const auto add = [&rows](WindowVerb verb, const char* name, CommandRow::Topic topic,
                             CommandRow::Takes takes, unsigned rules, std::vector<CommandRow::Key> keys,
                             const char* help, CommandRow::Handler handler, const char* hint = nullptr) {
        rows.push_back({verb, name, topic, takes, rules, std::move(keys), help, handler, hint});
    };
    add(home, "home", begin, {}, for_participants, {{"home"}}, "back to the clip's own view",
        [](Window w, Command) { w.view.go_home(); });
    add(previous, "previous", begin, {}, without_clip, {{"pageup"}, {"<"}}, "previous or next clip",
        [](Window w, Command) { w.playlist.go(-1); });
    add(next, "next", begin, {}, without_clip | alternates, {{"pagedown"}, {">"}}, nullptr,
        [](Window w, Command) { w.playlist.go(1); });
    add(
        measure, "measure", begin, {word}, 0, {{"t"}}, "measure between two places; again: stop",
        [](Window w, Command c) { w.measure.take(c); },
        "two pixels of the depth, X,Y each, such as 120,80 200,90; or nothing, to pick the tool up or put it "
        "away; or off, to remove the line");
    add(fingers, "fingers", touch, {whole_number, 1, 5}, for_visitors | of_pointer,
        {{"1", 1}, {"2", 2}, {"3", 3}, {"4", 4}, {"5", 5}}, "number of fingers",
        [](Window w, Command c) { w.state.clip->fingers().set_count(static_cast<int>(c.number)); });
    add(deeper, "deeper", touch, {number, -20, 20}, by_steps | for_participants | of_pointer,
        {{"e", 0.5}, {"x", -0.5}}, "press deeper or less deep",
        [](Window w, Command c) { w.state.clip->fingers().deepen(c.number / 1000); });
    add(point_down, "point-down", touch, {number, -far_px, far_px}, by_steps | for_participants | of_pointer,
        {{"w", -8}, {"s", 8}}, "move the finger", [](Window w, Command c) { w.input.move_by(0, c.number); });
    add(point_right, "point-right", touch, {number, -far_px, far_px},
        by_steps | for_participants | of_pointer | alternates, {{"a", -8}, {"d", 8}}, nullptr,
        [](Window w, Command c) { w.input.move_by(c.number, 0); });
    add(force, "force", touch, {}, for_visitors, {{"f"}}, "force off at once, or on again",
        [](Window w, Command c) { w.hand.turn_force(c.number == 0); });
    add(clutch, "clutch", touch, {on_or_off}, for_participants | of_hand, {{"c", 1}},
        "held down: the hand moves, the fingers stay",
        [](Window w, Command c) { w.state.clip->control()->hold(c.number != 0); });
    add(recentre, "recentre", touch, {}, for_participants | of_hand, {{"r"}},
        "make the hand's present place the middle", take_recentre);
    add(coarser, nullptr, touch, {}, of_hand, {{"j", 0.8}, {"k", 1.25}},
        "fingers go less far or farther with the hand", change_scale);
    add(turning, "turning", view, {}, 0, {{"v"}}, "dragging turns the view; again: presses",
        [](Window w, Command) { w.view.turn_or_touch(); });
    add(turn, "turn", view, {number, -180, 180}, by_steps | for_participants,
        {{"left", -5, true}, {"right", 5, true}}, "turn the view",
        [](Window w, Command c) { w.state.clip->view().turn(c.number, 0); });
    add(tilt, "tilt", view, {number, -180, 180}, by_steps | for_participants,
        {{"up", 5, true}, {"down", -5, true}}, nullptr,
        [](Window w, Command c) { w.state.clip->view().turn(0, c.number); });
    add(nearer, "nearer", view, {number, 0.1, 10}, by_steps | for_participants,
        {{"+", 1.25}, {"=", 1.25}, {"-", 0.8}}, "nearer or farther; also Ctrl and the wheel",
        [](Window w, Command c) { w.state.clip->view().near_by(c.number); });
    add(undo_view, "undo-view", view, {}, by_steps, {{"u"}}, "the view before; again: the one before that",
        [](Window w, Command) { w.view.undo(); });
    add(centre, nullptr, view, {}, 0, {}, nullptr, [](Window w, Command) { w.input.centre(); });
    add(play_pause, "play-pause", play, {}, for_visitors, {{"space"}}, "play or pause; touch goes on",
        [](Window w, Command) { w.clips.play_or_pause(); });
    add(seek_to, "seek", play, {number, 0, long_s}, 0, {}, nullptr,
        [](Window w, Command c) { w.state.playback->seek_to(c.number); });
    add(seek_by, "seek-by", play, {number, -long_s, long_s}, by_steps | for_visitors,
        {{"left", -1}, {"right", 1}, {"left", -10, false, true}, {"right", 10, false, true}},
        "a second back or forward; with Shift ten",
        [](Window w, Command c) { w.state.playback->seek_by(c.number); });
    add(step, "step", play, {whole_number, -1, 1}, by_steps | for_visitors, {{",", -1}, {".", 1}},
        "a frame back or forward",
        [](Window w, Command c) { w.state.say(w.state.playback->step(c.number)); });
    add(faster, nullptr, play, {}, for_visitors, {{"[", 0.5}, {"]", 2}}, "half or twice the speed",
        [](Window w, Command c) { w.state.say(w.state.playback->change_speed(c.number)); });
    add(speed, "speed", play, {number, 0.1, 4}, 0, {}, nullptr,
        [](Window w, Command c) { w.state.say(w.state.playback->set_speed(c.number)); });
    add(loop, "loop", play, {}, 0, {{"l"}}, "loop on or off",
        [](Window w, Command) { w.state.say(w.state.playback->toggle_loop()); });
    add(mute, "mute", play, {}, without_clip | for_visitors, {{"m"}}, "sound off or on", turn_sound);
    add(louder, "louder", play, {number, -100, 100}, without_clip | by_steps,
        {{"9", -5}, {"0", 5}, {"/", -5}, {"*", 5}}, "quieter or louder",
        [](Window w, Command c) { set_volume(w, w.state.sound->volume() + c.number); });
    add(volume, "volume", play, {number, 0, 100}, without_clip, {}, nullptr,
        [](Window w, Command c) { set_volume(w, c.number); });
    add(copy, "copy", data, {}, 0, {{"c", 0, true}}, "copy the values at the pointer",
        [](Window w, Command) { w.picture.copy_values(); });
    add(overlay, "overlay", data, {word}, for_visitors, {{"o"}},
        "colour the surface by depth, stiffness, ...", set_overlay);
    add(light, "light", data, {word}, 0, {{"i"}}, "light on the clip's colours: off, soft, full", set_light,
        "off, soft or full; or nothing, for the next one");
    add(settings, "settings", data, {word}, 0, {{"b"}}, "switch between the settings A and B", take_setting,
        "a or b, or nothing for the other one");
    add(feel, nullptr, data, {}, 0, {}, nullptr, take_setting);
    add(dent, "dent", data, {on_or_off}, 0, {}, nullptr,
        [](Window w, Command c) { w.picture.set_dented(c.number > 0); });
    add(tool, "tool", data, {word}, 0, {{"p"}}, "pick up or put away the brush", take_brush,
        "touch, paint, join or cut; or nothing, to put it away or pick up the last one");
    add(undo, "undo", data, {}, by_steps, {{"z", 0, true}}, "undo or redo a change of the brush", take_brush);
    add(redo, "redo", data, {}, by_steps, {{"y", 0, true}, {"z", 0, true, true}}, nullptr, take_brush);
    add(save_materials, "save-materials", data, {word}, 0, {{"s", 0, true}}, "save the painted materials",
        take_brush, "a name that ends in .json, or nothing for the clip's own file");
    add(material, "material", data, {word}, 0, {}, nullptr, take_brush);
    add(otherwise, "otherwise", data, {word}, 0, {}, nullptr, take_brush);
    add(paint, "paint", data, {places}, 0, {}, nullptr, take_brush,
        "a pixel of the segment, X,Y or X,Y,FRAME, such as 120,80");
    add(join, "join", data, {places}, 0, {}, nullptr, take_brush,
        "pixels of two segments, X,Y or X,Y,FRAME each, such as 120,80 200,90");
    add(cut, "cut", data, {places}, 0, {}, nullptr, take_brush,
        "pixels of a stroke over one frame, X,Y or X,Y,FRAME each, such as 120,80 160,85 200,90");
    add(go_on, "continue", data, {}, 0, {}, nullptr, refuse_study);
    add(answer, "answer", data, {whole_number, 1, 11}, 0, {}, nullptr, refuse_study);
    add(panel, "panel", window, {}, 0, {{"tab", 1}}, "the panel of settings: arrows and Enter; again: hide",
        [](Window w, Command c) { w.panel.turn_over(c.number > 0); });
    add(help, "help", window, {}, without_clip, {{"?"}, {"f1"}}, "show or hide this list",
        [](Window w, Command) { turn_over(w.panel.help_shown); });
    add(hide, "hide", window, {}, 0, {{"h"}}, "hide or show all bars and words", hide_words);
    add(dismiss, "dismiss", window, {}, without_clip, {}, nullptr,
        [](Window w, Command) { w.state.notices.dismiss(); });
    add(fullscreen, "fullscreen", window, {}, without_clip, {{"f11"}},
        "full screen on or off; also a double click", [](Window w, Command) { w.input.turn_fullscreen(); });
    add(size, "size", window, {width_and_height}, without_clip, {}, nullptr,
        [](Window w, Command c) { w.state.screen->set_size(c.width, c.height); });
    add(screenshot, "screenshot", window, {word}, without_clip, {{"f12"}}, "save a picture of the window",
        keep_screenshot, "a name that ends in .png, or nothing for a new one");
    add(choose, "choose", window, {word}, without_clip, {{"o", 0, true}}, "choose a file to open",
        [](Window w, Command c) { w.clips.ask_for_file(c.word); });
    add(
        open, "open", window, {word}, without_clip, {}, nullptr,
        [](Window w, Command c) { w.clips.open_others({c.word}); }, "a name");
    add(reset, "reset", window, {}, 0, {{"backspace", 0, false, true}}, "forget all kept settings",
        reset_all);
    add(leave, nullptr, window, {}, without_clip, {{"escape"}}, "close what is in front, at last the window",
        [](Window w, Command) { w.leave(); });
    add(quit, "quit", window, {}, without_clip, {{"q"}}, "close the window",
        [](Window w, Command) { w.state.quit(); });
    return rows;
}

/// Keys of all rows. Those of a row that alternates are interleaved with the row above.
std::vector<KeyBinding> all_keys() {
    std::vector<KeyBinding> keys;
    for (const CommandRow& row : command_rows()) {
        const bool between = row.has(CommandRow::alternates);
        std::size_t place = between ? keys.size() - row.keys.size() + 1 : keys.size();
        for (const CommandRow::Key& key : row.keys) {
            const char* const what = &key == &row.keys.front() ? row.help : nullptr;
            keys.insert(keys.begin() + static_cast<std::ptrdiff_t>(place),
                        {key.key, key.shift, row.verb, key.number, what, key.control, row.topic});
            place += between ? 2 : 1;
        }
    }
    return keys;
}

}  // namespace

std::span<const CommandRow> command_rows() {
    static const std::vector<CommandRow> rows = all_rows();
    return rows;
}

const CommandRow& row_of(WindowVerb verb) {
    return *std::ranges::find(command_rows(), verb, &CommandRow::verb);
}

const CommandRow* command_named(std::string_view name) {
    for (const CommandRow& row : command_rows())
        if (row.name && name == row.name) return &row;
    return nullptr;
}

std::span<const KeyBinding> key_bindings() {
    static const std::vector<KeyBinding> bindings = all_keys();
    return bindings;
}

const KeyBinding* binding_of(const std::string& key, bool control, bool shift) {
    const KeyBinding* stop = nullptr;
    for (const KeyBinding& binding : key_bindings()) {
        if (key != binding.key) continue;
        if (control == binding.control && shift == binding.shift) return &binding;
        if (binding.verb == WindowVerb::force) stop = &binding;
    }
    return stop;
}

}  // namespace touchable
