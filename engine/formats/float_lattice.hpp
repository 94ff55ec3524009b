#pragma once

#include <optional>
#include <span>
#include <vector>

namespace touchable {

/// Evenly spaced numbers that floats came from: first + k step, with whole k from 0 on. Of depths, or of
/// their reciprocals (disparity).
struct FloatLattice {
    double first = 0;  ///< 0 <= first < step; 0: whole multiples of the step
    double step = 0;
    bool of_reciprocals = false;
    bool is_rounded = false;  ///< the floats have 11 bits (halves) and are the nearest to its numbers
    double off = 0;           ///< share of the floats that lie between its numbers
};

/// Finds the lattice of floats by a sample of them. It is told from chance: at least 8 of its numbers occur,
/// all but one float in a hundred lie on it, within what rounding to 32 bits (or 11, is_rounded) does to
/// them, where those of no lattice would do so once in 32 times at most. Its span is at most `most_codes`
/// steps, which 1 float in 1000 may exceed. What is coarser than 1/25 of the median (of reciprocals 1/4) is
/// none: floats of a few flat things are no sensor's. The same floats in any order give the same lattice.
class LatticeSearch {
public:
    static constexpr int most_codes = 65534;

    /// One float; finite.
    void add(float value) { sample_.push_back(value); }
    /// Lengths: `metres` is of a stored 1. Multiples of a millimetre are taken as those, whatever larger
    /// unit they share. Depths first, then reciprocals.
    std::optional<FloatLattice> of_lengths(double metres);
    /// Numbers without a unit: even steps, wherever they begin.
    std::optional<FloatLattice> of_numbers();

private:
    std::vector<float> sample_;
};

}  // namespace touchable
