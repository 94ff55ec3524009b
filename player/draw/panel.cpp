#include "player/draw/panel.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

namespace touchable::panel {
namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

}  // namespace

void ink(cairo_t* c, double opacity) {
    cairo_set_source_rgba(c, 0.93, 0.94, 0.96, opacity);
}

void ground(cairo_t* c, double x, double y, double width, double height) {
    cairo_set_source_rgba(c, 0.05, 0.06, 0.08, 0.72);
    cairo_rectangle(c, x, y, width, height);
    cairo_fill(c);
}

double text_width(cairo_t* c, const std::string& text) {
    cairo_text_extents_t extents;
    cairo_text_extents(c, text.c_str(), &extents);
    return extents.x_advance;
}

Result<void> draw(Image& image, const std::string& name,
                  const std::function<void(cairo_t*, const Frame&)>& drawing) {
    if (image.width < 480 || image.height < 270) return {};
    // Cairo's pixels are words of the host: red, green and blue from bit 16 down.
    std::vector<std::uint32_t> words(image.samples.size() / 3);
    for (std::size_t k = 0; k < words.size(); ++k)
        words[k] = std::uint32_t{image.samples[3 * k]} << 16 | std::uint32_t{image.samples[3 * k + 1]} << 8 |
                   image.samples[3 * k + 2];
    auto* memory = static_cast<unsigned char*>(static_cast<void*>(words.data()));
    const Surface surface(cairo_image_surface_create_for_data(memory, CAIRO_FORMAT_RGB24, image.width,
                                                              image.height, 4 * image.width),
                          cairo_surface_destroy);
    const Context context(cairo_create(surface.get()), cairo_destroy);
    // Grows with the picture; a small one has the smallest letters that can be read.
    const double scale = std::max(std::min(image.height / 720.0, image.width / 900.0), 0.8);
    cairo_scale(context.get(), scale, scale);
    cairo_select_font_face(context.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context.get(), text_size);
    drawing(context.get(), {image.width / scale, image.height / scale, scale});
    cairo_surface_flush(surface.get());
    if (const cairo_status_t status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS)
        return Error{ErrorKind::internal,
                     "the " + name + " cannot be drawn: " + cairo_status_to_string(status)};
    for (std::size_t k = 0; k < words.size(); ++k)
        for (std::size_t channel = 0; channel < 3; ++channel)
            image.samples[3 * k + channel] = static_cast<std::uint8_t>(words[k] >> (16 - 8 * channel) & 255U);
    return {};
}

}  // namespace touchable::panel
