#pragma once

#include "player/commands/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

// Each adds the subcommand of its name to `app`; where a person types that one, it sets `command` to what
// does it.

void add_make_command(CLI::App& app, Command& command);
/// A window in which a clip is watched and touched.
void add_play_command(CLI::App& app, Command& command);
void add_touch_command(CLI::App& app, Command& command);
void add_info_command(CLI::App& app, Command& command);
/// What can be opened, and how.
void add_formats_command(CLI::App& app, Command& command);
/// Writes the scene file of pictures that have none, or of a clip that has it in it.
void add_init_scene_command(CLI::App& app, Command& command);
void add_export_command(CLI::App& app, Command& command);
void add_convert_command(CLI::App& app, Command& command);
/// Writes a clip with heights that its colour suggests.
void add_relief_command(CLI::App& app, Command& command);
/// Writes a clip whose segments feel like materials.
void add_materials_command(CLI::App& app, Command& command);
/// Sends a clip or a camera to whoever listens.
void add_serve_command(CLI::App& app, Command& command);
/// What differs between the forces of two runs of the same hand.
void add_compare_command(CLI::App& app, Command& command);
/// Draws force over time, or where the proxies went over a frame.
void add_plot_command(CLI::App& app, Command& command);
/// Which cameras are plugged in, and how they are touched.
void add_cameras_command(CLI::App& app, Command& command);

}  // namespace touchable
