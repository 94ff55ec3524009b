#pragma once

#include <cstdint>

#include "engine/base/vector_unit.hpp"
#include "engine/scene/terraces.hpp"

namespace touchable {

/// A row of working codes, for one pass of terrace removal. Which pixels do not count, because they are
/// invalid or outside, is said twice: as a mask for each (-1: does not count), and as a bit for each in words
/// of 32. Codes and masks may be read as far as a tap is beyond both ends, which lie on whole words, where
/// codes mean nothing and masks are -1; words_beyond words there may be read too, and are not 0.
struct TerraceRow {
    const std::int16_t *codes, *masks;
    const std::uint32_t* holes;
    const std::int16_t* gates;  ///< of the codes before all passes, in this one; unused where all are alike
};
/// Words of holes to either side of a row for taps up to so far away.
constexpr int words_beyond(int tap) {
    return (tap + 31) / 32;
}

/// TerraceFilter::gate_at and most_at of each of `words` times 32 working codes.
void find_gates(VectorUnit unit, const TerraceFilter& filter, const std::int16_t* codes, int words,
                std::int16_t* gates, std::int16_t* most);

/// One pass over a row of `words` times 32 pixels: `above` and `below` are `step` rows away. Fills all of
/// `out`; codes that do not count mean nothing. The last pass doubles codes, to 16 bits without a sign.
struct TerracePass {
    int step;
    const TerraceFilter& filter;
    bool is_last;
};
void level_row(VectorUnit unit, const TerraceRow& above, const TerraceRow& here, const TerraceRow& below,
               int words, const TerracePass& pass, std::int16_t* out);

}  // namespace touchable
