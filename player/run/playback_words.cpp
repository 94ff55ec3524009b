// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/run/run_files.hpp"

namespace touchable {
namespace {

/// A playback command's word and number of arguments, their unit, and the setting that gives it from the
/// beginning.
struct Spelling {
    PlaybackVerb verb;
    const char* word;
    int numbers;
    double per_unit;  ///< `first` and `second` per unit: ns per second, or thousandths of a rate
    Setting::Name setting = Setting::playback;
};
constexpr double ns_per_s = 1e9, thousandths = 1000;
constexpr std::array spellings{Spelling{PlaybackVerb::play, "play", 0, 0},
                               Spelling{PlaybackVerb::pause, "pause", 0, 0},
                               Spelling{PlaybackVerb::rate, "rate", 1, thousandths, Setting::rate},
                               Spelling{PlaybackVerb::seek, "seek", 1, ns_per_s, Setting::start},
                               Spelling{PlaybackVerb::step, "step", 0, 0},
                               Spelling{PlaybackVerb::loop, "loop", 2, ns_per_s, Setting::loop},
                               Spelling{PlaybackVerb::unloop, "unloop", 0, 0}};
const Spelling& spelling_of(PlaybackVerb verb) {
    return *named_in(spellings, verb, &Spelling::verb);
}
constexpr const char* all_words = "play, pause, rate X, seek S, step, loop S S or unloop";

/// Rounded; nothing if not a number from 0 to 1e6, the limit of all times in seconds.
std::optional<std::int64_t> number_of(const std::string& word, double per_unit) {
    const auto value = parsed_number(word);
    if (!value || *value < 0 || *value > 1e6) return std::nullopt;
    return static_cast<std::int64_t>(*value * per_unit + 0.5);
}

/// Reads one line's words; returns the reason for a refusal.
std::optional<std::string> read_words(const std::vector<std::string>& words, PlaybackCommand& command) {
    const auto tick = number_of(words[0], thousandths);
    if (!tick) return in_quotes(words[0]) + " must be a time in seconds, 0 to 1e6";
    command.tick = *tick;
    const std::string verb = words.size() > 1 ? words[1] : "";
    for (const Spelling& spelling : spellings) {
        if (verb != spelling.word) continue;
        command.verb = spelling.verb;
        if (words.size() != static_cast<std::size_t>(2 + spelling.numbers))
            return verb + " takes " + std::to_string(spelling.numbers) + " numbers, not " +
                   std::to_string(words.size() - 2);
        for (int k = 0; k < spelling.numbers; ++k) {
            const std::string& word = words[static_cast<std::size_t>(2 + k)];
            const auto number = number_of(word, spelling.per_unit);
            if (!number) return in_quotes(word) + " must be a number, 0 to 1e6";
            (k == 0 ? command.first : command.second) = *number;
        }
        return std::nullopt;
    }
    return in_quotes(verb) + " is no command; it must be " + all_words;
}

}  // namespace

Result<std::vector<PlaybackCommand>> parse_playback(std::string_view text, const std::string& name) {
    std::vector<PlaybackCommand> commands;
    std::istringstream lines{std::string(text)};
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        std::istringstream cells(line.substr(0, line.find('#')));
        std::vector<std::string> words;
        for (std::string word; cells >> word;) words.push_back(word);
        if (words.empty()) continue;
        const auto refuse = [&](const std::string& why) {
            return input_error(name + ", line " + std::to_string(number) + ": " + why);
        };
        PlaybackCommand command;
        if (const auto why = read_words(words, command)) return refuse(*why);
        if (const auto fault = fault_after(commands.empty() ? 0 : commands.back().tick, command))
            return refuse(*fault);
        commands.push_back(command);
    }
    return commands;
}

Result<std::vector<PlaybackCommand>> read_playback(const std::filesystem::path& file) {
    constexpr std::size_t largest = std::size_t{16} << 20;
    const auto text = read_given_file(file, "play " + file.string(),
                                      "a file of playback commands (docs/touch.md)", largest);
    if (text) return parse_playback(*text, file.string());
    Error refused = text.error();
    refused.hints = {{Setting::playback}};
    return refused;
}

std::string in_words(const std::vector<PlaybackCommand>& commands) {
    return listed(commands, [](const PlaybackCommand& command) {
        const Spelling& spelling = spelling_of(command.verb);
        std::string text =
            formatted("%.9g %s", static_cast<double>(command.tick) / thousandths, spelling.word);
        const std::array numbers{command.first, command.second};
        for (const std::int64_t number : std::span(numbers).first(static_cast<std::size_t>(spelling.numbers)))
            text += formatted(" %.9g", static_cast<double>(number) / spelling.per_unit);
        return text;
    });
}

Hints settings_of(const std::vector<PlaybackCommand>& commands) {
    Hints settings;
    const auto add = [&settings](Setting::Name setting) {
        if (std::ranges::find(settings, setting, &Hint::setting) == settings.end())
            settings.push_back({setting});
    };
    for (const PlaybackCommand& command : commands) {
        const auto begins_loop = [&](const PlaybackCommand& loop) {
            return loop.tick == 0 && loop.verb == PlaybackVerb::loop && loop.first == command.first;
        };
        const bool is_first = command.tick == 0;
        if (is_first && command.verb == PlaybackVerb::seek && std::ranges::any_of(commands, begins_loop))
            continue;
        add(is_first ? spelling_of(command.verb).setting : Setting::playback);
    }
    return settings;
}

}  // namespace touchable
