// SPDX-License-Identifier: Apache-2.0
// The text of --help. Options are listed under topics, which are their CLI11 groups ("Camera"). A command
// with many options shows the common ones, two examples and the names of its topics; `--help TOPIC` and
// `--help-all` show the rest. Manual pages and completion are made from the same options (`option_table`).

#include <sys/ioctl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>

#include "engine/base/words.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

constexpr const char* arguments_topic = "Arguments";

/// Short help of a command with many options.
struct ShortHelp {
    std::string_view command;
    std::vector<std::string> options;  ///< in this order; the command must have them all
    std::array<const char*, 2> examples;
};

const ShortHelp* short_help_of(std::string_view command) {
    static const std::array commands{
        ShortHelp{"make",
                  {"SCENE", "OUT", "--size", "--frames", "--rate", "--seed", "--archive", "--overwrite"},
                  {"touchable make globe globe.mkv             # a turning globe, 3 seconds",
                   "touchable make plane plane.mkv --tilt 30   # a plane with a known slope"}},
        ShortHelp{"play",
                  {"CLIP", "--camera", "--device", "--max-force", "--preset", "--filters", "--start",
                   "--rate", "--fullscreen", "--record", "--video"},
                  {"touchable play globe.mkv      # the left mouse button presses a finger in",
                   "touchable play --camera v4l2:/dev/video2 --device inverse3"}},
        ShortHelp{"touch",
                  {"CLIP", "--hand", "--fingers", "--seconds", "--live", "--device", "--preset", "--filters",
                   "--forces", "--json", "--record", "--replay"},
                  {"touchable touch globe.mkv --fingers 5 --forces forces.csv",
                   "touchable touch globe.mkv --live --device inverse3 --max-force 5"}},
        ShortHelp{"info",
                  {"CLIP", "--verify", "--json", "--scene", "--preset", "--filters"},
                  {"touchable info portrait.heic              # what it is, and what was guessed",
                   "touchable info clip.mkv --verify          # read all of it and look for faults"}},
        ShortHelp{"init-scene",
                  {"PICTURES", "--out", "--preset", "--intrinsics", "--fov", "--depth-unit", "--depth",
                   "--overwrite"},
                  {"touchable init-scene pictures              # writes pictures/scene.json",
                   "touchable init-scene depth.png --preset tum --out scene.json"}},
        ShortHelp{"export",
                  {"CLIP", "--out", "--frame", "--frames", "--mesh", "--picture", "--show", "--view",
                   "--preset", "--filters", "--overwrite"},
                  {"touchable export globe.mkv --frame 0 --out frame",
                   "touchable export globe.mkv --frame 0 --picture depth.png --show depth"}},
        ShortHelp{"convert",
                  {"CLIP", "OUT", "--from", "--to", "--every", "--crop", "--size", "--archive", "--preset",
                   "--overwrite"},
                  {"touchable convert recording.bag clip.mkv   # one file that is read fast",
                   "touchable convert clip.mkv part.mkv --from 1.5s --to 3s"}},
        ShortHelp{"relief",
                  {"CLIP", "OUT", "--amount", "--fine", "--medium", "--coarse", "--invert", "--max-height",
                   "--overwrite"},
                  {"touchable relief photo.heic photo.mkv      # bright parts stand out",
                   "touchable relief clip.mkv out.mkv --max-height 2 --invert"}},
        ShortHelp{"materials",
                  {"CLIP", "OUT", "--list", "--segments", "--material", "--at", "--otherwise", "--save",
                   "--overwrite"},
                  {"touchable materials clip.mkv out.mkv    # guesses a material for each segment",
                   "touchable materials clip.mkv out.mkv --material table=wood --at 20,40"}},
        ShortHelp{"check",
                  {"--size", "--fingers", "--rate", "--device", "--json"},
                  {"touchable check                              # the machine, its GPU, its timer",
                   "touchable check --size 1920x1080 --fingers 5 # is it fast enough for that?"}},
        ShortHelp{
            "serve",
            {"CLIP", "URL", "--camera", "--loop", "--listeners", "--seconds", "--hls", "--preset", "--json"},
            {"touchable serve globe.mkv tcp://0.0.0.0:7000 --loop",
             "touchable serve --camera v4l2:/dev/video2 http://0.0.0.0:8000/live.mkv"}}};
    return named_in(commands, command, &ShortHelp::command);
}

