// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/depth_values.hpp"

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::uint16_t no_depth = 65535;  // beyond every code_max here, except for multiples of a unit
constexpr double far_margin = 1.05;        // far plane over the farthest depth

constexpr double most_beyond = 1e5, most_before = 1e3;  // times the median
constexpr double most_range = 9e5;                      // far over near; a scene may have a million
constexpr double rounding = 1e-6;                       // relative; a float may lie so much beyond its plane

/// One pixel in so many tells the median as well as all.
constexpr std::int64_t sample_step = 97;
constexpr std::size_t most_samples = 100'000;
/// Number of evenly spread pixels of a picture that tell the lattice that floats came from.
constexpr std::size_t lattice_samples = 8192;

std::string range_words(double least, double most) {
    return short_number(least) + " to " + short_number(most);
}

/// Says which of the floats that were looked at are kept, and how; `what`: what they are.
std::string kept_words(const FloatLattice& lattice, const std::string& what) {
    if (lattice.is_rounded)
        return "depth is floats of 11 bits (halves), " + what +
               " but for rounding: kept as those (where halves are farther apart than that, one stands for "
               "several)";
    if (lattice.off == 0) return "depth is floats that are " + what + ": kept exactly";
    return "depth is floats, of which all but " + short_number(100 * lattice.off, 2) + " % are " + what +
           ": these are kept exactly, others are rounded to the nearest of them";
}

/// Removes a product's rounding error: returns the nearest number of seven decimals if it is that near.
double without_rounding(double number) {
    const double plain = std::floor(number * 1e7 + 0.5) / 1e7;
    return std::abs(plain - number) <= 1e-14 * number ? plain : number;
}

/// The nearest of the even steps, if there are any; otherwise the value.
double on_step(double value, const std::optional<FloatLattice>& even) {
    return even ? even->first + std::floor((value - even->first) / even->step + 0.5) * even->step : value;
}

/// A value in words; whole ones, as in pictures of integers, with all their digits.
std::string value_words(double value) {
    const bool is_whole = value == std::floor(value) && std::abs(value) < 1e6;
    return is_whole ? std::to_string(static_cast<std::int64_t>(value)) : short_number(value);
}

}  // namespace

DepthValues::DepthValues(const SceneDescription& described)
    : stored_(described.scene.stored),
      coding_(described.scene.depth),
      far_is_open_(described.unstated.far),
      has_planes_(stored_.kind == StoredDepth::Kind::codes && coding_.kind == DepthCodingKind::metric &&
                  coding_.near > 0 && !far_is_open_) {
    if (coding_.kind != DepthCodingKind::metric) return;
    lower_ = coding_.near / coding_.scale * (1 - rounding);
    if (has_planes_) upper_ = coding_.far / coding_.scale * (1 + rounding);
}

bool DepthValues::is_valid(double value) const {
    if (!std::isfinite(value) || value >= packed_none(stored_.packed)) return false;
    for (int k = 0; k < coding_.invalid_code_count; ++k)
        if (value == coding_.invalid_codes[static_cast<std::size_t>(k)]) return false;
    if (stored_.kind == StoredDepth::Kind::disparity) return stored_.scale * value + stored_.offset > 0;
    // Where 0 is no depth, as infinitely far, what is less is none either.
    if (stored_.kind == StoredDepth::Kind::relative)
        return coding_.invalid_code_count == 0 || coding_.invalid_codes[0] > 0 || value > 0;
    if (coding_.kind != DepthCodingKind::metric) return value >= 0 && value <= 1;
    return value >= lower_ && value <= upper_ && value > 0;
}

/// Calls `work(k, value)` for all pixels, and `begin(first, last)` before each piece of them.
template <class Begin, class Work>
void DepthValues::for_each(const StoredImage& picture, Begin&& begin, Work&& work) const {
    const RendererBackground background(picture);
    until_stopped(pixel_count(picture.image), [&](std::size_t first, std::size_t last) {
        begin(first, last);
        for (std::size_t k = first; k < last; ++k) {
            if (picture.values.empty()) {
                work(k, ordered(sample_at(picture.image, k)));
                continue;
            }
            const double value = is_negated_ ? -picture.values[k] : picture.values[k];
            work(k, background.is(value) ? std::numeric_limits<double>::infinity() : value);
        }
    });
}

