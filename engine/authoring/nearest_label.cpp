#include "engine/authoring/nearest_label.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace touchable {
namespace {

constexpr std::int32_t straight = 3, diagonal = 4, nowhere = std::numeric_limits<std::int32_t>::max() / 2;

}  // namespace

/// With weights of 3 and 4 (chamfer): once from the upper left and once back.
void NearestLabel::fill(std::vector<std::uint16_t>& labels, int columns, int rows) {
    const std::ptrdiff_t width = columns, height = rows;
    if (std::find(labels.begin(), labels.end(), 0) == labels.end()) return;
    distances_.resize(labels.size());
    std::transform(labels.begin(), labels.end(), distances_.begin(),
                   [](std::uint16_t label) { return label == 0 ? nowhere : 0; });
    const auto pass = [&](std::ptrdiff_t step) {
        const auto count = static_cast<std::ptrdiff_t>(labels.size());
        for (std::ptrdiff_t k = step > 0 ? 0 : count - 1; k >= 0 && k < count; k += step) {
            const auto at = static_cast<std::size_t>(k);
            if (distances_[at] == 0) continue;
            const std::ptrdiff_t x = k % width, y = k / width;
            const auto look = [&](std::ptrdiff_t dx, std::ptrdiff_t dy, std::int32_t weight) {
                if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) return;
                const auto from = static_cast<std::size_t>(k + dy * width + dx);
                if (distances_[from] + weight >= distances_[at]) return;
                distances_[at] = distances_[from] + weight;
                labels[at] = labels[from];
            };
            look(-step, 0, straight);
            look(0, -step, straight);
            look(-step, -step, diagonal);
            look(step, -step, diagonal);
        }
    };
    pass(1);
    pass(-1);
}

}  // namespace touchable
