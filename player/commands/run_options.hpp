#pragma once

namespace CLI {
class App;
}
namespace CLI {
class App;
class Option;
}  // namespace CLI

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// Adds --builder, which may be one of `names`, and --gpu.
void add_builder_options(CLI::App& sub, BuilderChoice& choice, const std::vector<std::string>& names);

/// Refused (ErrorKind::usage) where GPU options are given and nothing of the run uses a GPU.
Result<void> check_gpu_options(const BuilderChoice& choice, bool draws_on_gpu);

/// Devices that a person holds, as on the command line.
struct HeldDeviceWords {
    std::vector<std::string> devices;              ///< "falcon", "network:port=6000"; several are one hand
    bool force_on = false;                         ///< asked for before the start
    std::optional<std::string> world_from_camera;  ///< 16 numbers, or a file with them
    bool is_looked_for_always = false;             ///< one that is gone, not only for ten seconds
};

/// What `--world-from-camera` says: a rotation and a translation in metres. An error (ErrorKind::usage) where
/// it is none.
Result<glm::dmat4> read_world_from_camera(const std::string& words);

/// --device, --force-on, --world-from-camera, --hand-scale.
std::vector<CLI::Option*> add_held_device_options(CLI::App& sub, HeldDeviceWords& words,
                                                  SessionOptions& session);

/// Those of a window, in which forces are asked for once it is there: all but --force-on.
std::vector<CLI::Option*> add_window_device_options(CLI::App& sub, HeldDeviceWords& words,
                                                    SessionOptions& session);

/// Files that they are read from.
std::vector<std::filesystem::path> files_of(const HeldDeviceWords& words);

/// Makes the devices, not opened yet, and the process that leaves them unpowered; a simulated one is the
/// hand's. Best called before there is much in memory. Refuses (ErrorKind::usage) what is none.
Result<void> hold_devices(const HeldDeviceWords& words, SessionOptions& session);

/// What to do now, for the person who holds it; one line.
std::string how_to_begin(const HapticDevice& device, const HandControl& control, bool has_terminal);
/// What it waits for, and whether forces are on; short.
std::string state_of(const HapticDevice& device, const HandControl& control);

/// How the clip is played, as typed.
struct PlaybackTyped {
    std::optional<double> start;  ///< seconds
    std::optional<double> rate;
    std::vector<double> loop;  ///< seconds: none, or begin and end
    std::optional<std::filesystem::path> script;
};

/// --start, --rate, --loop and --play.
std::vector<CLI::Option*> add_playback_options(CLI::App& sub, PlaybackTyped& typed);

/// What is typed takes effect with the first tick, before what a script says of it. A loop is begun with
/// where no --start says otherwise.
Result<std::vector<PlaybackCommand>> read_playback(const PlaybackTyped& typed);

}  // namespace touchable
