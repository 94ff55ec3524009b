#include "engine/authoring/segment_figures.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "engine/authoring/pixel_features.hpp"

namespace touchable {
namespace {

/// Texture is what a mean over 9x9 pixels, all of one segment, takes away.
constexpr int blur_reach = 4, blur_side = 2 * blur_reach + 1;
/// A place is inside where it is so far from other segments.
constexpr int inside = 2;
constexpr std::int64_t outside = std::int64_t{1} << 40;  // farther than any place
constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();

struct FigureSums {
    std::int64_t pixels = 0, x = 0, y = 0, deviation = 0, textured = 0;
    std::array<std::int64_t, 3> colour{};
};

std::uint16_t label_at(const Segmentation& of, int x, int y) {
    return of.labels[static_cast<std::size_t>(y) * static_cast<std::size_t>(of.width) +
                     static_cast<std::size_t>(x)];
}

/// All the square around it, as its corners and the middles of its sides tell, is of the same segment.
bool is_within(const Segmentation& of, int x, int y, int reach) {
    if (x < reach || y < reach || x >= of.width - reach || y >= of.height - reach) return false;
    for (int dy = -reach; dy <= reach; dy += reach)
        for (int dx = -reach; dx <= reach; dx += reach)
            if (label_at(of, x + dx, y + dy) != label_at(of, x, y)) return false;
    return true;
}

}  // namespace

void SegmentFigures::find_deviations(const PlaneView& colour, int width, int height, RowBands& bands) {
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    brightness_.resize(pixels);
    deviations_.assign(pixels, 0);
    const auto row_of = [&](auto& plane, int y) {
        return plane.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    };
    bands.for_each_band(height, 1, [&](const RowBand& band) {
        for (int y = band.first; y < band.last; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint8_t* rgb = colour_at(colour, x, y, width, height);
                row_of(brightness_, y)[x] =
                    static_cast<std::uint16_t>((77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2] + 8) / 16);
            }
    });
    bands.for_each_band(height, 1, [&](const RowBand& band) {
        std::vector<std::int32_t> columns(static_cast<std::size_t>(width));
        for (int y = std::max(band.first, blur_reach); y < std::min(band.last, height - blur_reach); ++y) {
            std::fill(columns.begin(), columns.end(), 0);
            for (int from = y - blur_reach; from <= y + blur_reach; ++from)
                for (int x = 0; x < width; ++x)
                    columns[static_cast<std::size_t>(x)] += row_of(brightness_, from)[x];
            std::int32_t sum = 0;
            for (int x = 0; x < width; ++x) {
                sum += columns[static_cast<std::size_t>(x)];
                if (x < blur_side - 1) continue;
                const int middle = x - blur_reach;
                row_of(deviations_, y)[middle] = static_cast<std::uint16_t>(
                    std::abs(row_of(brightness_, y)[middle] - sum / (blur_side * blur_side)));
                sum -= columns[static_cast<std::size_t>(x - blur_side + 1)];
            }
        }
    });
}

/// By label; `place_of_` leads to each.
void SegmentFigures::list_segments(Segmentation& of) {
    place_of_.resize(std::size_t{1} << 16, nowhere);
    of.segments.clear();
    for (const std::uint16_t label : of.labels) {
        if (label == 0 || place_of_[label] != nowhere) continue;
        place_of_[label] = 0;
        of.segments.push_back({label, 0, {}, 0, 0, 0});
    }
    std::sort(of.segments.begin(), of.segments.end(),
              [](const Segment& a, const Segment& b) { return a.label < b.label; });
    for (std::size_t k = 0; k < of.segments.size(); ++k)
        place_of_[of.segments[k].label] = static_cast<std::uint32_t>(k);
}

/// All figures, with the mean place.
void SegmentFigures::find_means(const PlaneView& colour, Segmentation& of) const {
    const int width = of.width, height = of.height;
    std::vector<FigureSums> all(of.segments.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::uint16_t label = label_at(of, x, y);
            if (label == 0) continue;
            FigureSums& sums = all[place_of_[label]];
            ++sums.pixels;
            sums.x += x;
            sums.y += y;
            if (colour.empty()) continue;
            const std::uint8_t* rgb = colour_at(colour, x, y, width, height);
            for (std::size_t c = 0; c < 3; ++c) sums.colour[c] += rgb[c];
            if (!is_within(of, x, y, blur_reach)) continue;
            ++sums.textured;
            sums.deviation += deviations_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                          static_cast<std::size_t>(x)];
        }
    for (std::size_t k = 0; k < all.size(); ++k) {
        const FigureSums& sums = all[k];
        Segment& segment = of.segments[k];
        segment.pixels = static_cast<std::int32_t>(sums.pixels);
        segment.x = static_cast<std::int32_t>(sums.x / sums.pixels);
        segment.y = static_cast<std::int32_t>(sums.y / sums.pixels);
        for (std::size_t c = 0; c < 3; ++c)
            segment.colour[c] = static_cast<std::uint8_t>((sums.colour[c] + sums.pixels / 2) / sums.pixels);
        if (sums.textured > 0)
            segment.contrast =
                static_cast<std::int32_t>((sums.deviation + sums.textured / 2) / sums.textured);
    }
}

/// In place of the mean place the pixel next to it, one inside if there is one.
void SegmentFigures::find_middles(Segmentation& of) const {
    struct Nearest {
        std::int64_t rank = std::numeric_limits<std::int64_t>::max();
        std::int32_t x = 0, y = 0;
    };
    std::vector<Nearest> all(of.segments.size());
    for (int y = 0; y < of.height; ++y)
        for (int x = 0; x < of.width; ++x) {
            const std::uint16_t label = label_at(of, x, y);
            if (label == 0) continue;
            Nearest& nearest = all[place_of_[label]];
            const Segment& segment = of.segments[place_of_[label]];
            const std::int64_t dx = x - segment.x, dy = y - segment.y, away = dx * dx + dy * dy;
            if (away >= nearest.rank) continue;
            const std::int64_t rank = away + (is_within(of, x, y, inside) ? 0 : outside);
            if (rank < nearest.rank) nearest = {rank, x, y};
        }
    for (std::size_t k = 0; k < all.size(); ++k) {
        of.segments[k].x = all[k].x;
        of.segments[k].y = all[k].y;
    }
}

void SegmentFigures::find(const RawFrame& frame, Segmentation& of, RowBands& bands) {
    if (!frame.colour.empty()) find_deviations(frame.colour, of.width, of.height, bands);
    list_segments(of);
    find_means(frame.colour, of);
    find_middles(of);
    for (const Segment& segment : of.segments) place_of_[segment.label] = nowhere;
}

}  // namespace touchable