// ---- An option

bool is_word(const CLI::Option& option) {
    return !option.nonpositional();
}

/// Empty: hidden from help.
std::string topic_of(const CLI::Option& option) {
    return is_word(option) && !option.get_group().empty() ? arguments_topic : option.get_group();
}

/// The part of a type "NAME:{a,b,c}" before the words.
std::string type_of(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    return type.substr(0, type.find(":{"));
}

/// The allowed words of a value; empty: no list known.
std::vector<std::string> words_of(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const std::size_t begin = type.find(":{");
    if (begin == std::string::npos) return {};
    return CLI::detail::split(type.substr(begin + 2, type.find('}', begin) - begin - 2), ',');
}

std::string names_of(const CLI::Option& option) {
    if (is_word(option)) return option.get_name() + (option.get_expected_max() > 1 ? "..." : "");
    std::string names;
    for (const std::string& name : option.get_snames()) names += "-" + name + ", ";
    return names + "--" + listed(option.get_lnames(), {}, ", --");
}

/// A short list of words is shown in place of the value's name.
bool shows_words_as_value(const CLI::Option& option) {
    constexpr std::size_t most = 26;
    return type_of(option) == "WORD" && listed(words_of(option), {}, "|").size() <= most;
}

std::string described(const CLI::Option& option) {
    std::string text = option.get_description();
    if (text.ends_with('.')) text.pop_back();
    const bool is_sentence = text.size() > 1 && std::isupper(text[0]) && std::islower(text[1]);
    if (is_sentence) text[0] = static_cast<char>(std::tolower(text[0]));
    return text;
}

std::string default_of(const CLI::Option& option) {
    const std::string usual = option.get_default_str();
    return usual.empty() ? "" : " (default " + usual + ")";
}

/// The option's words, unless its type already shows them.
std::vector<std::string> hidden_words_of(const CLI::Option& option) {
    const bool are_shown = shows_words_as_value(option) || type_of(option).find('|') != std::string::npos;
    return are_shown ? std::vector<std::string>() : words_of(option);
}

std::string text_of(const CLI::Option& option) {
    const auto words = hidden_words_of(option);
    constexpr std::size_t most_listed = 40;  // the command prints longer lists itself
    const bool is_short = words.size() <= most_listed;
    return described(option) +
           (words.empty() ? "" : ". Values: " + (is_short ? listed(words) : "as it lists without one")) +
           default_of(option);
}

/// The first sentence, plus as many allowed words and the default as fit into `room`.
std::string short_text_of(const CLI::Option& option, std::size_t room) {
    const std::string whole = described(option), usual = default_of(option), more = ", ...";
    std::string text = whole.substr(0, std::min(whole.find(". "), whole.find("; ")));
    const auto words = hidden_words_of(option);
    for (const std::string& word : words) {
        const bool is_first = &word == &words.front(), is_last = &word == &words.back();
        const std::string longer = text + (is_first ? ": " : ", ") + word;
        if (longer.size() + (is_last ? 0 : more.size()) > room) {
            text += is_first ? "" : more;
            break;
        }
        text = longer;
    }
    return text.size() + usual.size() > room ? text : text + usual;
}

/// All options except hidden ones, positional words first.
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
    auto options = app.get_options([](const CLI::Option* option) { return !topic_of(*option).empty(); });
    std::stable_partition(options.begin(), options.end(),
                          [](const CLI::Option* option) { return is_word(*option); });
    return options;
}

