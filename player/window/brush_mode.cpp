#include "player/window/brush_mode.hpp"

#include "player/run/terminal.hpp"
#include "player/window/window_core.hpp"

namespace touchable {

BrushMode::BrushMode(WindowCore& core) : WindowMode(core), brush_(core.options) {}

/// Refuses commands when the clip is about to go: they are not meant for the next one.
void BrushMode::take(const WindowCommand& command) {
    if (core_.quits() || core_.clips().has_next())
        return core_.say("the clip is about to go; nothing is painted any more", Tone::refusal);
    brush_.take(command);
    if (brush_.is_held()) {
        core_.take_button(*this);
        if (command.verb == WindowVerb::tool || command.verb == WindowVerb::material)
            core_.picture().panel().shown = true;
    }
    take_news();
}

bool BrushMode::handle_pointer(const InputEvent& event, bool is_of_panel) {
    return core_.clip() && brush_.take(event, core_.input().pointer(), is_of_panel, core_.screen().size());
}

bool BrushMode::leave() {
    if (!brush_.is_held()) return false;
    core_.take(WindowCommand{.verb = WindowVerb::tool, .word = name_of(BrushTool::touch)});
    return true;
}

void BrushMode::go_on(double) {
    brush_.go_on(core_.screen().size());
    take_news();
}

void BrushMode::draw(PanelFacts& facts, const Seen& seen) {
    facts.brush = brush_.facts();
    if (!facts.place.pixel) return;
    if (const auto words = brush_.segment_words(seen.moment, facts.place.pixel->x, facts.place.pixel->y);
        !words.empty())
        facts.place.lines.insert(facts.place.lines.begin() + 1, words);
}

void BrushMode::begin_clip(bool) {
    brush_.go_to(*core_.clip());
}

/// What it says, and what of it is to be felt.
void BrushMode::take_news() {
    const WindowBrush::News news = brush_.take_news();
    const bool is_felt = core_.clips().wanted_settings().has_materials();
    for (const auto& [words, tone, is_change] : news.remarks)
        core_.say(words + (is_change && !is_felt ? "; B feels it" : ""), tone);
    if (news.has_begun) core_.clips().compare_with_before();
    if (news.is_another) core_.clips().feel_painted(brush_.felt());
}

/// An interrupted run tells it, and says in the end that it was interrupted.
Result<void> BrushMode::save() {
    Result<void> saved = brush_.finish();
    if (stop_requested()) saved = {};
    for (const auto& remark : brush_.take_news().remarks)
        if (remark.tone != Tone::remark && (saved || remark.words != saved.error().message))
            warn_on_terminal(remark.words);
    return saved;
}

}  // namespace touchable
