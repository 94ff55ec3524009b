#include "engine/surface/terrace_patch.hpp"

#include <algorithm>
#include <cstring>

namespace touchable {

template <int reach>
TerracePatch<reach>::TerracePatch(int width, int height, int bx, int by)
    : left_(std::max(bx * block - reach, 0)),
      right_(std::min(bx * block + block - 1 + reach, width - 1)),
      top_(std::max(by * block - reach, 0)),
      bottom_(std::min(by * block + block - 1 + reach, height - 1)) {
    std::memset(masks_, 0xFF, sizeof(masks_));
    std::memset(holes_, 0xFF, sizeof(holes_));
}

template <int reach>
void TerracePatch<reach>::set(int x, int y, std::uint16_t code, const TerraceFilter& filter) {
    const int column = x - left_, line = y - top_;
    before_[line][margin + column] = static_cast<std::int16_t>(filter.working.of(code));
    masks_[line][margin + column] = 0;
    holes_[line][beyond + column / strip_pixels] &= ~(std::uint32_t{1} << (column % strip_pixels));
}

/// What lies beyond the patch counts as outside. That is wrong where the picture goes on, and each pass
/// carries it inward by its step: in all by the reach, which is just not to the block.
template <int reach>
void TerracePatch<reach>::level(const TerraceFilter& filter) {
    const VectorUnit unit = usable_vector_units().front();
    std::memcpy(codes_, before_, sizeof(codes_));
    for (int line = 0; line <= bottom_ - top_; ++line)
        find_gates(unit, filter, before_[line] + margin, words, gates_[line], most_[line]);
    for (int pass = 0; pass < filter.passes(); ++pass) {
        const int step = filter.tap_of(pass);
        const bool is_last = pass + 1 == filter.passes();
        for (int y = top_; y <= bottom_; ++y)
            level_row(unit, row(codes_, step, y - step), row(codes_, step, y), row(codes_, step, y + step),
                      words, {step, filter, is_last}, next_[y - top_] + margin);
        std::memcpy(codes_, next_, sizeof(codes_));
    }
}

template <int reach>
bool TerracePatch<reach>::is_set(int x, int y) const {
    return masks_[y - top_][margin + x - left_] == 0;
}

template <int reach>
std::uint16_t TerracePatch<reach>::code(int x, int y) const {
    const int line = y - top_, column = margin + x - left_;
    const std::uint16_t was = static_cast<std::uint16_t>(before_[line][column]);
    const int most = most_[line][x - left_], after = static_cast<std::uint16_t>(codes_[line][column]);
    return static_cast<std::uint16_t>(std::clamp(after, 2 * (was - most), 2 * (was + most)));
}

template <int reach>
TerraceRow TerracePatch<reach>::row(const std::int16_t (&codes)[side][pitch], int tap, int y) const {
    const bool inside = y >= top_ && y <= bottom_;
    const int line = inside ? y - top_ : 0, known = inside ? line : side;
    return {codes[line] + margin, masks_[known] + margin, holes_[known] + beyond,
            TerraceFilter::is_wide(tap) ? most_[line] : gates_[line]};
}

template class TerracePatch<16>;
template class TerracePatch<32>;
template class TerracePatch<64>;
template class TerracePatch<128>;

}  // namespace touchable
