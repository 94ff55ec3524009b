// SPDX-License-Identifier: Apache-2.0
#pragma once

// Options of commands that compute a surface, touch it or draw it: the builder, devices held by the user,
// playback, and a picture. For each group an add_* function adds the options to a subcommand, and a struct
// holds the typed values until a second function turns them into settings or refuses them (ErrorKind::usage).
// TouchOptions are all of `touch`.
// Main thread only.

#include <CLI/CLI.hpp>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "player/draw/overlays.hpp"
#include "player/draw/pictures.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// Adds --builder, one of `names`, and --gpu.
void add_builder_options(CLI::App& sub, BuilderChoice& choice, const std::vector<const char*>& names);

/// Refuses GPU options (ErrorKind::usage) if no part of the run uses a GPU.
Result<void> check_gpu_options(const BuilderChoice& choice, bool draws_on_gpu);

/// Devices held by the user, as on the command line.
struct HeldDeviceWords {
    std::vector<std::string> devices;              ///< "falcon", "network:port=6000"; several form one hand
    bool force_on = false;                         ///< forces are enabled at the start
    std::optional<std::string> world_from_camera;  ///< 16 numbers, or a file with them
    bool is_looked_for_always = false;             ///< search for a lost device beyond ten seconds
};

/// Value of `--world-from-camera`: a rotation and a translation in metres. Anything else is an error
/// (ErrorKind::usage).
Result<glm::dmat4> read_world_from_camera(const std::string& words);

/// Adds --device, --force-on, --world-from-camera, --hand-scale. A window has no --force-on: forces are
/// enabled there by the user.
void add_device_options(CLI::App& sub, HeldDeviceWords& words, SessionOptions& session, bool in_window);

/// Input files named in these options.
std::vector<std::filesystem::path> files_of(const HeldDeviceWords& words);

/// Makes the devices, unopened, and the watchdog process that unpowers them; a simulated device is held by
/// the hand. Call while the process uses little memory. Refuses (ErrorKind::usage) unknown devices.
Result<void> hold_devices(const HeldDeviceWords& words, SessionOptions& session);

/// Next step for the user of the device; one line.
std::string how_to_begin(const HapticDevice& device, const HandControl& control, bool has_terminal);
/// The device's state: what it waits for, whether forces are on; short.
std::string state_of(const HapticDevice& device, const HandControl& control);

/// Playback options, as typed.
struct PlaybackTyped {
    std::optional<double> start;  ///< seconds
    std::optional<double> rate;
    std::vector<double> loop;  ///< seconds: empty, or begin and end
    std::optional<std::filesystem::path> script;
};

/// Adds --start, --rate, --loop and --play.
void add_playback_options(CLI::App& sub, PlaybackTyped& typed);

/// Typed options take effect at the first tick, before the script's commands. Without --start playback begins
/// at the loop's beginning.
Result<std::vector<PlaybackCommand>> read_playback(const PlaybackTyped& typed);

/// `--picture` and related options, as typed.
struct PictureOptions {
    std::optional<std::filesystem::path> file;  ///< nothing: no picture
    std::string view = usual_viewpoint;
    std::string painter = "auto";  ///< see make_painter
    std::string size = "1280x720";
    Overlay show = Overlay::colour;
    std::string light = light_names[0];

    bool draws_on_gpu() const { return file && painter != "cpu"; }
};

/// Adds --painter (make_painter).
CLI::Option* add_painter_option(CLI::App& sub, std::string& painter);

/// Adds --picture FILE, --view, --painter, --picture-size, --show and --light.
void add_picture_options(CLI::App& sub, PictureOptions& options);

/// A picture to draw, checked before any work: view and size are valid, the painter is available, and the
/// file is writable.
struct PictureOrder {
    std::unique_ptr<NewFile> file;
    SurfacePainter::Settings settings;
    std::unique_ptr<SurfacePainter> painter;
    bool any_painter = false;  ///< if the GPU fails, the cpu may draw instead
    Overlay show = Overlay::colour;
    Lighting light = Lighting::off;  ///< on the clip's own colours

    /// Draws the surface of `field`, made from `pair`, coloured by `show` (`colour` if not empty), and writes
    /// the file.
    Result<void> deliver(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                         std::span<const FingerMark> fingers);

private:
    Result<Image> draw(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                       std::span<const FingerMark> fingers);
};
/// Nothing if no picture is requested. `gpu` is that of `choice` and is opened only for a painter that needs
/// it; a painter requested by name but unavailable is refused.
Result<std::optional<PictureOrder>> order_picture(const PictureOptions& options, Existing existing,
                                                  const BuilderChoice& choice, RunGpu& gpu);

/// Options of a run and its outputs.
struct TouchOptions {
    /// With `replay` only the builder and the clip are used; an empty clip: the recorded one.
    SessionOptions session;
    HeldDeviceWords held;
    std::optional<std::filesystem::path> json, forces, record, replay, device_log;
    std::optional<std::filesystem::path> play;  ///< already read into `session.playback`
    Existing existing = Existing::keep;         ///< treatment of existing output files
    bool verbose = false;                       ///< print the whole table
    bool strict = false;                        ///< warnings are an error of kind check
    PictureOptions picture;
    std::optional<std::int64_t> picture_tick;  ///< nothing: 60 % of the run
};

/// Touches a clip at 1 kHz, in virtual time or (live) on the wall clock, prints a table and writes the
/// requested files. With `replay`, repeats a recording: the first different force is an error of kind check
/// that names tick and finger. A live run ended by the user is complete and returns an error that states its
/// length.
Result<void> run_touch(const TouchOptions& options);

}  // namespace touchable
