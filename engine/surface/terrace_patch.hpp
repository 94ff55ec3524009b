#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/scene/terraces.hpp"
#include "engine/surface/terrace_rows.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {

/// The side of the blocks from which terraces are removed at a time. What is around a block costs as it does
/// itself, so blocks grow with the reach. At half of it the few pixels below a finger, which lie in a block
/// or two each way, cost the least.
constexpr int terrace_block(int reach) {
    return std::max(least_terrace_reach, reach / 2);
}

/// Terrace removal of a block of pixels, with all the pixels that it depends on, on the stack. `reach`: the
/// filter's; of the farthest a patch takes 1.6 MB.
template <int reach>
class TerracePatch {
public:
    static constexpr int block = terrace_block(reach);

    /// Block (bx, by) of a picture; its pixels and those of the patch are named as the picture's.
    TerracePatch(int width, int height, int bx, int by);
    int left() const { return left_; }
    int right() const { return right_; }  ///< the last column of the patch
    int top() const { return top_; }
    int bottom() const { return bottom_; }

    /// To be called for every valid pixel of the patch, with its code by the scene's coding.
    void set(int x, int y, std::uint16_t code, const TerraceFilter& filter);
    void level(const TerraceFilter& filter);
    bool is_set(int x, int y) const;
    /// After `level`: the finer code of a pixel of the block that was set.
    std::uint16_t code(int x, int y) const;

private:
    static constexpr int side = block + 2 * reach, margin = reach / 2, beyond = words_beyond(margin);
    static constexpr int words = (side + strip_pixels - 1) / strip_pixels;
    static constexpr int pitch = words * strip_pixels + 2 * margin;

    TerraceRow row(const std::int16_t (&codes)[side][pitch], int tap, int y) const;

    int left_, right_, top_, bottom_;
    std::int16_t before_[side][pitch] = {}, codes_[side][pitch] = {}, next_[side][pitch] = {};
    std::int16_t gates_[side][words * strip_pixels], most_[side][words * strip_pixels];
    std::int16_t masks_[side + 1][pitch];  // the last row of both: outside
    std::uint32_t holes_[side + 1][words + 2 * beyond];
};

}  // namespace touchable