/// In the order of their first options; expert options and help last.
std::vector<std::string> topics_of(const CLI::App& app) {
    std::vector<std::string> topics;
    for (const CLI::Option* option : options_of(app))
        if (std::ranges::find(topics, topic_of(*option)) == topics.end()) topics.push_back(topic_of(*option));
    std::stable_partition(topics.begin(), topics.end(), [](const std::string& topic) {
        return topic != expert_topic && topic != help_topic;
    });
    return topics;
}

std::string topics_in_words(const CLI::App& app) {
    auto topics = topics_of(app);
    std::erase(topics, arguments_topic);
    std::erase(topics, help_topic);
    return small_letters(listed(topics));
}

// ---- Lines

/// Two columns; the text begins on the next line if the head is too long.
std::string entry(const std::string& head, const std::string& text, std::size_t column) {
    const std::string lines = paragraph(text, column);
    if (head.size() + 4 > column) return "  " + head + "\n" + lines;
    return "  " + head + lines.substr(head.size() + 2);
}

/// Columns of a line of help: COLUMNS, the terminal's, or 80.
std::size_t help_columns() {
    const char* const typed = std::getenv("COLUMNS");
    winsize size{};
    double columns = typed ? parsed_number(typed).value_or(0) : 0;
    if (columns < 1 && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0) columns = size.ws_col;
    return columns < 1 ? 80 : static_cast<std::size_t>(std::clamp(columns, 40.0, 1000.0));
}

/// Wraps lines; the rest of "  label  text" begins below its text.
std::string wrapped(const std::string& text) {
    std::string all;
    for (const std::string& line : CLI::detail::split(text, '\n')) {
        const std::size_t label = std::min(line.find_first_not_of(' '), line.size());
        const std::size_t value = line.find_first_not_of(' ', line.find("  ", label));
        const std::size_t column = value <= help_columns() / 2 ? value : label;
        all += line.substr(0, column) + paragraph(line.substr(column), column).substr(column);
    }
    return all;
}

std::string head_of(const CLI::Option& option) {
    const std::string value = value_in_words(option);
    return names_of(option) + (value.empty() ? "" : " " + value);
}

std::string usage_of(const CLI::App& command) {
    std::string usage;
    for (const CLI::Option* option : options_of(command))
        if (is_word(*option))
            usage += option->get_required() ? " " + names_of(*option) : " [" + names_of(*option) + "]";
    return "touchable " + command.get_name() + usage + " [OPTIONS]";
}

std::string beginning_of(const CLI::App& command) {
    std::string what = command.get_description();
    what[0] = static_cast<char>(std::toupper(what[0]));
    return wrapped(what + ".\nUsage: " + usage_of(command));
}

// ---- Helps

std::string help_on_topic(const CLI::App& command, const std::string& topic) {
    constexpr std::size_t column = 30;
    std::string help = "\n" + topic + ":\n";
    for (const CLI::Option* option : options_of(command))
        if (topic_of(*option) == topic) help += entry(head_of(*option), text_of(*option), column);
    return help;
}

std::string whole_help(const CLI::App& command) {
    std::string help = beginning_of(command);
    for (const std::string& topic : topics_of(command)) help += help_on_topic(command, topic);
    return help;
}

std::string short_help(const CLI::App& command, const ShortHelp& about) {
    std::string help = beginning_of(command) + "\n";
    constexpr std::size_t least_column = 22;
    std::size_t column = least_column;
    for (const std::string& name : about.options)
        column = std::max(column, head_of(*command.get_option(name)).size() + 4);
    for (const std::string& name : about.options) {
        const CLI::Option& option = *command.get_option(name);
        const std::size_t room = std::max(help_columns(), column + 20) - column;
        help += entry(head_of(option), short_text_of(option, room), column);
    }
    help += "\nExamples:\n";
    for (const char* example : about.examples) help += std::string("  ") + example + "\n";
    return help + "\nMore: touchable " + command.get_name() + " --help TOPIC, or --help-all. Topics:\n" +
           paragraph(topics_in_words(command), 2);
}

