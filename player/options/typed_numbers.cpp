#include "player/options/typed_numbers.hpp"

namespace touchable {

Result<PixelSize> read_pixel_size(const std::string& option, std::string_view text, int least, int most) {
    const std::size_t cross = text.find('x');
    if (cross != std::string_view::npos) {
        const auto width = read_whole_number(option, text.substr(0, cross), least, most);
        const auto height = read_whole_number(option, text.substr(cross + 1), least, most);
        if (width.ok() && height.ok()) return PixelSize{*width, *height};
    }
    return usage_error(option + " '" + std::string(text) +
                       "' is no size; right would be WIDTHxHEIGHT in pixels, each " + std::to_string(least) +
                       " to " + std::to_string(most) + ", such as 720x480");
}

}  // namespace touchable
