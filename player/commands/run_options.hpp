#pragma once

// Options of commands that compute a surface, touch it or draw it: the builder, the devices that a person
// holds, how the clip is played, and a picture. For each an add_* function adds the options to a subcommand,
// and a struct has what was typed until a second function makes settings of it, or refuses it
// (ErrorKind::usage). By the main thread.

#include <CLI/CLI.hpp>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "player/draw/overlays.hpp"
#include "player/draw/pictures.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// Adds --builder, which may be one of `names`, and --gpu.
void add_builder_options(CLI::App& sub, BuilderChoice& choice, const std::vector<const char*>& names);

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

/// --device, --force-on, --world-from-camera, --hand-scale. In a window forces are asked for once it is
/// there, and there is no --force-on.
void add_device_options(CLI::App& sub, HeldDeviceWords& words, SessionOptions& session, bool in_window);

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
void add_playback_options(CLI::App& sub, PlaybackTyped& typed);

/// What is typed takes effect with the first tick, before what a script says of it. A loop is begun with
/// where no --start says otherwise.
Result<std::vector<PlaybackCommand>> read_playback(const PlaybackTyped& typed);

/// `--picture` and what goes with it, as typed.
struct PictureOptions {
    std::optional<std::filesystem::path> file;  ///< nothing: no picture is asked for
    std::string view = usual_viewpoint;
    std::string painter = "auto";  ///< as in make_painter
    std::string size = "1280x720";
    Overlay show = Overlay::colour;

    bool draws_on_gpu() const { return file && painter != "cpu"; }
};

/// Adds --painter, as make_painter takes it.
CLI::Option* add_painter_option(CLI::App& sub, std::string& painter);

/// Adds --picture FILE, --view, --painter, --picture-size and --show.
void add_picture_options(CLI::App& sub, PictureOptions& options);

/// What to draw and where to, checked before any work: view and size make sense, the painter is to be had,
/// and the file can be written.
struct PictureOrder {
    std::unique_ptr<NewFile> file;
    SurfacePainter::Settings settings;
    std::unique_ptr<SurfacePainter> painter;
    bool any_painter = false;  ///< where the GPU fails, the cpu may draw instead
    Overlay show = Overlay::colour;

    /// Draws the surface of `field`, which was made of `pair`, coloured by what it is to show (`colour`,
    /// where that is not empty), and writes the file.
    Result<void> deliver(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                         std::span<const FingerMark> fingers);

private:
    Result<Image> draw(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                       std::span<const FingerMark> fingers);
    Result<Image> draw(const HeightField& field, const ViewSurface& surface,
                       std::span<const FingerMark> fingers);
    Result<Image> draw_overlay(const HeightField& field, const FramePair& pair,
                               std::span<const FingerMark> fingers);
};
/// Nothing where no picture is asked for. `gpu` is that of `choice`, and opened only for a painter that needs
/// it; one that is asked for by name and is not to be had is refused.
Result<std::optional<PictureOrder>> order_picture(const PictureOptions& options, Existing existing,
                                                  const BuilderChoice& choice, RunGpu& gpu);

}  // namespace touchable
