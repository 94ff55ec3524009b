#include "engine/surface/changed_pixels.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "engine/surface/vectors.hpp"

namespace touchable {
namespace {

/// Rows that are compared at a time.
constexpr int rows_at_once = 4;

/// A block's row in which nothing differs, of at most 3 channels or 2 bytes.
constexpr std::uint8_t nothing[3 * BlockGrid::width] = {};

/// Adds to `columns` the bits of every byte that differ in one of the rows.
template <class Lanes>
[[gnu::always_inline]] inline void add_differences(const std::uint8_t* const (&before)[rows_at_once],
                                                   const std::uint8_t* const (&after)[rows_at_once],
                                                   int bytes, std::uint8_t* columns) {
    constexpr int step = sizeof(Lanes);
    int n = 0;
    for (; n + step <= bytes; n += step) {
        Lanes sum;
        std::memcpy(&sum, columns + n, step);
        for (int k = 0; k < rows_at_once; ++k) {
            Lanes a, b;
            std::memcpy(&a, before[k] + n, step);
            std::memcpy(&b, after[k] + n, step);
            sum |= a ^ b;
        }
        std::memcpy(columns + n, &sum, step);
    }
    for (; n < bytes; ++n)
        for (int k = 0; k < rows_at_once; ++k)
            columns[n] = static_cast<std::uint8_t>(columns[n] | (before[k][n] ^ after[k][n]));
}

int bytes_of_row(const PlaneView& plane) {
    return plane.width * plane.channels * plane.bytes_per_sample;
}

}  // namespace

PlaneComparison::Piece PlaneComparison::piece(int column) const {
    const int x = column * BlockGrid::width, pixels = std::min(BlockGrid::width, after_.width - x);
    const int pixel_bytes = after_.channels * after_.bytes_per_sample;
    return {x, pixels, x * pixel_bytes, pixels * pixel_bytes};
}

bool PlaneComparison::same(const Piece& piece, int y) const {
    return std::memcmp(before_.row(y) + piece.offset, after_.row(y) + piece.offset,
                       static_cast<std::size_t>(piece.bytes)) == 0;
}

int PlaneComparison::changed_at_top(int block_row) const {
    const int top = block_row * BlockGrid::height;
    if (std::memcmp(before_.row(top), after_.row(top), static_cast<std::size_t>(bytes_of_row(after_))) == 0)
        return 0;
    int changed = 0;
    for (int column = 0; column < BlockGrid::of(after_.width, after_.height).columns; ++column)
        changed += !same(piece(column), top);
    return changed;
}

void PlaneComparison::find(int block_row, std::span<PixelBox> boxes,
                           std::vector<std::uint8_t>& columns) const {
    const int top = block_row * BlockGrid::height, bottom = std::min(top + BlockGrid::height, after_.height);
    columns.assign(static_cast<std::size_t>(bytes_of_row(after_)), 0);
    add_rows(top, bottom, columns);
    const int pixel_bytes = after_.channels * after_.bytes_per_sample;
    for (int column = 0; PixelBox & box : boxes) {
        const Piece block = piece(column++);
        box = {};
        const std::uint8_t *begin = columns.data() + block.offset, *end = begin + block.bytes;
        if (std::memcmp(begin, nothing, static_cast<std::size_t>(block.bytes)) == 0) continue;
        const auto differs = [](std::uint8_t bits) { return bits != 0; };
        const std::uint8_t* first = std::find_if(begin, end, differs);
        const std::uint8_t* last =
            std::find_if(std::reverse_iterator(end), std::reverse_iterator(first), differs).base();
        box = {block.x + static_cast<int>(first - begin) / pixel_bytes, top,
               block.x + static_cast<int>(last - begin - 1) / pixel_bytes + 1, bottom};
    }
}

void PlaneComparison::narrow(PixelBox& box) const {
    const Piece block = piece(box.left / BlockGrid::width);
    while (same(block, box.top)) ++box.top;
    while (same(block, box.bottom - 1)) --box.bottom;
}

void PlaneComparison::add_rows(int first, int last, std::vector<std::uint8_t>& columns) const {
    for (int y = first; y < last; y += rows_at_once) {
        const std::uint8_t *before[rows_at_once], *after[rows_at_once];
        for (int k = 0; k < rows_at_once; ++k) {
            before[k] = before_.row(std::min(y + k, last - 1));
            after[k] = after_.row(std::min(y + k, last - 1));
        }
        run_vectors(
            unit_, [&](auto kind) __attribute__((always_inline)) {
                add_differences<typename decltype(kind)::Lanes>(before, after, bytes_of_row(after_),
                                                                columns.data());
            });
    }
}

}  // namespace touchable
