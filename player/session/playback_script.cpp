#include "player/session/playback_script.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <sstream>

#include "engine/base/given_file.hpp"
#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"

namespace touchable {

namespace {

/// A command as it is written, and what stands in a unit of its own: seconds or a rate.
struct Spelling {
    PlaybackVerb verb;
    const char* word;
    int numbers;
    double per_unit;  ///< of `first` and `second`
};
constexpr double ns_per_s = 1e9, thousandths = 1000;
constexpr std::array spellings{
    Spelling{PlaybackVerb::play, "play", 0, 0},           Spelling{PlaybackVerb::pause, "pause", 0, 0},
    Spelling{PlaybackVerb::rate, "rate", 1, thousandths}, Spelling{PlaybackVerb::seek, "seek", 1, ns_per_s},
    Spelling{PlaybackVerb::step, "step", 0, 0},           Spelling{PlaybackVerb::loop, "loop", 2, ns_per_s},
    Spelling{PlaybackVerb::unloop, "unloop", 0, 0}};
constexpr const char* all_words = "play, pause, rate X, seek S, step, loop S S or unloop";

/// Rounded; nothing where it is no number from 0 to 1e6, which is where all times end.
std::optional<std::int64_t> number_of(const std::string& word, double per_unit) {
    double value = 0;
    const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (fault != std::errc() || end != word.data() + word.size() || !(value >= 0 && value <= 1e6))
        return std::nullopt;
    return static_cast<std::int64_t>(value * per_unit + 0.5);
}

/// Of one line's words; a text is why not.
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
                                      "a file of playback commands (docs/playback.md)", largest);
    if (text.ok()) return parse_playback(*text, file.string());
    Error refused = text.error();
    refused.hints = {{Setting::playback}};
    return refused;
}

Hints settings_of(const std::vector<PlaybackCommand>& commands) {
    Hints settings;
    const auto add = [&settings](Setting setting) {
        for (const Hint& known : settings)
            if (known.setting == setting) return;
        settings.push_back({setting});
    };
    for (const PlaybackCommand& command : commands) {
        const auto begins_loop = [&](const PlaybackCommand& loop) {
            return loop.tick == 0 && loop.verb == PlaybackVerb::loop && loop.first == command.first;
        };
        if (command.tick > 0)
            add(Setting::playback);
        else if (command.verb == PlaybackVerb::rate)
            add(Setting::rate);
        else if (command.verb == PlaybackVerb::loop)
            add(Setting::loop);
        else if (command.verb != PlaybackVerb::seek)
            add(Setting::playback);
        else if (std::none_of(commands.begin(), commands.end(), begins_loop))
            add(Setting::start);
    }
    return settings;
}

std::string in_words(const std::vector<PlaybackCommand>& commands) {
    std::string text;
    for (const PlaybackCommand& command : commands)
        for (const Spelling& spelling : spellings) {
            if (spelling.verb != command.verb) continue;
            if (!text.empty()) text += ", ";
            text += formatted("%.9g", static_cast<double>(command.tick) / thousandths);
            text += ' ';
            text += spelling.word;
            for (int k = 0; k < spelling.numbers; ++k) {
                const std::int64_t number = k == 0 ? command.first : command.second;
                text += ' ';
                text += formatted("%.9g", static_cast<double>(number) / spelling.per_unit);
            }
        }
    return text;
}

}  // namespace touchable
