// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "engine/base/vectors.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/code_rows.hpp"

namespace touchable {

/// A row of working codes, for one pass of terrace removal. Pixels that do not count, because they are
/// invalid or outside, are marked twice: by a mask each (-1: does not count), and by a bit each in words of
/// 32. Codes and masks are readable up to a tap's distance beyond both ends, which lie on whole words; there,
/// codes mean nothing and masks are -1. words_beyond words are readable there, too, and are not 0.
struct TerraceRow {
    const std::int16_t *codes, *masks;
    const std::uint32_t* holes;
    const std::int16_t* gates;  ///< for this pass, by the codes before all passes; unused if all are equal
};
/// Words of holes on either side of a row, for taps up to this distance.
constexpr int words_beyond(int tap) {
    return (tap + 31) / 32;
}

/// One pass over a row of `words` times 32 pixels: `above` and `below` are `step` rows away. Fills all of
/// `out`; codes that do not count mean nothing. The last pass doubles codes, to unsigned 16 bits.
struct TerracePass {
    int step;
    const TerraceFilter& filter;
    bool is_last;
};
/// Removes the terraces of quantised depth (docs/conventions.md). The passes go down a band of rows together,
/// each as far behind the one before it as its taps reach, so that a row is still in the cache when it is
/// read.
class TerraceRemover final : public BandSource {
public:
    TerraceRemover(std::unique_ptr<BandSource> before, const TerraceFilter& filter, VectorUnit unit)
        : before_(std::move(before)),
          filter_(filter),
          unit_(unit),
          known_rows_(filter.reach + 2),
          margin_(filter.tap_of(0)) {}
    void begin(const RawFrame& raw, RowBands& bands) override;
    /// Writes finer codes, 0 for invalid ones, and validity.
    void make(const RowBand& band, SurfaceFrame& out) override;
    void remember(const RawFrame& raw, RowBands& bands, SurfaceFrame& scratch) override {
        before_->remember(raw, bands, scratch);
    }

private:
    /// The last rows that a pass reads: row y in slot y % count.
    struct Ring {
        int count = 0;
        std::vector<std::int16_t> codes;
    };
    /// Working memory of a thread.
    struct Work {
        Ring rings[most_terrace_passes + 1];  // before each pass, and after the last
        // For every row that any pass still reads; the last row is one outside the picture.
        std::vector<std::int16_t> masks;
        std::vector<std::uint32_t> holes;
        std::vector<std::int16_t> gates, most;  // of those rows; empty if all levels are equal
    };

    void resize(int width, int threads);
    void load(int y, Work& work) const;
    void store(int y, Work& work, SurfaceFrame& out) const;
    /// Row y before a pass; no pixel counts in a row outside the picture.
    TerraceRow row(const Work& work, int pass, int y) const;
    /// Words of holes of a row, including those beyond its ends.
    std::ptrdiff_t hole_words() const { return words_ + 2 * words_beyond(filter_.tap_of(0)); }
    std::int16_t* codes(Work& work, int pass, int y) const;
    std::ptrdiff_t gates_at(int y) const;

    const std::unique_ptr<BandSource> before_;
    const TerraceFilter filter_;
    const VectorUnit unit_;
    /// Rows whose masks and holes are kept: the last pass is filter_.reach behind the loaded row, and also
    /// reads the row before its own.
    const int known_rows_;
    const int margin_;  // distance of a tap beyond a row's ends
    SurfaceFrame with_terraces_;
    int words_ = 0;
    std::ptrdiff_t pitch_ = 0;
    std::vector<Work> work_;  // one per thread
};

/// Side of the blocks from which terraces are removed at a time. The surroundings of a block cost as much as
/// its own pixels, so blocks grow with the reach. At half of it the few pixels below a finger, which lie in
/// one or two blocks each way, cost the least.
constexpr int terrace_block(int reach) {
    return std::max(least_terrace_reach, reach / 2);
}

/// Terrace removal of a block of pixels, with all the pixels on which it depends, on the stack. `reach`: the
/// filter's; with the largest a patch takes 1.6 MB.
template <int reach>
class TerracePatch {
public:
    static constexpr int block = terrace_block(reach);

    /// Block (bx, by) of a picture; coordinates of its pixels and of the patch's are the picture's.
    TerracePatch(int width, int height, int bx, int by);
    int left() const { return left_; }
    int right() const { return right_; }  ///< the last column of the patch
    int top() const { return top_; }
    int bottom() const { return bottom_; }

    /// To be called for every valid pixel of the patch, with its code by the scene's coding.
    void set(int x, int y, std::uint16_t code, const TerraceFilter& filter);
    void level(const TerraceFilter& filter);
    bool is_set(int x, int y) const { return masks_[y - top_][margin + x - left_] == 0; }
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
