#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/result.hpp"
#include "player/view/scene_picture.hpp"

namespace CLI {
class App;
}

namespace touchable {

/// `--picture` and what goes with it, as typed.
struct PictureOptions {
    std::optional<std::filesystem::path> file;  ///< nothing: no picture is asked for
    std::string view = "orbit:az=20,el=15";
    std::string painter = "auto";  ///< as in make_painter
    std::string size = "1280x720";
};

/// Adds --picture FILE, --view, --painter and --picture-size.
void add_picture_options(CLI::App& sub, PictureOptions& options);

/// What to draw and where to, checked before any work: view and size make sense, the painter is to be had,
/// and the file can be written.
struct PictureOrder {
    std::filesystem::path file;
    PictureSettings settings;
    std::unique_ptr<SurfacePainter> painter;

    /// Draws the surface of `field`, which was made of `pair`, coloured by `colour` where that is not empty,
    /// and writes the file.
    Result<void> deliver(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                         std::span<const FingerMark> fingers);
};
/// Nothing where no picture is asked for.
Result<std::optional<PictureOrder>> order_picture(const PictureOptions& options);

}  // namespace touchable