void DepthValues::look(const StoredImage& picture) {
    is_float_ = !picture.values.empty();
    is_negated_ |= pixels_ == 0 && coding_.kind == DepthCodingKind::metric && are_negated(picture);
    const std::size_t every = picture.values.size() / lattice_samples + 1;
    farthest_.begin_picture(picture.values.size());
    const auto nothing = [](std::size_t, std::size_t) {};
    for_each(picture, nothing, [&](std::size_t k, double value) {
        ++looked_at_;
        backgrounds_ += std::isinf(value);
        if (!is_valid(value)) return;
        least_ = most_ < least_ ? value : std::min(least_, value);
        most_ = std::max(most_, value);
        if (pixels_++ % sample_step == 0 && sample_.size() < most_samples)
            sample_.push_back(static_cast<float>(value));
        if (!is_float_) return;
        farthest_.add(static_cast<float>(value));
        // Scattered: even steps hit only every third or fifth number of a leaning plane.
        if ((k * 0x9e3779b97f4a7c15U >> 32U) % every == 0) lattice_.add(static_cast<float>(value));
    });
}

/// The median depth looked at; if there is none, a depth that favours neither plane.
double DepthValues::median() {
    if (sample_.empty()) return std::sqrt(coding_.near * coding_.far);
    return coding_.scale * sorted_element(sample_, sample_.size() / 2);
}

std::string DepthValues::background_words() const {
    if (backgrounds_ == 0) return "";
    const double share = 100.0 * static_cast<double>(backgrounds_) / static_cast<double>(looked_at_);
    return "; " + short_number(share) +
           " % of the pixels are background (infinity, 1e9 and beyond, 65504, or a round number far beyond "
           "all others): no depth";
}

/// Sets a far plane that is not stated, for multiples of `step` (0: for any lengths); returns a note.
std::string DepthValues::find_far(Scene& scene, double step) {
    if (!far_is_open_ || sample_.empty()) return "";
    const double deepest = farthest_.without_strays(), scale = coding_.scale;
    scene.depth.far =
        (step > 0 ? scene.depth.scale * std::floor(deepest / step + 0.5) : scale * deepest) * far_margin;
    const double lost = farthest_.share_beyond(scene.depth.far / scale);
    return lost > 0 ? "; " + short_number(100 * lost, 2) + " % of the pixels lie beyond the far plane, " +
                          short_number(scene.depth.far) + ", and count as holes"
                    : "";
}

/// Floats that are whole multiples of a unit get the codes of a picture of integers.
std::string DepthValues::settle_multiples(Scene& scene, const FloatLattice& lattice) {
    DepthCoding& depth = scene.depth;
    none_ = 0;
    code_max_ = std::numeric_limits<std::uint16_t>::max();
    per_value_ = 1 / lattice.step;
    depth.scale = without_rounding(depth.scale * lattice.step);
    const std::string lost = find_far(scene, lattice.step);
    return kept_words(lattice,
                      "whole multiples of " + short_number(depth.scale * scene.metres_per_unit, 6) + " m") +
           lost;
}

/// Settles even steps of depth or of 1/depth. The planes, which are set, move inward to such steps. Nothing:
/// there are too many steps.
std::optional<std::string> DepthValues::settle_steps(Scene& scene, const FloatLattice& lattice) {
    DepthCoding& depth = scene.depth;
    of_reciprocal_ = lattice.of_reciprocals;
    const double scale = depth.scale, in_a_step = 1e-3;
    const double from = of_reciprocal_ ? scale / depth.far : depth.near / scale,
                 to = of_reciprocal_ ? scale / depth.near : depth.far / scale;
    const double least = std::ceil((from - lattice.first) / lattice.step - in_a_step),
                 most = std::floor((to - lattice.first) / lattice.step + in_a_step);
    first_ = lattice.first + least * lattice.step;
    const double last = lattice.first + most * lattice.step;
    if (!(most > least) || most - least > code_max_ || !(first_ > 0)) return std::nullopt;
    code_max_ = static_cast<std::uint16_t>(most - least);
    per_value_ = 1 / lattice.step;
    depth.kind = of_reciprocal_ ? DepthCodingKind::inverse : DepthCodingKind::linear;
    depth.near_is_high = of_reciprocal_;
    depth.near = of_reciprocal_ ? scale / last : scale * first_;
    depth.far = of_reciprocal_ ? scale / first_ : scale * last;
    const std::string many = std::to_string(code_max_ + 1) + " even steps of ";
    return kept_words(lattice, many + (of_reciprocal_ ? "1/depth (disparities) from " : "depth from ") +
                                   range_words(depth.near, depth.far));
}

