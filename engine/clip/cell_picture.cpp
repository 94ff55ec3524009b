#include "engine/clip/cell_picture.hpp"

#include <algorithm>
#include <limits>

namespace touchable {
namespace {

constexpr int usual_cells = 4800, least_side = 4;
/// A cell whose codes differ by more of the frame's range holds two surfaces.
constexpr int step_share = 8;
constexpr int least_texture = 24;  // levels of brightness, from the darkest pixel to the brightest

int side_of_cells(int width, int height) {
    int side = least_side;
    while ((width / side) * (height / side) > usual_cells) ++side;
    return side;
}

struct CellDepths {
    std::int64_t sum = 0;
    std::int32_t least = std::numeric_limits<std::int32_t>::max(), most = 0;
    bool is_whole = true;
};

template <class Sample>
CellDepths depths_of(const PlaneView& plane, const DepthCoding& coding, int x0, int y0, int side) {
    CellDepths depths;
    for (int y = y0; y < y0 + side; ++y) {
        const auto* row = reinterpret_cast<const Sample*>(plane.row(y)) + x0;
        for (int x = 0; x < side; ++x) {
            const std::int32_t code = row[x];
            depths.sum += code;
            depths.least = std::min(depths.least, code);
            depths.most = std::max(depths.most, code);
        }
    }
    if (coding.all_valid(static_cast<std::uint16_t>(depths.least), static_cast<std::uint16_t>(depths.most)))
        return depths;
    // Some pixel has none: the others still tell the frame's range.
    depths = {.is_whole = false};
    for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x)
            if (const std::uint16_t code = plane.sample(x, y); coding.is_valid(code)) {
                depths.least = std::min<std::int32_t>(depths.least, code);
                depths.most = std::max<std::int32_t>(depths.most, code);
            }
    return depths;
}

void read_luma(const PlaneView& colour, int x0, int y0, int side, Cell& cell) {
    std::int64_t sum = 0;
    std::int32_t least = std::numeric_limits<std::int32_t>::max(), most = 0;
    for (int y = y0; y < y0 + side; ++y) {
        const std::uint8_t* rgb = colour.row(y) + 3 * std::ptrdiff_t{x0};
        for (int x = 0; x < side; ++x, rgb += 3) {
            const std::int32_t luma = 77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2];  // of 256 a level
            sum += luma;
            least = std::min(least, luma);
            most = std::max(most, luma);
        }
    }
    cell.luma = static_cast<std::int32_t>(sum * Cell::per_level / (256 * std::int64_t{side} * side));
    cell.is_textured = most - least >= 256 * least_texture;
}

/// Cells beside much darker or brighter ones change too, where anything moves.
void mark_borders(std::vector<Cell>& cells, int columns) {
    constexpr std::int32_t step = least_texture * Cell::per_level;
    const auto across = static_cast<std::size_t>(columns);
    const auto part = [&](Cell& a, Cell& b) {
        if (a.luma - b.luma >= step || b.luma - a.luma >= step) a.is_textured = b.is_textured = true;
    };
    for (std::size_t k = 0; k < cells.size(); ++k) {
        if (k % across + 1 < across) part(cells[k], cells[k + 1]);
        if (k + across < cells.size()) part(cells[k], cells[k + across]);
    }
}

}  // namespace

CellPicture cell_picture(const RawFrame& frame, const DepthCoding& coding) {
    const PlaneView& plane = frame.depth;
    const int side = std::min({side_of_cells(plane.width, plane.height), plane.width, plane.height});
    const int columns = plane.width / side, rows = plane.height / side;
    CellPicture picture;
    picture.has_colour =
        !frame.colour.empty() && frame.colour.width == plane.width && frame.colour.height == plane.height;
    picture.cells.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    std::vector<std::int32_t> spreads(picture.cells.size());
    std::int32_t least = std::numeric_limits<std::int32_t>::max(), most = -1;
    for (std::size_t k = 0; k < picture.cells.size(); ++k) {
        const int x = side * (static_cast<int>(k) % columns), y = side * (static_cast<int>(k) / columns);
        const CellDepths depths = plane.bytes_per_sample == 1
                                      ? depths_of<std::uint8_t>(plane, coding, x, y, side)
                                      : depths_of<std::uint16_t>(plane, coding, x, y, side);
        Cell& cell = picture.cells[k];
        if (depths.most >= depths.least) {
            least = std::min(least, depths.least);
            most = std::max(most, depths.most);
            spreads[k] = depths.most - depths.least;
        }
        if (depths.is_whole)
            cell.depth = static_cast<std::int32_t>(depths.sum * Cell::per_code / (std::int64_t{side} * side));
        if (picture.has_colour) read_luma(frame.colour, x, y, side, cell);
    }
    if (picture.has_colour) mark_borders(picture.cells, columns);
    if (most < least) return picture;
    picture.least = static_cast<std::uint16_t>(least);
    picture.most = static_cast<std::uint16_t>(most);
    for (std::size_t k = 0; k < picture.cells.size(); ++k)
        if (step_share * spreads[k] > most - least + 2 * step_share) picture.cells[k].depth = Cell::none;
    return picture;
}

}  // namespace touchable
