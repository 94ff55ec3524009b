// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds out from a depth picture's numbers how they were stored: their unit, bits in another order, a
// renderer's background, the even steps that floats came from. Functions that visit all pixels end early,
// with an incomplete result, if the thread is asked to stop; callers check stop_requested.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// Whether packed numbers are shares of a far plane that is not known.
inline bool is_of_shares(Packing packing) {
    return packing == Packing::bgr24 || packing == Packing::bgr255;
}
/// Whether a picture is of 16 bits.
inline bool holds_words(const StoredImage& picture) {
    return picture.values.empty() && picture.image.bytes_per_sample == 2 && picture.bits == 16;
}
/// The least number that is no depth.
inline double packed_none(Packing packing) {
    return packing == Packing::rgb24 ? 0xffffff
           : is_of_shares(packing)   ? 1
                                     : std::numeric_limits<double>::infinity();
}
/// How a picture in colour is packed, by its bytes: if the highest one that changes differs by 1 between
/// neighbours, the carry makes the next one jump back by nearly its whole range, which no photograph and no
/// colour map does. Depth within one step of that byte (4 m of CARLA's 1 km) gives no evidence. `is_likely`:
/// few such places are enough.
Packing packing_of(const StoredImage& picture, bool is_likely = false);
/// Turns a packed picture into floats, or words of 16 bits. False, and nothing is changed, if it is not RGB
/// of 8 bits (with alpha for floats) or the thread is asked to stop.
bool unpack_depth(StoredImage& picture, Packing packing);

/// The number whose bits, as a half (16-bit float), these are.
double half_value(double word);

/// The preset that 16-bit values show: a Kinect's raw disparities (kinect-raw; nyu with bytes swapped), bits
/// rotated by 3 (sun), a player's number in the 3 lowest bits (kinect-sdk1), a confidence in the 3 highest
/// (depth16). For unpacked pictures their packing. Null: no evidence, as fewer than 20 different values are
/// (0 and 65535 do not count).
struct EvidentPreset {
    const SourceDescription::Preset* preset = nullptr;
    std::string why{};  ///< "its values ...", in words
};
EvidentPreset evident_preset(const StoredImage& picture);

/// The largest 16-bit code below 65535, if it stands for no depth: all its bits are set (4095, 8191) or it is
/// round (10000), more than one pixel in 200 has it, and no other code comes near it.
std::optional<std::uint16_t> none_above_all(const StoredImage& picture);

/// Recognises what renderers write into float pictures for pixels without a surface, in any unit and of
/// either sign: infinity, 1e9 and beyond (Blender: 1e10), and 65504, the largest half (16-bit float), which
/// files of halves have in their place. Other programs turn halves into 32-bit floats, so 65504 is background
/// in any float picture that has no depth farther than it; so are round numbers (10, 100, 1000, 65535 in
/// several units) that more than one pixel in 200 has, far beyond all others. Codes have no background.
class RendererBackground {
public:
    explicit RendererBackground(const StoredImage& picture);
    /// Whether a value of the picture stands for no surface. (NaN is no value.)
    bool is(double value) const {
        const double size = std::abs(value);
        return size >= double{endless} || (farthest_ > 0 && size == double{farthest_});
    }

private:
    static constexpr float endless = 1e9F, largest_half = 65504;
    float farthest_ = 0;  // 0: it is a surface
};

/// Whether all floats lie below 0, and not all are one number: depths along OpenGL's z axis.
bool are_negated(const StoredImage& picture);

/// An empty background, 0 or the largest value, around things of depth without a scale.
struct EmptyBackground {
    double value = 0;
    bool near_is_high = false;  ///< as things' rims are farther than the rest of them
};
/// The background that a fifth of the pixels and most of the picture's border have.
std::optional<EmptyBackground> empty_background(const StoredImage& picture);

/// A reading (PlaneVotes): of 0, NaN.
inline double reciprocal(double value) {
    return value != 0 ? 1 / value : std::numeric_limits<double>::quiet_NaN();
}

/// Counts small squares that are planes by one reading of a picture's values and not by the other. A reading
/// gives 1/depth, or a number affine in it, which is affine in the pixels of a plane: a pinhole projects it
/// so. NaN: no depth. Noise hides both, and counts for neither.
class PlaneVotes {
public:
    using Reading = std::function<double(double value)>;
    PlaneVotes(const StoredImage& picture, const Reading& first, const Reading& second);
    /// Whether the squares tell, and nearly all for this reading.
    bool are_for_first() const { return first_ >= fewest && first_ > most_against * second_; }
    bool are_for_second() const { return second_ >= fewest && second_ > most_against * first_; }

private:
    static constexpr int fewest = 4, most_against = 4;
    int first_ = 0, second_ = 0;
};

/// What the values of a picture tell of their unit.
struct EstimatedValues {
    bool is_float = false;
    bool has_background = false;  ///< a renderer's (RendererBackground)
    bool any = false;  ///< has usable values: not 0, background or (integers) 65535; the rest is of these
    int bits = 16;
    double median = 0;
    double upper = 0, lower = 0;  ///< means of the upper and the lower third of the picture
    double usable = 0;            ///< share of all pixels
    double negative = 0;          ///< the same; 0 if all are one number, which is no depth then
    bool has_negative_none = false;
    double zeros = 0, largest = 0;  ///< shares of the pixels that are 0 and, for 16-bit integers, 65535
    bool is_normalised = false;     ///< uses the whole range that can be stored (floats: 0 to 1)
    bool are_shares = false;        ///< floats from 0 to 1
    /// The largest number up to 1000 of which all 16-bit values are multiples, but 0, 65535 and one pixel in
    /// a thousand; 1: there is none, or no evidence (evident_preset).
    int divisor = 1;
    /// Whether the values are 8 bits stretched to 16.
    bool is_of_bytes() const { return divisor == 256 || divisor == 257; }
};
EstimatedValues estimate_values(const StoredImage& picture);

/// Evenly spaced numbers from which floats were made: first + k step, with whole k from 0 on; depths, or
/// their reciprocals (disparity).
struct FloatLattice {
    double first = 0;  ///< 0 <= first < step; 0: whole multiples of the step
    double step = 0;
    bool of_reciprocals = false;
    bool is_rounded = false;  ///< the floats have 11 bits (halves) and are its numbers rounded
    double off = 0;           ///< share of the floats that lie between its numbers
};

/// Finds the lattice of floats from a sample of them. Chance is ruled out: at least 8 of the lattice's
/// numbers occur, and all but one float in a hundred lie on it to within the rounding to 32 bits (or 11,
/// is_rounded), which a float of no lattice does once in 32 times at most. The lattice spans at most
/// `most_codes` steps, which 1 float in 1000 may exceed. A step above 1/25 of the median (of reciprocals 1/4)
/// does not count: floats of a few flat things are no sensor's. The order of the floats does not matter.
class LatticeSearch {
public:
    static constexpr int most_codes = 65534;

    /// Adds a finite float to the sample.
    void add(float value) { sample_.push_back(value); }
    /// For lengths; `metres`: of a stored 1. Multiples of a millimetre get that step, even if they share a
    /// larger one. Tries depths first, then reciprocals.
    std::optional<FloatLattice> of_lengths(double metres);
    /// For numbers without a unit: even steps, with any first number.
    std::optional<FloatLattice> of_numbers();

private:
    std::vector<float> sample_;
};

}  // namespace touchable
