#include "player/window/words_scale.hpp"

#include <algorithm>
#include <cmath>

namespace touchable {

double words_scale(const ScreenSize& size, bool from_afar) {
    constexpr double most = 4;
    const double room = std::min(size.width / 1280.0, size.height / 720.0) / size.scale;
    const double grown = std::round(4 * (from_afar ? room : std::sqrt(room))) / 4;
    return std::max(std::min(size.scale * grown, most), size.scale);
}

}  // namespace touchable