std::string help_of_program(const CLI::App& app, bool with_commands) {
    constexpr std::size_t column = 14;
    std::string help = app.get_description() + "\nUsage: touchable FILE [OPTIONS]\n" +
                       "       touchable COMMAND [OPTIONS]\n\nCommands:\n";
    const auto commands = app.get_subcommands({});
    for (const CLI::App* command : commands)
        help += entry(command->get_name(), command->get_description(), column);
    help += help_on_topic(app, help_topic);
    if (with_commands)
        for (const CLI::App* command : commands) help += "\n\n" + whole_help(*command);
    return help;
}

class Help final : public CLI::FormatterBase {
public:
    std::string make_help(const CLI::App* app, std::string, CLI::AppFormatMode mode) const override {
        const bool is_whole = mode == CLI::AppFormatMode::All;
        if (app->get_name() == "touchable") return help_of_program(*app, is_whole);
        const ShortHelp* const about = is_whole ? nullptr : short_help_of(app->get_name());
        return about ? short_help(*app, *about) : whole_help(*app);
    }
};

}  // namespace

void set_help(CLI::App& app) {
    const auto help = std::make_shared<Help>();
    auto apps = app.get_subcommands([](const CLI::App*) { return true; });
    apps.push_back(&app);
    for (CLI::App* each : apps) {
        each->formatter(help);
        each->set_help_flag("-h,--help",
                            each == &app ? "print help" : "print help; --help TOPIC: all options of a topic")
            ->group(help_topic);
        each->set_help_all_flag("--help-all", "print all options")->group(help_topic);
    }
}

Result<std::string> help_on(const CLI::App& command, const std::string& topic) {
    if (topic == "all") return whole_help(command);
    const auto topics = topics_of(command);
    for (const std::string& each : topics)
        if (small_letters(each) == small_letters(topic)) return help_on_topic(command, each).substr(1);
    const std::string known = topics_in_words(command);
    return usage_error("unknown topic '" + printable(topic) + "' of " + command.get_name() + "; must be " +
                       (known.empty() ? "all" : "one of " + known + ", all"));
}

std::string value_in_words(const CLI::Option& option) {
    if (is_word(option) || option.get_type_size() == 0) return "";
    return shows_words_as_value(option) ? listed(words_of(option), {}, "|") : type_of(option);
}

std::string on_terminal(const std::string& text) {
    return isatty(STDOUT_FILENO) == 1 ? wrapped(text) : text;
}

std::string paragraph(const std::string& text, std::size_t spaces) {
    const std::size_t columns = help_columns();
    std::string all, line;
    for (const std::string& word : CLI::detail::split(text, ' ')) {
        if (!line.empty() && spaces + line.size() + 1 + word.size() > columns) {
            all += std::string(spaces, ' ') + line + '\n';
            line.clear();
        }
        line += (line.empty() ? "" : " ") + word;
    }
    return all + std::string(spaces, ' ') + line + '\n';
}

std::string option_table(const CLI::App& app) {
    std::string table;
    const auto line = [&table](const auto&... fields) {
        std::string row;
        ((row += (row.empty() ? "" : "\t") + std::string(fields)), ...);
        table += row + "\n";
    };
    auto apps = app.get_subcommands({});
    apps.insert(apps.begin(), &app);
    for (const CLI::App* each : apps) {
        const std::string& name = each->get_name();
        const std::string what = each->get_description();
        line("command", name, what.substr(0, what.find('\n')), usage_of(*each));
        for (const std::string& topic : topics_of(*each))
            for (const CLI::Option* option : options_of(*each))
                if (topic_of(*option) == topic)
                    line("option", name, topic, names_of(*option), value_in_words(*option),
                         listed(words_of(*option), {}, ","), text_of(*option));
        if (const ShortHelp* const about = short_help_of(name))
            for (const char* example : about->examples) line("example", name, example);
    }
    return table;
}

}  // namespace touchable
