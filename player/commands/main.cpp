// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "engine/base/threads.hpp"
#include "engine/base/words.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"

namespace touchable {
namespace {

/// Prints the error with the options of `app`'s chosen command and returns the exit code.
int fail(const CLI::App& app, const Error& error) {
    std::cout.flush();
    const auto chosen = app.get_subcommands();
    const auto knows = [&](const std::string& option) {
        return chosen.empty() || chosen[0]->get_option_no_throw(option) != nullptr;
    };
    say_on_stderr(message_with_options(error, knows));
    return exit_code(error.kind);
}

/// Lists all commands on one screen.
Result<void> print_overview(const CLI::App& app) {
    std::string lines =
        "touchable " TOUCHABLE_VERSION
        ". touchable FILE opens a window in which it is touched. More: touchable help COMMAND\n";
    for (const CLI::App* command : app.get_subcommands({})) {
        const std::string& name = command->get_name();
        if (name == "cameras")  // a line for both
            lines += "  cameras, devices  list those that are plugged in, ready or not, and why\n";
        else if (name != "devices")
            lines += formatted("  %-12s%s\n", name.c_str(), command->get_description().c_str());
    }
    std::cout << on_terminal(lines);
    return {};
}

/// The command of that name; null: none.
const CLI::App* command_named(const CLI::App& app, std::string_view name) {
    const auto commands = app.get_subcommands({});
    const auto found = std::ranges::find(commands, name, &CLI::App::get_name);
    return found == commands.end() ? nullptr : *found;
}

/// help COMMAND [TOPIC]
Result<void> print_help(const CLI::App& app, std::span<const std::string> words) {
    const CLI::App* const command = command_named(app, words[0]);
    if (words.size() > 2) return usage_error("help takes a command and a topic, no more words");
    if (!command)
        return usage_error("unknown command " + refused_value(words[0]) + "; must be one of " +
                           listed(app.get_subcommands({}), &CLI::App::get_name));
    TRY_ASSIGN(const auto help, words.size() > 1 ? help_on(*command, words[1]) : command->help());
    std::cout << help;
    return {};
}

/// The words after `help`; COMMAND --help TOPIC counts as help COMMAND TOPIC. Empty: neither.
std::vector<std::string> words_of_help(std::vector<std::string> words) {
    if (words.size() == 3 && (words[1] == "--help" || words[1] == "-h") && !words[2].starts_with('-'))
        return {words[0], words[2]};
    if (words.empty() || words[0] != "help") return {};
    words.erase(words.begin());
    return words;
}

/// A file or folder in place of a command, or behind "--", is a clip to play.
bool is_clip(const CLI::App& app, std::span<const std::string> words) {
    if (words.empty() || words[0] == "--") return words.size() > 1;
    const std::string& word = words[0];
    std::error_code ignored;
    const bool looks_like_a_file = word.find_first_of("./") != std::string::npos && word[0] != '-';
    return word != "help" && !command_named(app, word) &&
           (looks_like_a_file || std::filesystem::exists(word, ignored));
}

/// The chosen command's options, or all commands if none is chosen.
std::vector<std::string> known_words(const CLI::App& app) {
    std::vector<std::string> words;
    const auto chosen = app.get_subcommands();
    if (chosen.empty())
        for (const CLI::App* command : app.get_subcommands({})) words.push_back(command->get_name());
    for (const CLI::App* command : chosen)
        for (const CLI::Option* option : command->get_options())
            for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
    return words;
}

/// Throws if an option's value is missing, for which CLI11 would take the next option, or has blanks in place
/// of its commas.
void check_values(const CLI::App& command, std::span<const std::string> words) {
    const auto option_in = [&command](const std::string& word) {
        return word.starts_with('-') ? command.get_option_no_throw(word.substr(0, word.find('='))) : nullptr;
    };
    const auto ends_values = [&](const std::string& word) {
        return word.starts_with("--") || option_in(word);
    };
    const auto is_number = [](const std::string& word) { return parsed_number(word).has_value(); };
    for (; !words.empty() && words[0] != "--"; words = words.subspan(1)) {
        const CLI::Option* const option = option_in(words[0]);
        const std::string value = option ? value_in_words(*option) : "", name = words[0];
        if (value.empty() || (name.find('=') != std::string::npos && !name.ends_with('='))) continue;
        const auto next = words.begin() + 1, end = std::ranges::find_if(next, words.end(), ends_values);
        const std::vector<std::string> numbers(next, std::ranges::find_if_not(next, end, is_number));
        const int needed = option->get_items_expected_min();
        const bool is_empty = needed == 0 && next != end && next->empty();
        if (name.ends_with('=') || is_empty || end - next < needed)
            throw CLI::ValidationError(option->get_name() + " needs " +
                                       (needed > 1 ? std::to_string(needed) + " values: " : "a value: ") +
                                       value);
        if (numbers.size() > 1 && value.find(',') != std::string::npos)
            throw CLI::ValidationError(option->get_name() + " takes " + value +
                                       " with commas: " + listed(numbers, {}, ","));
    }
}

/// The first option of a command that does not go with what else is given, in the order in which CLI11
/// checks; empty: the error is of another kind.
std::string clash_of_options(const CLI::App& command, const CLI::ParseError& error) {
    const bool lacks_another = dynamic_cast<const CLI::RequiresError*>(&error),
               excludes_another = dynamic_cast<const CLI::ExcludesError*>(&error),
               has_wrong_count = dynamic_cast<const CLI::ArgumentMismatch*>(&error);
    for (const CLI::Option* option : command.get_options()) {
        const std::string name = option->get_name();
        const auto count = static_cast<int>(option->count());
        if (count == 0) continue;
        for (const CLI::Option* other : option->get_needs())
            if (lacks_another && other->count() == 0) return name + " needs " + other->get_name();
        for (const CLI::Option* other : option->get_excludes())
            if (excludes_another && other->count() > 0)
                return name + " does not go with " + other->get_name() + "; leave one of them out";
        if (has_wrong_count && option->get_multi_option_policy() == CLI::MultiOptionPolicy::Throw &&
            count > std::max(option->get_items_expected_max(), 1))
            return name + " is given more than once";
    }
    return {};
}

/// CLI11's message on one line, with a hint to the correct usage. `typed`: all words.
Error bad_usage(const CLI::App& app, const CLI::ParseError& error, std::span<const std::string> typed) {
    std::string message = error.what();
    const auto chosen = app.get_subcommands();
    if (dynamic_cast<const CLI::ExtrasError*>(&error)) {  // its own message names them in reverse order
        auto words = app.remaining(true);
        std::erase(words, "--");
        const std::string first = words.empty() ? "" : words.front();
        const auto dashes = std::ranges::find(typed, "--");  // no word behind it is an option
        const bool are_words = std::find(dashes, typed.end(), first) != typed.end();
        const bool is_option = first.starts_with('-') && !are_words;
        const std::string meant = are_words ? "" : nearest_word(first, known_words(app));
        const char* const unknown = chosen.empty() ? "unknown command or file '" : "unexpected word '";
        message = (is_option ? "unknown option '" : unknown) + first + '\'';
        if (!meant.empty()) message += " (did you mean " + meant + "?)";
        const auto at = std::ranges::find(typed, first);
        if (at != typed.begin() && at != typed.end() && *(at - 1) == "--json")
            message += "; for a file type --json=" + first;
    }
    for (const CLI::App* command : chosen)
        if (const std::string clash = clash_of_options(*command, error); !clash.empty()) message = clash;
    std::error_code ignored;
    for (const std::string& word : app.remaining(true))
        if (word.starts_with('-') && std::filesystem::exists(word, ignored))
            message += "; for the file " + word + " type ./" + word;
    const bool is_command = !typed.empty() && command_named(app, typed[0]);
    return usage_error(message + "; see touchable " + (is_command ? typed[0] + " -h" : "-h"));
}

int run(int argc, char** argv) {
    CLI::App app{
        "Touch a depth video and feel its forces.\n"
        "touchable FILE opens a window, as touchable play FILE does.",
        "touchable"};
    app.require_subcommand(0, 1);
    Command command;
    for (const auto add : {add_make_command, add_play_command, add_touch_command, add_cameras_command,
                           add_devices_command, add_info_command, add_formats_command, add_init_scene_command,
                           add_export_command, add_convert_command, add_relief_command, add_materials_command,
                           add_serve_command, add_compare_command, add_plot_command, add_check_command})
        add(app, command);
    set_help(app);
    app.set_version_flag("-V,--version", "touchable " TOUCHABLE_VERSION, "print the version")
        ->group(help_topic);
    bool is_table = false;
    app.add_flag("--list-options", is_table)->group("");

    std::vector<std::string> words(argv + 1, argv + argc);
    if (is_clip(app, words)) words.insert(words.begin(), "play");
    try {
        if (const auto asked = words_of_help(words); !asked.empty()) {
            command = [&app, asked] { return print_help(app, asked); };
        } else if (words != std::vector<std::string>{"help"}) {
            if (const CLI::App* const named = words.empty() ? nullptr : command_named(app, words[0]))
                check_values(*named, std::span(words).subspan(1));
            app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // as CLI11 takes them
        }
    } catch (const CLI::Success& success) {
        app.exit(success);
        command = [] { return Result<void>(); };
    } catch (const CLI::ParseError& error) {
        return fail(app, bad_usage(app, error, words));
    }
    if (is_table)
        command = [&app]() -> Result<void> {
            std::cout << option_table(app);
            return {};
        };
    if (!command) command = [&app] { return print_overview(app); };

    catch_interrupts();
    const Result<void> result = command();
    if (!result) {
        const int code = fail(app, result.error());
        return stop_requested() ? exit_code(ErrorKind::interrupted) : code;
    }
    const Result<void> told = flush_standard_output();
    return told ? 0 : fail(app, told.error());
}

int run_or_tell(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& fault) {
        say_on_stderr(std::string("internal fault: ") + fault.what());
        return exit_code(ErrorKind::internal);
    }
}

}  // namespace
}  // namespace touchable

int main(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);  // a reader that closes the pipe must not stop files from being completed
    touchable::escape_for_terminal();
    const int code = touchable::run_or_tell(argc, argv);
    touchable::wait_for_given_up_gpus();
    if (touchable::abandoned_threads > 0) {
        std::fflush(nullptr);
        std::cout.flush();
        std::_Exit(code);
    }
    return code;
}
