#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "player/draw/overlays.hpp"
#include "player/draw/pictures.hpp"
#include "player/session/touch_setup.hpp"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace touchable {

/// `--picture` and what goes with it, as typed.
struct PictureOptions {
    std::optional<std::filesystem::path> file;  ///< nothing: no picture is asked for
    std::string view = usual_viewpoint;
    std::string painter = "auto";  ///< as in make_painter
    std::string size = "1280x720";
    Overlay show = Overlay::colour;

    bool draws_on_gpu() const { return file && painter != "cpu"; }
};

/// Refuses a name of a picture that other programs would take for something else than PNG.
CLI::Validator ends_in_png();

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