/// Settles floats that are depths themselves.
std::string DepthValues::settle_lengths(Scene& scene) {
    DepthCoding& depth = scene.depth;
    const auto lattice = lattice_.of_lengths(depth.scale * scene.metres_per_unit);
    const bool are_multiples = lattice && lattice->first == 0 && !lattice->of_reciprocals;
    if (are_multiples && (!has_planes_ || depth.far <= depth.scale * lattice->step * no_depth))
        return settle_multiples(scene, *lattice);
    const double median = this->median();
    double deepest = depth.far;
    std::string lost;
    if (!has_planes_) {
        lost = find_far(scene, 0);
        // Values that much farther or nearer than most stand for something else.
        deepest = std::min(far_is_open_ ? depth.far / far_margin : depth.scale * most_, median * most_beyond);
        const double nearest = std::max(median / most_before, deepest / most_range);
        if (far_is_open_ || depth.far > deepest * far_margin) depth.far = deepest * far_margin;
        depth.near = std::max(depth.scale * least_, nearest);
        lower_ = std::max(lower_, nearest / depth.scale * (1 - rounding));
        upper_ = depth.far / depth.scale;
    }
    if (lattice && !are_multiples)
        if (auto said = settle_steps(scene, *lattice)) return *said + lost;
    return settle_floats(scene, median, deepest) + lost;
}

/// Settles codes from plane to plane, evenly in depth or 1/depth, whichever is finer at the median.
std::string DepthValues::settle_floats(Scene& scene, double median, double deepest) {
    DepthCoding& depth = scene.depth;
    const double near = depth.near, far = depth.far;
    of_reciprocal_ = median * median * (1 / near - 1 / far) < far - near;
    depth.kind = of_reciprocal_ ? DepthCodingKind::inverse : DepthCodingKind::linear;
    depth.near_is_high = of_reciprocal_;
    const double from = of_reciprocal_ ? depth.scale / far : near / depth.scale,
                 to = of_reciprocal_ ? depth.scale / near : far / depth.scale;
    first_ = from;
    per_value_ = code_max_ / (to - from);
    const double half_code =
        0.5 * (of_reciprocal_ ? median * median * (1 / near - 1 / far) : far - near) / code_max_;
    return "depth is " + range_words(near, deepest) + " as floats, kept as " + std::to_string(code_max_ + 1) +
           " codes evenly in " + (of_reciprocal_ ? "1/depth" : "depth") + ": half a code is " +
           short_number(half_code) + " at " + short_number(median) +
           (sample_.empty() ? " (of what was looked at nothing is between near and far)" : ", the median");
}

/// The values' even steps: 1 for integers, any or none for floats.
std::optional<FloatLattice> DepthValues::even_steps() {
    if (!is_float_) return FloatLattice{0, 1};
    auto lattice = lattice_.of_numbers();
    // Disparities need codes up to a far plane beyond the deepest.
    if (lattice && far_margin * (most_ - least_) / lattice->step > 0.9 * code_max_) lattice.reset();
    return lattice;
}

/// Settles values that are linear in 1 / depth (or depth); `far` and `near`: the values at the planes.
Result<std::string> DepthValues::settle_line(Scene& scene, double far, double near, bool near_is_high,
                                             const std::optional<FloatLattice>& even) {
    DepthCoding& depth = scene.depth;
    depth.near_is_high = near_is_high;
    first_ = std::min(far, near);
    const double range = std::abs(near - far);
    // Without a scale all values are depths: no code has to be left for no depth.
    if (!is_float_ && range > code_max_ && stored_.kind == StoredDepth::Kind::relative) code_max_ = no_depth;
    if (!is_float_ && range > code_max_)
        return input_error("depth has values from " + range_words(first_, first_ + range) +
                           ": of 65536, one has to be free");
    if (even) code_max_ = static_cast<std::uint16_t>(std::max(std::floor(range / even->step + 0.5), 1.0));
    per_value_ = even ? 1 / even->step : code_max_ / range;
    return (even && is_float_ ? kept_words(*even, "even steps of " + short_number(even->step, 6)) + "; "
                              : "") +
           "depth values from " + value_words(least_) + " to " + value_words(most_) + " are depths from " +
           (near_is_high ? range_words(depth.far, depth.near) : range_words(depth.near, depth.far));
}

