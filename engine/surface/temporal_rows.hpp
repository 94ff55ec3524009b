#pragma once

#include <cstdint>

#include "engine/base/vector_unit.hpp"
#include "engine/scene/temporal.hpp"

namespace touchable {

/// What is remembered of a row: finer codes, whole words of 32 of them, and a bit for each in words: whether
/// there is one, and for how many frames it has only been held (low and high bit).
struct TemporalRow {
    std::uint16_t* codes;
    std::uint32_t *known, *held_low, *held_high;
};

/// One row of a frame, `width` codes and their validity: codes as many times finer, smoothed, 0 where
/// invalid. The row that is remembered becomes the same.
void smooth_row(VectorUnit unit, const TemporalFilter& filter, int width, std::uint16_t* codes,
                std::uint32_t* validity, const TemporalRow& remembered);

}  // namespace touchable
