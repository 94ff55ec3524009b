#pragma once

// What the numbers of a depth picture tell of how they were stored: their unit, bits in another order, a
// renderer's background, the even steps that floats came from. What goes over all pixels is unfinished where
// the thread is asked to stop meanwhile; callers check stop_requested.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// Sample `k` of a picture of one channel, of 8 bits, or of 16 in host order.
inline std::uint16_t sample_at(const Image& image, std::size_t k) {
    if (image.bytes_per_sample == 1) return image.samples[k];
    std::uint16_t word = 0;
    std::memcpy(&word, image.samples.data() + 2 * k, 2);
    return word;
}

inline std::size_t pixel_count(const Image& image) {
    return static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

/// The largest number to 1000 of which all values of 16 bits are multiples; 1: they have none, or are no
/// evidence. 0 and 65535 say nothing, one pixel in a thousand may differ, and fewer than 20 values that
/// differ are no evidence.
int common_divisor(const StoredImage& picture);

/// Depth of 24 bits in an RGB picture of 8 bits (StoredDepth::packed): red has the lowest bits. Its largest
/// value is no depth.
inline constexpr double packed_none = 0xffffff;
/// Whether an RGB picture looks like that. Where blue differs by 1 between neighbours, a byte that ran over
/// has green jump back by nearly all of its range; no photograph and no colour map does so. Depth that stays
/// within one step of blue (4 m of 1 km) shows nothing.
bool looks_packed(const Image& image);
/// Makes floats of such a picture, exact whole numbers. False, and unchanged, if it is not RGB of 8 bits, or
/// the thread is asked to stop.
bool unpack_depth(StoredImage& picture);
/// Whether a picture's floats came from `unpack_depth`.
inline bool is_unpacked(const StoredImage& picture) {
    return !picture.values.empty() && picture.pixel_format == "rgb24";
}

/// The preset that the values of 16 bits show: a Kinect's raw disparities (kinect-raw; nyu with bytes
/// swapped), bits rotated by 3 (sun), a player's number in the 3 lowest bits (kinect-sdk1), a confidence in
/// the 3 highest (depth16). Of floats: depth of 24 bits (carla). Null: no evidence of any, as in
/// `common_divisor`.
struct EvidentPreset {
    const SourceDescription::Preset* preset = nullptr;
    std::string why{};  ///< "its values ...", in words
};
EvidentPreset evident_preset(const StoredImage& picture);

/// Of 16 bits the largest code but 65535, where it stands for no depth: all its bits are set (4095, 8191) or
/// it is round (10000), more than one pixel in 200 has it, and no other comes near it.
std::optional<std::uint16_t> none_above_all(const StoredImage& picture);

/// What renderers write into pictures of floats where they see nothing, in whatever unit: infinity, 1e9 and
/// beyond (Blender: 1e10), and the largest number of 16 bits, 65504, which is what files of halves have in
/// their place. Halves become floats of 32 bits in other programs. So 65504 is background in any picture of
/// floats, but not where that has a depth farther than it. Of either sign. Codes have no background.
class RendererBackground {
public:
    explicit RendererBackground(const StoredImage& picture);
    /// Whether a value of the picture stands for no surface. (NaN is no value.)
    bool is(double value) const {
        const double size = std::abs(value);
        return size >= double{endless} || (has_largest_half_ && size == double{largest_half});
    }

private:
    static constexpr float endless = 1e9F, largest_half = 65504;
    bool has_largest_half_ = false;
};

/// What the values of a picture tell of their unit.
struct EstimatedValues {
    bool is_float = false;
    bool has_background = false;  ///< a renderer's (RendererBackground)
    bool any = false;  ///< is neither 0, background nor, of 16 bits, the largest; what follows is of these
    int bits = 16;
    double median = 0;
    double upper = 0, lower = 0;  ///< means of the upper and the lower third of the picture
    double negative = 0;          ///< share of all; 0 where all of them are one number, which is none then
    bool has_negative_none = false;
    double zeros = 0, largest = 0;  ///< share of 0, and of integers of 16 bits of 65535
    bool is_normalised = false;     ///< from the least that can be stored (floats: 0) to the most (1)
    int divisor = 1;                ///< of integers of 16 bits (common_divisor)
    /// Of 8 bits that were stretched to 16.
    bool is_of_bytes() const { return divisor == 256 || divisor == 257; }
};
EstimatedValues estimate_values(const StoredImage& picture);

/// Evenly spaced numbers that floats came from: first + k step, with whole k from 0 on. Of depths, or of
/// their reciprocals (disparity).
struct FloatLattice {
    double first = 0;  ///< 0 <= first < step; 0: whole multiples of the step
    double step = 0;
    bool of_reciprocals = false;
    bool is_rounded = false;  ///< the floats have 11 bits (halves) and are the nearest to its numbers
    double off = 0;           ///< share of the floats that lie between its numbers
};

/// Finds the lattice of floats by a sample of them. Chance is ruled out: at least 8 of its numbers occur,
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