Result<std::string> DepthValues::settle(Scene& scene) {
    // If both planes are stated, later frames may still have depth.
    if (most_ < least_ && !has_planes_) return input_error("no frame has a valid depth" + background_words());
    if (most_ == least_)
        most_ = std::nextafter(most_ * (1 + 1e-6) + 1e-6, std::numeric_limits<double>::max());
    Result<std::string> said = std::string();
    DepthCoding& depth = scene.depth;
    using Kind = StoredDepth::Kind;
    if (stored_.kind == Kind::disparity) {
        const double per_disparity = scene.camera.fx * stored_.baseline;
        const auto disparity = [&](double value) { return stored_.scale * value + stored_.offset; };
        const auto even = even_steps();
        const double at_near = on_step(stored_.scale > 0 ? most_ : least_, even);
        double at_far =
            (disparity(stored_.scale > 0 ? least_ : most_) / far_margin - stored_.offset) / stored_.scale;
        if (even) {
            const double steps = (at_far - even->first) / even->step;
            at_far = even->first + even->step * (stored_.scale > 0 ? std::floor(steps) : std::ceil(steps));
            // If the offset is far above all disparities, a far plane behind them would need too many codes.
            const double most_apart = even->step * code_max_;
            if (is_float_) at_far = std::clamp(at_far, at_near - most_apart, at_near + most_apart);
        }
        if (!is_float_) at_far = std::max(0.0, at_far);
        if (!(disparity(at_far) > 0)) at_far = stored_.scale > 0 ? least_ : most_;
        depth.kind = DepthCodingKind::inverse;
        depth.near = per_disparity / disparity(at_near);
        depth.far = per_disparity / disparity(at_far);
        said = settle_line(scene, at_far, at_near, stored_.scale > 0, even);
    } else if (stored_.kind == Kind::relative) {
        const auto even = even_steps();
        const double least = on_step(least_, even), most = on_step(most_, even);
        said = settle_line(scene, depth.near_is_high ? least : most, depth.near_is_high ? most : least,
                           depth.near_is_high, even);
    } else if (depth.kind == DepthCodingKind::metric) {
        said = settle_lengths(scene);
    } else {  // shares of the largest code
        first_ = 0;
        per_value_ = code_max_;
        said = std::string("depth is shares of the largest code, kept as 65535 codes");
    }
    if (!said) return said;
    *said += background_words();
    depth.code_max = code_max_;
    const bool are_multiples = depth.kind == DepthCodingKind::metric;
    if (!are_multiples) {
        depth.invalid_code_count = 0;
        depth.scale = 0;
    }
    is_high_near_ = depth.near_is_high && !are_multiples;
    scene.depth_bits = 16;
    scene.stored = {};
    derive_valid_range(depth);
    is_settled_ = true;
    TRY(validate(scene));
    return said;
}

Image DepthValues::codes(StoredImage picture) const {
    if (!makes_codes()) return std::move(picture.image);
    Image codes{picture.image.width, picture.image.height, 2, 1, {}};
    const std::size_t pixels = pixel_count(codes);
    codes.samples.reserve(2 * pixels);  // memory is taken as it is filled
    const bool is_float = !picture.values.empty();
    const bool keeps_far = stored_.kind == StoredDepth::Kind::relative;  // values beyond go to the far plane
    std::size_t done = 0;
    const auto begin = [&](std::size_t first, std::size_t last) {
        if (is_float) give_back(picture.values.data() + done, (first - done) * sizeof(float));
        done = first;
        codes.samples.resize(2 * last);
    };
    for_each(picture, begin, [&](std::size_t k, double value) {
        std::uint16_t code = none_;
        if (!is_settled_) {
            code = static_cast<std::uint16_t>(value);
        } else if (is_valid(value)) {
            const double place = ((of_reciprocal_ ? 1 / value : value) - first_) * per_value_;
            const bool is_far = is_high_near_ ? place <= -0.5 : place >= code_max_ + 0.5;
            if (!is_far || keeps_far)
                code =
                    static_cast<std::uint16_t>(std::clamp(place, 0.0, static_cast<double>(code_max_)) + 0.5);
        }
        std::memcpy(codes.samples.data() + 2 * k, &code, 2);
    });
    if (codes.samples.size() < 2 * pixels) return {1, 1, 2, 1, {0, 0}};  // stopped: it is not used
    return codes;
}

}  // namespace touchable
