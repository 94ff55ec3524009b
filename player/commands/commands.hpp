#pragma once

// The subcommands of the program `touchable`. Each add_*_command adds the subcommand of its name to `app`.
// When a person types that name, and once its words are read, it sets `command` to the function that does the
// work; main.cpp calls that function, prints the error that it returns, and makes an exit code of it.

#include <functional>
#include <span>
#include <string>

#include "engine/base/result.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace touchable {

/// The work that the command line asked for, with its options filled in.
using Command = std::function<Result<void>()>;

/// A device, a program, a network or a data set, and how its depth is opened: a row of docs/formats.md.
struct DepthSource {
    const char* name;               ///< one word; that of its preset, if it has one
    const char* what;               ///< in words
    const char* files;              ///< that it writes
    const char* command;            ///< for one of these
    const char* read;               ///< from the files; "by its name" where a name is evidence
    const char* guessed;            ///< some of: camera, unit, scale, rate, planar, coding; or "nothing"
    const char* heading = nullptr;  ///< of the rows from this one on, where it begins them
};
/// All of them. Any thread may ask.
std::span<const DepthSource> depth_sources();

/// Gives `app` and all commands that were added to it --help, which is short where they have many options,
/// and
/// --help-all.
void set_help(CLI::App& app);
/// The options of a command that stand under a topic, or under all; refused (ErrorKind::usage) with the names
/// of the topics.
Result<std::string> help_on(const CLI::App& command, const std::string& topic);
/// The value of an option as its help has it: "FILE", "on|off".
std::string value_in_words(const CLI::Option& option);
/// `text` in lines of at most so many columns, each behind so many spaces.
std::string paragraph(const std::string& text, std::size_t spaces, std::size_t columns = 80);
/// Every command, option and example of help, a line each, with tabs between the fields:
/// "command NAME WHAT USAGE", "option COMMAND TOPIC NAMES VALUE WORDS TEXT", "example COMMAND LINE".
std::string option_table(const CLI::App& app);

void add_make_command(CLI::App& app, Command& command);
/// A window in which a clip is watched and touched.
void add_play_command(CLI::App& app, Command& command);
void add_touch_command(CLI::App& app, Command& command);
void add_info_command(CLI::App& app, Command& command);
/// Where depth comes from, and what to type for it.
void add_formats_command(CLI::App& app, Command& command);
/// Writes the scene file of pictures that have none, or of a clip that has it in it.
void add_init_scene_command(CLI::App& app, Command& command);
void add_export_command(CLI::App& app, Command& command);
void add_convert_command(CLI::App& app, Command& command);
/// Writes a clip with heights that its colour suggests.
void add_relief_command(CLI::App& app, Command& command);
/// Writes a clip whose segments feel like materials.
void add_materials_command(CLI::App& app, Command& command);
/// Sends a clip or a camera to all that listen.
void add_serve_command(CLI::App& app, Command& command);
/// Compares the forces of two runs of the same hand.
void add_compare_command(CLI::App& app, Command& command);
/// Draws force over time, or where the proxies went over a frame.
void add_plot_command(CLI::App& app, Command& command);
/// Which cameras are plugged in, and how they are touched.
void add_cameras_command(CLI::App& app, Command& command);
/// What this machine is and whether it can do the work, or what a device does.
void add_check_command(CLI::App& app, Command& command);
/// Which devices are connected and whether they are ready, and every word that --device takes.
void add_devices_command(CLI::App& app, Command& command);

}  // namespace touchable
