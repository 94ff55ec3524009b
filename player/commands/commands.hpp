// SPDX-License-Identifier: Apache-2.0
#pragma once

// The subcommands of the program `touchable`. Each add_*_command adds the subcommand of its name to `app`.
// When that subcommand is parsed, it sets `command` to the function that does the work; main.cpp calls the
// function, prints its error and turns it into an exit code.

#include <functional>
#include <span>
#include <string>

#include "engine/base/result.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace touchable {

/// The chosen command's work, with its options filled in.
using Command = std::function<Result<void>()>;

/// A device, a program, a network or a data set, and how its depth is opened: a row of docs/formats.md.
struct DepthSource {
    const char* name;               ///< one word; its preset's name, if it has one
    const char* what;               ///< in words
    const char* files;              ///< files that it writes
    const char* command;            ///< to open one of them
    const char* read;               ///< read from the files; "by its name" if a name is the evidence
    const char* guessed;            ///< any of camera, unit, scale, rate, planar, coding; or "nothing"
    const char* heading = nullptr;  ///< begins a group of rows
};
/// All sources. Any thread.
std::span<const DepthSource> depth_sources();

/// Gives `app` and its commands --help, which is short for commands with many options, and --help-all.
void set_help(CLI::App& app);
/// The help on a command's options under `topic`, or under all. An unknown topic is refused
/// (ErrorKind::usage) with the names of the topics.
Result<std::string> help_on(const CLI::App& command, const std::string& topic);
/// An option's value as shown in help: "FILE", "on|off".
std::string value_in_words(const CLI::Option& option);
/// `text` wrapped at the terminal's width (80 without one), each line indented by `spaces`.
std::string paragraph(const std::string& text, std::size_t spaces);
/// A report, whose lines are wrapped if standard output is a terminal and stay whole elsewhere, for grep.
std::string on_terminal(const std::string& text);
/// Every command, option and example of the help, one per line with tab-separated fields:
/// "command NAME WHAT USAGE", "option COMMAND TOPIC NAMES VALUE WORDS TEXT", "example COMMAND LINE".
std::string option_table(const CLI::App& app);

void add_make_command(CLI::App& app, Command& command);
/// Opens a window in which a clip is watched and touched.
void add_play_command(CLI::App& app, Command& command);
void add_touch_command(CLI::App& app, Command& command);
void add_info_command(CLI::App& app, Command& command);
/// Lists sources of depth and what to type for each.
void add_formats_command(CLI::App& app, Command& command);
/// Writes a scene file for pictures without one, or that of a clip which contains it.
void add_init_scene_command(CLI::App& app, Command& command);
void add_export_command(CLI::App& app, Command& command);
void add_convert_command(CLI::App& app, Command& command);
/// Writes a clip with heights derived from its colour.
void add_relief_command(CLI::App& app, Command& command);
/// Writes a clip whose segments feel like materials.
void add_materials_command(CLI::App& app, Command& command);
/// Sends a clip or a camera to all listeners.
void add_serve_command(CLI::App& app, Command& command);
/// Compares the forces of two runs of the same hand.
void add_compare_command(CLI::App& app, Command& command);
/// Draws force over time, or the proxies' paths over a frame.
void add_plot_command(CLI::App& app, Command& command);
/// Lists plugged-in cameras and how to touch them.
void add_cameras_command(CLI::App& app, Command& command);
/// Tells whether this machine suffices, or measures a device.
void add_check_command(CLI::App& app, Command& command);
/// Lists connected devices, whether they are ready, and every word that --device takes.
void add_devices_command(CLI::App& app, Command& command);

}  // namespace touchable
