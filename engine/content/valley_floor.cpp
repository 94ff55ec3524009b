#include "engine/content/valley_floor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

/// A row that a disc reaches, how far it goes there to both sides, in cells (round a pole all of the row),
/// and what a cell there has of the sphere's area.
struct Reach {
    int row, half_width;
    double cell_area;
};

/// Of a disc around any cell of a row: the great circle from latitude a to b, c apart in longitude, has the
/// cosine sin a sin b + cos a cos b cos c.
std::vector<Reach> disc(const HeightGrid& grid, int row, double radius) {
    const double step = pi / grid.height;
    const auto latitude = [&](int r) { return 0.5 * pi - (r + 0.5) * step; };
    const int rows = static_cast<int>(radius / step);
    std::vector<Reach> reaches;
    for (int other = std::max(0, row - rows); other <= std::min(grid.height - 1, row + rows); ++other) {
        const double a = latitude(row), b = latitude(other);
        const double cosine_of_width = (cosine(radius) - sine(a) * sine(b)) / (cosine(a) * cosine(b));
        if (cosine_of_width > 1) continue;
        const double half = cosine_of_width < -1 ? pi : 0.5 * pi - arcsine(cosine_of_width);
        const int cells = static_cast<int>(half / (2 * pi) * grid.width);
        reaches.push_back({other, cells, cosine(b)});
    }
    return reaches;
}

/// The lowest within `half_width` of each cell of a row, round the globe: of blocks as long as the window the
/// lowest so far from both sides (van Herk), so that its length does not matter.
void lower_to_lowest_within(const float* row, int width, int half_width, float* lowest,
                            std::vector<float>& room) {
    const int window = 2 * half_width + 1, length = width + 2 * half_width;
    room.resize(2 * static_cast<std::size_t>(length));
    float *ahead = room.data(), *behind = room.data() + length;
    const auto at = [&](int k) { return row[(k - half_width + width) % width]; };
    for (int k = 0; k < length; ++k) ahead[k] = k % window == 0 ? at(k) : std::min(ahead[k - 1], at(k));
    for (int k = length - 1; k >= 0; --k)
        behind[k] = k == length - 1 || (k + 1) % window == 0 ? at(k) : std::min(behind[k + 1], at(k));
    for (int x = 0; x < width; ++x)
        lowest[x] = std::min(lowest[x], std::min(behind[x], ahead[x + window - 1]));
}

HeightGrid lowest_within(const HeightGrid& heights, double radius, RowBands& rows) {
    HeightGrid lowest = heights;
    const auto width = static_cast<std::size_t>(heights.width);
    rows.for_each_band(heights.height, 1, [&](const RowBand& band) {
        std::vector<float> room;
        for (int y = band.first; y < band.last; ++y)
            for (const Reach& reach : disc(heights, y, radius))
                lower_to_lowest_within(&heights.values[static_cast<std::size_t>(reach.row) * width],
                                       heights.width, reach.half_width,
                                       &lowest.values[static_cast<std::size_t>(y) * width], room);
    });
    return lowest;
}

/// Weights fall evenly from the middle: the mean of the means over discs of a third, two thirds and all of
/// the radius.
HeightGrid mean_within(const HeightGrid& heights, double radius, RowBands& rows) {
    HeightGrid mean = heights;
    const auto width = static_cast<std::size_t>(heights.width);
    constexpr int discs = 3;
    rows.for_each_band(heights.height, 1, [&](const RowBand& band) {
        std::vector<double> sums(3 * width + 1), total(width);
        for (int y = band.first; y < band.last; ++y) {
            std::vector<double> means(width);
            for (int k = 1; k <= discs; ++k) {
                std::fill(total.begin(), total.end(), 0.0);
                double area = 0;
                for (const Reach& reach : disc(heights, y, radius * k / discs)) {
                    const float* row = &heights.values[static_cast<std::size_t>(reach.row) * width];
                    for (std::size_t x = 0; x < 3 * width; ++x)
                        sums[x + 1] = sums[x] + double{row[x % width]};
                    const auto half = static_cast<std::size_t>(reach.half_width),
                               cells = std::min(2 * half + 1, width);  // each of the row once
                    for (std::size_t x = 0; x < width; ++x) {
                        const std::size_t first = width + x - half;
                        total[x] += reach.cell_area * (sums[first + cells] - sums[first]);
                    }
                    area += reach.cell_area * static_cast<double>(cells);
                }
                for (std::size_t x = 0; x < width; ++x) means[x] += total[x] / area;
            }
            float* out = &mean.values[static_cast<std::size_t>(y) * width];
            for (std::size_t x = 0; x < width; ++x) out[x] = static_cast<float>(means[x] / discs);
        }
    });
    return mean;
}

}  // namespace

HeightGrid valley_floor(const HeightGrid& heights, double radius, RowBands& rows) {
    // A little more than the mean reaches, so that it is bilinearly between cells, too.
    const double margin = 1.5 * pi / heights.height;
    HeightGrid floor = mean_within(lowest_within(heights, radius + margin, rows), radius, rows);
    // What rounding and the last cell of a disc leave.
    for (std::size_t n = 0; n < floor.values.size(); ++n)
        floor.values[n] = std::clamp(floor.values[n], 0.0F, heights.values[n]);
    return floor;
}

}  // namespace touchable
