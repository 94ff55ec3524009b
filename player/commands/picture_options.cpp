#include "player/commands/picture_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <utility>

#include "engine/base/try.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

constexpr int largest_side = 8192;

/// What other programs take a picture for by its name is what it is.
std::string fault_of_name(const std::string& name) {
    std::string ending = std::filesystem::path(name).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return ending == ".png" ? "" : "'" + name + "' does not end in .png; a picture is a PNG file";
}

Words<Overlay> words_of_overlays() {
    Words<Overlay> words;
    Overlay overlay = Overlay::colour;
    do {
        words.emplace_back(name_of(overlay), overlay);
        overlay = overlay_after(overlay, "").value();
    } while (overlay != Overlay::colour);
    return words;
}

}  // namespace

CLI::Validator ends_in_png() {
    return {[](std::string& name) { return fault_of_name(name); }, ""};
}

void add_picture_options(CLI::App& sub, PictureOptions& options) {
    auto* picture = add_file_option(sub, "--picture", options.file, "draw the scene to this PNG file")
                        ->check(ends_in_png());
    sub.add_option("--view", options.view,
                   "from where: own (the clip's camera), or orbit:az=DEGREES,el=DEGREES,zoom=Z,fov=DEGREES; "
                   "what is left out is the clip's camera's")
        ->needs(picture)
        ->capture_default_str();
    sub.add_option("--painter", options.painter,
                   "cpu, raster (compute), mesh (triangles), or auto: mesh on a GPU, else what there is")
        ->needs(picture)
        ->check(CLI::IsMember({"auto", "cpu", "raster", "mesh"}))
        ->capture_default_str();
    sub.add_option("--picture-size", options.size, "pixels")->needs(picture)->capture_default_str();
    add_word_option(
        sub, "--show", options.show,
        "coloured by: colour (the clip's), depth (equalised), depth-linear, stiffness, friction (static), "
        "dynamic-friction, height, normals, tiles (which are drawn) or validity",
        words_of_overlays())
        ->needs(picture);
}

Result<std::optional<PictureOrder>> order_picture(const PictureOptions& options, Existing existing,
                                                  const BuilderChoice& choice, RunGpu& gpu) {
    if (!options.file) return std::optional<PictureOrder>();
    PictureOrder order;
    TRY_ASSIGN(const auto viewpoint, parse_viewpoint(options.view));
    order.settings.viewpoint = viewpoint;
    TRY_ASSIGN(const auto size, read_pixel_size("--picture-size", options.size, 1, largest_side));
    order.settings.width = size.width;
    order.settings.height = size.height;
    if (options.draws_on_gpu() && choice.names_gpu()) TRY(gpu.open());
    TRY_ASSIGN(auto painter, make_painter(options.painter, [&gpu] { return gpu.open(); }));
    order.painter = std::move(painter);
    order.any_painter = options.painter == "auto";
    order.show = options.show;
    order.file = std::make_unique<NewFile>(*options.file, existing);
    if (auto usable = order.file->check(); !usable.ok())
        return Error{usable.error().kind, "--picture " + usable.error().message};
    return std::optional<PictureOrder>(std::move(order));
}

Result<Image> PictureOrder::draw(const HeightField& field, const ViewSurface& surface,
                                 std::span<const FingerMark> fingers) {
    const Viewpoint::Subject subject = subject_of(field);
    return make_picture(settings, field.scene(), surface, subject, fingers,
                        mark_sizes(field.scene(), subject.middle), *painter);
}

Result<Image> PictureOrder::draw_overlay(const HeightField& field, const FramePair& pair,
                                         std::span<const FingerMark> fingers) {
    Overlays overlays;
    const Overlays::Picture& overlay = overlays.paint(show, field, pair);
    TRY_ASSIGN(auto surface, painter->surface_of(field, pair, overlay.view()));
    quieten_light(show, overlay, surface);
    TRY_ASSIGN(auto image, draw(field, surface, fingers));
    TRY(draw_scale_bar(overlay.scale, image));
    return image;
}

Result<Image> PictureOrder::draw(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                                 std::span<const FingerMark> fingers) {
    if (show != Overlay::colour) return draw_overlay(field, pair, fingers);
    TRY_ASSIGN(const auto surface, painter->surface_of(field, pair, colour));
    return draw(field, surface, fingers);
}

Result<void> PictureOrder::deliver(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                                   std::span<const FingerMark> fingers) {
    auto image = draw(field, pair, colour, fingers);
    if (!image.ok() && image.error().kind == ErrorKind::gpu && any_painter) {
        std::cerr << "touchable: warning: " << image.error().message << "; the cpu painter draws instead\n";
        painter = make_cpu_painter();
        image = draw(field, pair, colour, fingers);
    }
    if (!image.ok()) return image.error();
    if (auto written = write_png(*file, image->view()); !written.ok()) return written;
    return file->commit();
}

}  // namespace touchable
