#include "engine/surface/terrace_patch.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace touchable {

TerracePatch::TerracePatch(int width, int height, int bx, int by)
    : left_(std::max(bx * block - terrace_reach, 0)),
      right_(std::min(bx * block + block - 1 + terrace_reach, width - 1)),
      top_(std::max(by * block - terrace_reach, 0)),
      bottom_(std::min(by * block + block - 1 + terrace_reach, height - 1)) {
    std::memset(masks_, 0xFF, sizeof(masks_));
    std::memset(holes_, 0xFF, sizeof(holes_));
}

void TerracePatch::set(int x, int y, std::uint16_t code, const TerraceFilter& filter) {
    const int column = x - left_, line = y - top_;
    before_[line][terrace_margin + column] = static_cast<std::int16_t>(filter.working.of(code));
    masks_[line][terrace_margin + column] = 0;
    holes_[line][1 + column / strip_pixels] &= ~(std::uint32_t{1} << (column % strip_pixels));
}

/// What lies beyond the patch counts as outside. That is wrong where the picture goes on, and each pass
/// carries it inward by its step: in all by terrace_reach, which is just not to the block.
void TerracePatch::level(const TerraceFilter& filter) {
    const VectorUnit unit = usable_vector_units().front();
    std::memcpy(codes_, before_, sizeof(codes_));
    for (int line = 0; line <= bottom_ - top_; ++line)
        find_gates(unit, filter, before_[line] + terrace_margin, words, gates_[line], most_[line]);
    for (const int& step : terrace_steps) {
        const bool is_last = &step == std::end(terrace_steps) - 1;
        for (int y = top_; y <= bottom_; ++y)
            level_row(unit, row(codes_, y - step), row(codes_, y), row(codes_, y + step), words,
                      {step, filter, is_last}, next_[y - top_] + terrace_margin);
        std::memcpy(codes_, next_, sizeof(codes_));
    }
}

bool TerracePatch::is_set(int x, int y) const {
    return masks_[y - top_][terrace_margin + x - left_] == 0;
}

std::uint16_t TerracePatch::code(int x, int y) const {
    const int line = y - top_, column = terrace_margin + x - left_;
    const std::uint16_t was = static_cast<std::uint16_t>(before_[line][column]);
    const int most = most_[line][x - left_], after = static_cast<std::uint16_t>(codes_[line][column]);
    return static_cast<std::uint16_t>(std::clamp(after, 2 * (was - most), 2 * (was + most)));
}

TerraceRow TerracePatch::row(const std::int16_t (&codes)[side][pitch], int y) const {
    const bool inside = y >= top_ && y <= bottom_;
    const int line = inside ? y - top_ : 0, known = inside ? line : side;
    return {codes[line] + terrace_margin, masks_[known] + terrace_margin, holes_[known] + 1, gates_[line]};
}

}  // namespace touchable
