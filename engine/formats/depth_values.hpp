// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>

#include "engine/base/result.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/value_evidence.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The largest of many values, of which one in 10 000 may be stray (FarPlaneEstimator's rule, for values that
/// are not codes yet). Keeps as many values as may be stray in all telling frames.
class FarthestValues {
public:
    /// Call before adding a picture's values, at most `pixels` of them.
    void begin_picture(std::size_t pixels) {
        most_kept_ = std::max(most_kept_, std::size_t{first_frames + spread_frames} * pixels / stray_of + 1);
    }
    void add(float value) {
        ++count_;
        if (kept_.size() >= most_kept_ && value <= least_kept_) return;
        kept_.push_back(value);
        if (kept_.size() < 2 * most_kept_) return;
        const auto last = kept_.begin() + static_cast<std::ptrdiff_t>(most_kept_) - 1;
        std::nth_element(kept_.begin(), last, kept_.end(), std::greater<>());
        least_kept_ = *last;
        kept_.resize(most_kept_);
    }
    /// The value that at most one in 10 000 exceeds. Needs at least one value.
    double without_strays() {
        const auto at = kept_.begin() + static_cast<std::ptrdiff_t>(count_ / stray_of);
        std::nth_element(kept_.begin(), at, kept_.end(), std::greater<>());
        return *at;
    }
    /// Share of the values above `bound`, which must not be below `without_strays`.
    double share_beyond(double bound) const {
        const auto beyond =
            std::count_if(kept_.begin(), kept_.end(), [&](float value) { return value > bound; });
        return static_cast<double>(beyond) / static_cast<double>(count_);
    }

private:
    static constexpr std::size_t stray_of = 10'000;
    std::vector<float> kept_;
    float least_kept_ = 0;  // valid once `most_kept_` are kept
    std::size_t most_kept_ = 1, count_ = 0;
};

/// Turns depth pictures that are not codes into codes: floats, disparities, depth without a scale, words in
/// another order of bits. Some frames are looked at first (telling_frames) and settle the scene's coding;
/// then all are converted. Values nearer than all that were seen go to the near plane; farther ones are no
/// depth, or go to the far plane if depth has no scale.
///
/// Integers and evenly spaced floats (FloatLattice) keep every value: disparities and depth without a scale
/// become evenly spaced codes of 1 / depth, or of depth; lengths that are multiples of a unit get the codes
/// that a picture of integers would have. A float between two codes, in a frame that was not looked at, is
/// rounded to the nearest. Other floats become 65535 codes, evenly in depth or in 1 / depth, whichever is
/// finer at the median. A far plane that is not stated is 5 % beyond the depth that one pixel in 10 000
/// exceeds. If near and far plane of lengths are both stated, codes go from plane to plane, whatever the
/// frames hold. A renderer's background (RendererBackground) is no depth; lengths may be negated. If the
/// thread is asked to stop, a visit to all pixels ends early; callers check that.
class DepthValues {
public:
    /// Until `settle`, the described coding applies.
    explicit DepthValues(const SceneDescription& described);

    /// Whether pictures like this one have to be looked at before codes are made.
    bool needs_looks(const StoredImage& first) const {
        return !first.values.empty() || stored_.kind != StoredDepth::Kind::codes;
    }
    /// Takes one more picture into account.
    void look(const StoredImage& picture);
    /// Settles `scene`'s coding; returns in words what a code stands for. An error if no value was valid.
    Result<std::string> settle(Scene& scene);
    /// Whether the far plane is still to be found in the codes.
    bool leaves_far_open() const { return far_is_open_ && !is_settled_; }
    /// Whether pictures need converting to codes.
    bool makes_codes() const { return is_settled_ || stored_.is_reordered(); }
    /// The picture's codes in the settled scene; 16 bits if it converts them.
    Image codes(StoredImage picture) const;

private:
    bool is_valid(double value) const;
    /// The number that a stored word stands for.
    double ordered(std::uint16_t word) const {
        unsigned value = word;
        if (stored_.bytes_swapped) value = (value << 8 | value >> 8) & 0xffffU;
        if (stored_.rotated > 0)
            value = (value >> stored_.rotated | value << (16 - stored_.rotated)) & 0xffffU;
        return value & ((1U << stored_.used_bits) - 1);
    }
    template <class Begin, class Work>
    void for_each(const StoredImage& picture, Begin&& begin, Work&& work) const;
    double median();
    std::string background_words() const;
    std::string find_far(Scene& scene, double step);
    std::string settle_lengths(Scene& scene);
    std::string settle_multiples(Scene& scene, const FloatLattice& lattice);
    std::optional<std::string> settle_steps(Scene& scene, const FloatLattice& lattice);
    std::string settle_floats(Scene& scene, double median, double deepest);
    std::optional<FloatLattice> even_steps();
    Result<std::string> settle_line(Scene& scene, double far, double near, bool near_is_high,
                                    const std::optional<FloatLattice>& even);

    StoredDepth stored_;
    DepthCoding coding_;  // as described
    bool far_is_open_;    // in the description
    bool has_planes_;     // lengths with both planes stated
    bool is_float_ = false, is_negated_ = false;
    double least_ = 0, most_ = -1;  // valid values
    std::vector<float> sample_;     // some of them, for their median
    LatticeSearch lattice_;
    FarthestValues farthest_;
    std::int64_t pixels_ = 0;  // valid ones
    std::int64_t looked_at_ = 0, backgrounds_ = 0;

    // Code = (value or its reciprocal - first) * per_value, rounded for floats.
    bool is_settled_ = false, of_reciprocal_ = false, is_high_near_ = true;
    double lower_ = 0, upper_ = std::numeric_limits<double>::max();  // of lengths
    double first_ = 0, per_value_ = 1;
    std::uint16_t code_max_ = 65534;  // larger ones are not valid
    std::uint16_t none_ = 65535;      // the code for no depth
};

}  // namespace touchable
