// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/value_evidence.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <limits>

#include "engine/base/threads.hpp"

namespace touchable {
namespace {

constexpr std::size_t fewest_values = 20;
constexpr int largest_divisor = 1000;
constexpr std::int64_t may_differ = 1000;  // one pixel in so many

struct Words {
    struct Occurring {
        unsigned word;
        std::int64_t pixels;
    };
    std::vector<Occurring> each;
    std::int64_t pixels = 0;

    explicit Words(const StoredImage& picture) {
        if (!picture.values.empty() || picture.image.bytes_per_sample != 2 || picture.image.channels != 1)
            return;
        std::vector<std::int64_t> counts(65536);
        until_stopped(picture.image.samples.size() / 2, [&](std::size_t first, std::size_t last) {
            for (std::size_t k = first; k < last; ++k) ++counts[sample_at(picture.image, k)];
        });
        for (unsigned word = 1; word < 65535; ++word)
            if (counts[word] > 0) {
                each.push_back({word, counts[word]});
                pixels += counts[word];
            }
    }
    /// Number of pixels whose word fulfils `does`.
    template <class Does>
    std::int64_t that(Does&& does) const {
        std::int64_t found = 0;
        for (const Occurring& one : each) found += does(one.word) ? one.pixels : 0;
        return found;
    }
    template <class Does>
    bool nearly_all(Does&& does) const {
        std::int64_t others = 0;
        for (const Occurring& one : each)
            if (!does(one.word) && (others += one.pixels) > pixels / may_differ) return false;
        return true;
    }
    bool tell() const { return each.size() >= fewest_values; }
};

unsigned swapped(unsigned word) {
    return (word << 8 | word >> 8) & 0xffffU;
}

int divisor_of(const Words& words) {
    if (!words.tell()) return 1;
    for (unsigned divisor = largest_divisor; divisor > 1; --divisor)
        if (words.nearly_all([&](unsigned word) { return word % divisor == 0; }))
            return static_cast<int>(divisor);
    return 1;
}

constexpr unsigned kinect_none = 2047;

/// Whether words are a Kinect's disparities: of 11 bits, 2047 is none, and it sees nothing beyond 1092.
template <class Order>
bool is_kinect(const Words& words, Order&& order) {
    const auto is_near = [&](unsigned word) { return order(word) >= 300 && order(word) <= 1092; };
    const auto is_usual = [&](unsigned word) { return is_near(word) || order(word) == kinect_none; };
    return words.nearly_all([&](unsigned word) { return order(word) <= kinect_none; }) &&
           words.that(is_near) > words.pixels / 4 && words.that(is_usual) > words.pixels * 9 / 10;
}

/// Disparities in plain order could be millimetres, except for two things: 2047 is frequent, as a Kinect has
/// a shadow beside near objects, and no word lies between 1092 and 2047.
bool is_plain_kinect(const Words& words) {
    constexpr std::int64_t least_pile = 200;  // one pixel in so many
    const auto same = [](unsigned word) { return word; };
    return is_kinect(words, same) &&
           words.that([](unsigned word) { return word == kinect_none; }) > words.pixels / least_pile &&
           words.nearly_all([](unsigned word) { return word <= 1092 || word == kinect_none; });
}

/// `work(a, b)` for the words of neighbours that both are depth.
template <class Work>
void for_neighbours(const StoredImage& picture, Work&& work) {
    const Image& image = picture.image;
    const auto width = static_cast<std::size_t>(image.width);
    const auto is_depth = [](unsigned word) { return word > 0 && word < 65535; };
    until_stopped(pixel_count(image), [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const unsigned word = sample_at(image, k);
            if (!is_depth(word)) continue;
            const unsigned right = (k + 1) % width != 0 ? sample_at(image, k + 1) : 0U,
                           above = k >= width ? sample_at(image, k - width) : 0U;
            if (is_depth(right)) work(word, right);
            if (is_depth(above)) work(word, above);
        }
    });
}

/// Whether two depths may be on one surface: within 3 %.
bool is_smooth(unsigned a, unsigned b) {
    return a > 0 && b > 0 && 33 * (a > b ? a - b : b - a) <= std::max(a, b);
}

unsigned rotated_millimetres(unsigned word) {
    return word >> 3 | (word & 7U) << 13;
}

/// Kinect for Windows SDK 1: millimetres x 8, with a person's number in the 3 lowest bits. Those bits may
/// instead be depth beyond 8.191 m (`is_rotated`). They are a person's if surfaces go on across their edges,
/// or if there is a 2 or more but no 1, which would be depth from 16.384 m on without any from 8.192 m on.
bool has_player(const StoredImage& picture, const Words& words) {
    constexpr unsigned nearest = 400, deepest = 8000;  // what a Kinect sees
    constexpr std::int64_t fewest_pairs = 16, one_in = 20;
    const auto person = [](unsigned word) { return word & 7U; };
    const auto millimetres = [](unsigned word) { return word >> 3; };
    const std::int64_t persons = words.that([&](unsigned word) { return person(word) > 0; });
    if (100 * persons < words.pixels || 2 * persons > words.pixels) return false;
    if (!words.nearly_all([&](unsigned word) {
            return millimetres(word) >= nearest && millimetres(word) <= deepest && person(word) < 7;
        }))
        return false;
    if (words.that([&](unsigned word) { return person(word) == 1; }) == 0) return true;
    std::int64_t pairs = 0, smooth = 0, smooth_rotated = 0;
    for_neighbours(picture, [&](unsigned a, unsigned b) {
        if (person(a) == person(b)) return;
        ++pairs;
        smooth += is_smooth(millimetres(a), millimetres(b));
        smooth_rotated += is_smooth(rotated_millimetres(a), rotated_millimetres(b));
    });
    return smooth >= fewest_pairs && one_in * smooth >= pairs && smooth > 4 * smooth_rotated;
}

double below_confidence(double word) {
    return reciprocal(static_cast<unsigned>(word) & 0x1fffU);
}

/// Whether one confidence lies above all lengths: flat places are flat without it, and bent with it.
bool has_one_confidence(const StoredImage& picture, const Words& words) {
    constexpr unsigned lengths = 0x1fff;
    const unsigned least = words.each.front().word, most = words.each.back().word;
    if (least <= lengths || (least ^ most) > lengths) return false;
    return PlaneVotes(picture, below_confidence, reciprocal).are_for_first();
}

/// Whether words are the bits of halves, as Mid-Air and CO3D store them.
bool are_halves(const StoredImage& picture) {
    constexpr unsigned least = 0x1000, infinite = 0x7c00;
    const Words words(picture);
    if (!holds_words(picture) || !words.tell() ||
        !words.nearly_all([](unsigned word) { return word >= least && word <= infinite; }))
        return false;
    const auto half = [](double word) { return reciprocal(half_value(word)); };
    return PlaneVotes(picture, half, reciprocal).are_for_first() &&
           !PlaneVotes(picture, half, below_confidence).are_for_second();
}

/// Android's DEPTH16: 13 bits of millimetres, and a confidence in the 3 highest. Where these differ between
/// neighbours, the lengths go on smoothly.
bool has_confidence(const StoredImage& picture, const Words& words) {
    constexpr unsigned lengths = 0x1fff;
    constexpr std::int64_t fewest_pairs = 64, one_in = 1000;
    if (20 * words.that([](unsigned word) { return word > lengths; }) < words.pixels) return false;
    std::int64_t pairs = 0, smooth = 0, smooth_whole = 0;
    for_neighbours(picture, [&](unsigned a, unsigned b) {
        if (((a ^ b) & ~lengths) == 0) return;
        ++pairs;
        smooth += is_smooth(a & lengths, b & lengths);
        smooth_whole += is_smooth(a, b);
    });
    return pairs >= fewest_pairs && one_in * pairs > words.pixels && 2 * smooth > pairs &&
           smooth > 4 * smooth_whole;
}

/// Millimetres times 8, with the bits above the 16th as the lowest: 1 from 8.192 m on, 2 from 16.384 m on.
bool is_rotated(const Words& words) {
    constexpr unsigned nearest = 250, deepest = 24'000;
    const auto millimetres = rotated_millimetres;
    const int divisor = divisor_of(words);
    return (divisor == 1 || divisor == 8) &&
           words.nearly_all([&](unsigned word) { return millimetres(word) < deepest; }) &&
           words.that([&](unsigned word) { return millimetres(word) > nearest; }) > words.pixels / 2;
}

double value_at(const StoredImage& picture, std::size_t k) {
    return picture.values.empty() ? sample_at(picture.image, k) : double{picture.values[k]};
}

/// The one negative number that stands for no depth: -1 in most arrays.
std::optional<double> negative_none(const StoredImage& picture, const RendererBackground& background) {
    std::optional<double> found;
    bool is_one = true;
    until_stopped(picture.values.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last && is_one; ++k) {
            const float value = picture.values[k];
            if (!(value < 0) || background.is(value)) continue;
            is_one = !found || *found == value;
            found = value;
        }
    });
    return is_one ? found : std::nullopt;
}

/// The exact median of many finite floats without storing them: they are added twice, and counted first by
/// the upper half of their bits, then by the lower half if the upper one is the median's.
class MedianCounts {
public:
    MedianCounts() : counts_(halves) {}
    void add(float value) { ++counts_[ordered_bits(value) >> 16U]; }
    /// Call once all were added. Of an even number, the median is the upper one of the two in the middle.
    void begin_again(std::size_t count) {
        left_ = count / 2;
        for (upper_ = 0; left_ >= counts_[upper_]; ++upper_) left_ -= counts_[upper_];
        counts_.assign(halves, 0);
    }
    void add_again(float value) {
        const std::uint32_t bits = ordered_bits(value);
        if (bits >> 16U == upper_) ++counts_[bits & 0xffffU];
    }
    float median() const {
        std::size_t left = left_;
        std::uint32_t lower = 0;
        for (; lower + 1 < halves && left >= counts_[lower]; ++lower) left -= counts_[lower];
        const std::uint32_t bits = upper_ << 16U | lower;
        return std::bit_cast<float>((bits & sign) != 0 ? bits ^ sign : ~bits);
    }

private:
    static constexpr std::uint32_t sign = 0x80000000U;
    static constexpr std::size_t halves = 65536;
    /// Bits that sort as the floats do.
    static std::uint32_t ordered_bits(float value) {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        return (bits & sign) != 0 ? ~bits : bits ^ sign;
    }

    std::vector<std::size_t> counts_;
    std::size_t left_ = 0;     // values of the upper half below the median
    std::uint32_t upper_ = 0;  // upper half of the median's bits
};

constexpr double rounding_of_floats =
    0x1p-22;                            // relative: of a quotient, or of a product with a rounded unit
constexpr double least_step = 64;       // roundings: a number lies that near a lattice once in 32 times
constexpr double most_off = 0.01;       // share of the floats that may lie between
constexpr double beyond_codes = 0.001;  // and that may lie beyond the codes
constexpr std::size_t fewest_numbers = 8;
constexpr std::size_t most_fitted = 4096;
constexpr double coarsest_of_depths = 1.0 / 25, coarsest_of_reciprocals = 1.0 / 4;  // of the median
/// Probability that halves fit a unit by chance. It may be large: halves move by no more than their rounding.
constexpr double strongest_chance = 0.05;

struct Occurring {
    double number;
    double pixels;
};

/// Each number once, ascending, without the share of largest ones that may lie beyond the codes.
struct Numbers {
    std::vector<Occurring> each;
    double pixels = 0, median = 0, rounding = 0;

    double least() const { return each.front().number; }
    double most() const { return each.back().number; }
};

/// `sample` is sorted.
Numbers numbers_of(const std::vector<float>& sample, bool reciprocals) {
    Numbers numbers;
    const auto number = [&](std::size_t k) {
        return reciprocals ? 1.0 / sample[sample.size() - 1 - k] : double{sample[k]};
    };
    const auto kept =
        sample.size() - static_cast<std::size_t>(beyond_codes * static_cast<double>(sample.size()));
    for (std::size_t k = 0; k < kept; ++k) {
        if (numbers.each.empty() || numbers.each.back().number != number(k))
            numbers.each.push_back({number(k), 0});
        ++numbers.each.back().pixels;
    }
    if (kept == 0) return numbers;
    numbers.pixels = static_cast<double>(kept);
    numbers.median = number(kept / 2);
    numbers.rounding = rounding_of_floats * std::max(std::abs(numbers.least()), std::abs(numbers.most()));
    return numbers;
}

double nearest_whole(double x) {
    return std::floor(x + 0.5);
}

/// Share of the pixels between the numbers of a lattice; the count ends once it is too large.
double share_off(const Numbers& numbers, double first, double step) {
    double off = 0;
    for (const Occurring& each : numbers.each) {
        const double k = nearest_whole((each.number - first) / step);
        if (std::abs(each.number - first - k * step) <= numbers.rounding) continue;
        off += each.pixels;
        if (off > most_off * numbers.pixels) break;
    }
    return off / numbers.pixels;
}

std::size_t numbers_occurring(const Numbers& numbers, double first, double step) {
    std::size_t occurring = 0;
    double before = 0;
    for (const Occurring& each : numbers.each) {
        const double k = nearest_whole((each.number - first) / step);
        occurring += occurring == 0 || k != before;
        before = k;
    }
    return occurring;
}

/// Whether enough of the lattice's numbers occur, and the codes suffice for all.
bool is_useful(const Numbers& numbers, double first, double step, double coarsest) {
    if (!(step >= least_step * numbers.rounding) || step > coarsest) return false;
    const double from = first == 0 && numbers.least() > 0 ? 0 : numbers.least();
    return (numbers.most() - from) / step <= LatticeSearch::most_codes &&
           numbers_occurring(numbers, first, step) >= fewest_numbers;
}

std::optional<FloatLattice> lattice_of(const Numbers& numbers, double first, double step, double coarsest) {
    if (!is_useful(numbers, first, step, coarsest)) return std::nullopt;
    const double off = share_off(numbers, first, step);
    if (off > most_off) return std::nullopt;
    return FloatLattice{first, step, false, false, off};
}

/// Units that people and cameras use, metres, from 1 mm down. Larger ones are multiples of 1 mm.
constexpr double usual_units[] = {1e-3, 5e-4, 2.5e-4, 2e-4, 1.25e-4, 1e-4, 5e-5, 2.5e-5, 2e-5, 1e-5, 1e-6};

std::optional<FloatLattice> of_usual_unit(const Numbers& numbers, double metres) {
    for (const double unit : usual_units)
        if (const auto found = lattice_of(numbers, 0, unit / metres, coarsest_of_depths * numbers.median))
            return found;
    return std::nullopt;
}

/// The step that two numbers of a lattice have in common, by Euclid.
double common_step(double a, double b, double nothing) {
    while (b > nothing) {
        const double rest = std::abs(a - nearest_whole(a / b) * b);
        a = b;
        b = rest;
    }
    return a;
}

/// The number of few digits, or 1 over a whole number, within `tolerance` of `step`; `step` if there is none.
double plain_number(double step, double tolerance) {
    for (double digits = 1; digits <= 1e7; digits *= 10) {
        const double plain = nearest_whole(step * digits) / digits;
        if (plain > 0 && step * digits >= 1 - 1e-6 && std::abs(plain - step) <= tolerance &&
            nearest_whole(step * digits) < 1e4)
            return plain;
    }
    const double plain = 1 / std::max(1.0, nearest_whole(1 / step));
    return std::abs(plain - step) <= tolerance ? plain : step;
}

/// A lattice through `anchor`, fitted to the numbers from there outward; a number counts if its place is
/// beyond doubt.
struct Fit {
    double first, step;
};
Fit fitted(const std::vector<double>& sorted, std::size_t anchor, double step, double rounding) {
    double kk = 1, kd = step, ks = 0, ds = 0, count = 0;
    std::size_t below = anchor, above = anchor + 1;
    const double from = sorted[anchor];
    while (below > 0 || above < sorted.size()) {
        const bool goes_up =
            below == 0 || (above < sorted.size() && sorted[above] - from < from - sorted[below - 1]);
        const double d = (goes_up ? sorted[above++] : sorted[--below]) - from,
                     k = nearest_whole(d / (kd / kk));
        if (std::abs(d - k * (kd / kk)) > 0.125 * step + rounding) continue;
        kk += k * k;
        kd += k * d;
        ks += k;
        ds += d;
        ++count;
    }
    const double found = kd / kk, at = count > 0 ? from + (ds - ks * found) / count : from;
    return {at - std::floor(at / found) * found, found};
}

/// The step of a lattice through zero, for numbers that are whole multiples.
double fitted_through_zero(const std::vector<double>& sorted, double step) {
    double kk = 1, kd = step;
    for (const double number : sorted) {
        const double k = nearest_whole(number / step);
        if (std::abs(number - k * step) > 0.125 * step) continue;
        kk += k * k;
        kd += k * number;
    }
    return kd / kk;
}

/// Finds any lattice: the common step of gaps between sorted numbers, a few gaps at a time, so that a number
/// off the lattice spoils few of these trials. The coarsest lattice found is taken.
std::optional<FloatLattice> of_any_step(const Numbers& numbers, double coarsest) {
    constexpr std::size_t trials = 9, in_a_trial = 6;
    const std::size_t every = 1 + numbers.each.size() / most_fitted;
    std::vector<double> sorted, gaps;
    for (std::size_t k = 0; k < numbers.each.size(); ++k) {
        if (k % every == 0) sorted.push_back(numbers.each[k].number);
        if (k == 0) continue;
        const double gap = numbers.each[k].number - numbers.each[k - 1].number;
        if (gap > 4 * numbers.rounding) gaps.push_back(gap);
    }
    if (gaps.size() + 1 < fewest_numbers) return std::nullopt;
    const double nothing = 16 * numbers.rounding;
    std::optional<FloatLattice> best;
    for (std::size_t trial = 0; trial < trials; ++trial) {
        double step = 0;
        for (std::size_t k = 0; k < in_a_trial; ++k) {
            const double gap = gaps[(trial * in_a_trial + k) * gaps.size() / (trials * in_a_trial)];
            step = step > 0 ? common_step(std::max(step, gap), std::min(step, gap), nothing) : gap;
        }
        if (step < least_step * numbers.rounding || (best && step < 1.5 * best->step)) continue;
        const Fit fit = fitted(sorted, (trial + 1) * sorted.size() / (trials + 1), step, numbers.rounding);
        const double through_zero = fitted_through_zero(sorted, fit.step);
        const double plain =
            plain_number(through_zero, 2 * numbers.rounding * through_zero / std::abs(numbers.most()));
        auto found = lattice_of(numbers, 0, plain, coarsest);
        if (!found) found = lattice_of(numbers, 0, through_zero, coarsest);
        if (!found) found = lattice_of(numbers, fit.first, fit.step, coarsest);
        if (found && (!best || found->step > 1.5 * best->step)) best = found;
    }
    return best;
}

/// The value of the lowest bit set in a float of 11 bits; 0 for one that has more.
double lowest_bit_of_half(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    if ((bits & 0x1fffU) != 0 || (bits & 0x7f800000U) == 0) return 0;
    const std::uint32_t digits = (bits & 0x7fffffU) | 0x800000U, lowest = digits & ~(digits - 1);
    return double{std::bit_cast<float>(bits & 0x7f800000U)} * lowest / 0x800000U;
}

/// Distance between neighbouring halves as large as `value`.
double step_of_halves(double value) {
    double step = 0x1p-24;
    while (step * 2048 <= value) step *= 2;
    return step;
}

/// Finds a usual unit whose multiples, rounded, are these halves: where its multiples are farther apart than
/// halves, most halves do not occur.
std::optional<FloatLattice> of_rounded_unit(const Numbers& numbers, double metres) {
    for (const double unit : usual_units) {
        const double step = unit / metres;
        if (step > coarsest_of_depths * numbers.median || numbers.most() / step > LatticeSearch::most_codes)
            continue;
        double off = 0, chance = 1;
        if (numbers_occurring(numbers, 0, step) < fewest_numbers) continue;
        for (const Occurring& each : numbers.each) {
            const double distance = std::abs(each.number - nearest_whole(each.number / step) * step);
            const double apart = step_of_halves(each.number);
            if (distance > 0.5 * apart + numbers.rounding)
                off += each.pixels;
            else if (chance > strongest_chance)
                chance *= std::min(1.0, apart / step);
        }
        if (off > 0 || chance > strongest_chance) continue;
        return FloatLattice{0, step, false, true, 0};
    }
    return std::nullopt;
}

/// The step of the halves nearest to zero, if codes suffice for all; else a coarser one, if few are so near.
std::optional<FloatLattice> of_halves(const Numbers& numbers) {
    double step = 0x1p100;
    for (const Occurring& each : numbers.each)
        step = std::min(step, lowest_bit_of_half(static_cast<float>(each.number)));
    const double coarsest = coarsest_of_depths * numbers.median;
    for (; step <= coarsest; step *= 2) {
        if (numbers.most() / step > LatticeSearch::most_codes) continue;
        const double off = share_off(numbers, 0, step);
        if (off > beyond_codes || !is_useful(numbers, 0, step, coarsest)) return std::nullopt;
        return FloatLattice{0, step, false, false, off};
    }
    return std::nullopt;
}

/// Which channels (red, green, blue, alpha) hold the bytes of a number, the lowest first.
struct PackedForm {
    Packing packing;
    std::size_t bytes;
    std::array<std::size_t, 4> channels;
    std::uint32_t base = 256;
    double whole = 1;  // the number that stands for 1
};
/// Of two that fit alike the first counts: floats before 24 bits, and to base 255 where that digit is
/// missing.
constexpr PackedForm packed_forms[] = {{Packing::rgba32f, 4, {0, 1, 2, 3}},
                                       {Packing::bgra32f, 4, {2, 1, 0, 3}},
                                       {Packing::abgr32f, 4, {3, 2, 1, 0}},
                                       {Packing::rgb24, 3, {0, 1, 2}},
                                       {Packing::bgr255, 3, {2, 1, 0}, 255, 255.0 * 255 * 255},
                                       {Packing::bgr24, 3, {2, 1, 0}, 256, 0xffffff},
                                       {Packing::rg16, 2, {0, 1}},
                                       {Packing::gr16, 2, {1, 0}}};

std::uint8_t channel_at(const StoredImage& picture, std::size_t k, std::size_t channel) {
    return channel < 3 ? picture.image.samples[3 * k + channel] : picture.alpha[k];
}

/// How often each value of a byte occurs in each of a picture's channels, and how many pixels are white.
struct ByteCounts {
    std::int64_t white = 0, counts[4][256] = {};

    explicit ByteCounts(const StoredImage& picture) {
        until_stopped(pixel_count(picture.image), [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint8_t* const rgb = &picture.image.samples[3 * k];
                for (std::size_t c = 0; c < 3; ++c) ++counts[c][rgb[c]];
                if (!picture.alpha.empty()) ++counts[3][picture.alpha[k]];
                white += rgb[0] == 255 && rgb[1] == 255 && rgb[2] == 255;
            }
        });
    }
    std::int64_t values(std::size_t channel, int first = 0, int last = 255) const {
        return std::count_if(counts[channel] + first, counts[channel] + last + 1, std::identity());
    }
    /// Whether numbers so packed may have such bytes.
    bool may_be(const PackedForm& form, std::int64_t varied) const {
        const std::size_t next = form.channels[form.bytes == 4 ? 1 : form.bytes - 2], last = form.channels[3];
        // Floats: lengths from 0.5 mm to 130 km, few exponents, and no negative ones.
        if (form.bytes == 4)
            return values(last, 0x3a, 0x47) > 0 && values(last) <= 8 && values(last, 128) == 0 &&
                   values(next) >= varied;
        return (form.bytes == 3 || values(2) <= 1) && (form.base == 256 || counts[next][255] <= white) &&
               values(next) >= varied && values(form.channels[0]) >= varied;
    }
};

/// How many neighbours show the carry between the bytes of such numbers (packing_of); 0: it is not so packed.
std::int64_t carries(const StoredImage& picture, const PackedForm& form, std::int64_t fewest) {
    const std::size_t top = form.bytes == 4 ? 2 : form.bytes - 1;  // above it floats have their exponent
    const auto width = static_cast<std::size_t>(picture.image.width);
    constexpr std::int64_t least_mean = 32;
    std::int64_t pairs = 0, sum = 0, ran_over = 0;
    const auto byte = [&](std::size_t k, std::size_t n) { return channel_at(picture, k, form.channels[n]); };
    const auto compare = [&](std::size_t a, std::size_t b) {
        const int high = byte(a, top) - byte(b, top);
        if (high != 1 && high != -1) return;
        const int low = high * (byte(a, top - 1) - byte(b, top - 1));
        ++pairs;
        sum += low;
        ran_over += low <= -128;
    };
    until_stopped(pixel_count(picture.image), [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            if ((k + 1) % width != 0) compare(k, k + 1);
            if (k >= width) compare(k, k - width);
        }
    });
    return ran_over >= fewest && sum <= -least_mean * pairs ? ran_over : 0;
}

}  // namespace

double half_value(double word) {
    constexpr std::uint32_t infinite = 0x7c00;
    const auto bits = static_cast<std::uint32_t>(word);
    return bits < infinite ? double{std::bit_cast<float>(bits << 13U)} * 0x1p112
                           : std::numeric_limits<double>::infinity();
}

Packing packing_of(const StoredImage& picture, bool is_likely) {
    const Image& image = picture.image;
    if (are_halves(picture)) return Packing::half;
    if (image.channels != 3 || image.bytes_per_sample != 1 || !picture.values.empty() ||
        picture.codec == "mjpeg")
        return Packing::none;
    Packing best = Packing::none;
    const ByteCounts bytes(picture);
    std::int64_t most = 0;
    for (const PackedForm& form : packed_forms)
        if (bytes.may_be(form, is_likely ? 16 : 32))
            if (const std::int64_t found = carries(picture, form, is_likely ? 2 : 16); found > most)
                most = found, best = form.packing;
    return best;
}

bool unpack_depth(StoredImage& picture, Packing packing) {
    if (picture.packing == packing) return true;
    const std::size_t pixels = pixel_count(picture.image);
    if (packing == Packing::half) {
        if (!holds_words(picture)) return false;
        for (std::size_t k = 0; k < pixels; ++k)
            picture.values.push_back(static_cast<float>(half_value(sample_at(picture.image, k))));
        picture.image.samples = {};
        picture.packing = packing;
        return true;
    }
    const PackedForm& form = *std::ranges::find(packed_forms, packing, &PackedForm::packing);
    if (picture.image.channels != 3 || picture.image.bytes_per_sample != 1 || !picture.values.empty() ||
        (form.bytes == 4 && picture.alpha.size() != pixels))
        return false;
    std::vector<float> values(form.bytes == 2 ? 0 : pixels);
    std::vector<std::uint8_t> words(form.bytes == 2 ? 2 * pixels : 0);
    const bool all_done = until_stopped(pixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            std::uint32_t number = 0;
            for (std::size_t n = form.bytes; n-- > 0;)
                number = number * form.base + channel_at(picture, k, form.channels[n]);
            const auto word = static_cast<std::uint16_t>(number);
            if (form.bytes == 2)
                std::memcpy(&words[2 * k], &word, 2);
            else
                values[k] =
                    form.bytes == 4 ? std::bit_cast<float>(number) : static_cast<float>(number / form.whole);
        }
    });
    if (!all_done) return false;
    picture.values = std::move(values);
    picture.image.samples = std::move(words);
    picture.image.bytes_per_sample = form.bytes == 2 ? 2 : 1;
    picture.image.channels = 1;
    picture.bits = form.bytes == 2 ? 16 : 8;
    picture.alpha = {};
    picture.packing = packing;
    return true;
}

std::optional<std::uint16_t> none_above_all(const StoredImage& picture) {
    constexpr std::int64_t one_in = 200;
    constexpr double far_above = 1.25;
    const Words words(picture);
    if (!words.tell()) return {};
    const auto [word, pixels] = words.each.back();
    const unsigned before = words.each[words.each.size() - 2].word;
    const bool has_all_bits = word >= 1023 && (word & (word + 1)) == 0, is_round = word % 10'000 == 0;
    const bool is_piled = one_in * pixels > words.pixels && word > far_above * before;
    return (has_all_bits || is_round) && is_piled ? std::optional(static_cast<std::uint16_t>(word))
                                                  : std::nullopt;
}

PlaneVotes::PlaneVotes(const StoredImage& picture, const Reading& first, const Reading& second) {
    constexpr double flat = 1e-3, flatter = 16;  // shares of the variance, and their ratio
    constexpr int most_across = 32;              // more squares say no more
    const int width = picture.image.width, height = picture.image.height;
    std::vector<double> numbers;
    // The share of the variance that no affine function has.
    const auto bend = [&](int left, int top, int side, const Reading& reading) {
        numbers.clear();
        for (int y = top; y < top + side; ++y)
            for (int x = left; x < left + side; ++x)
                numbers.push_back(
                    reading(value_at(picture, static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                                  static_cast<std::size_t>(x))));
        const double count = side * side, middle = 0.5 * (side - 1), squares = count * (count - 1) / 12;
        double mean = 0, right = 0, down = 0, bent = 0, all = 0;
        for (const double number : numbers) mean += number / count;
        const auto for_each = [&](auto&& work) {
            auto number = numbers.begin();
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) work(x - middle, y - middle, *number++ - mean);
        };
        for_each([&](double x, double y, double number) {
            right += x * number / squares;
            down += y * number / squares;
        });
        for_each([&](double x, double y, double number) {
            const double left_over = number - right * x - down * y;
            bent += left_over * left_over;
            all += number * number;
        });
        return all > 0 ? bent / all : std::numeric_limits<double>::infinity();
    };
    for (const int side : {std::clamp(width / 20, 6, 32), std::clamp(width / 8, 16, 64)}) {
        const int apart = std::max(side, width / most_across);
        for (int top = 0; top + side <= height && !stop_requested(); top += apart)
            for (int left = 0; left + side <= width; left += apart) {
                const double a = bend(left, top, side, first), b = bend(left, top, side, second);
                first_ += a < flat && b > flatter * a;
                second_ += b < flat && a > flatter * b;
            }
    }
}

EvidentPreset evident_preset(const StoredImage& picture) {
    if (const auto* const packed = preset_of(picture.packing))
        return {packed, picture.packing == Packing::half
                            ? "flat places are flat by these numbers and not by their bits"
                            : "where one byte of its colours grows by 1 the next runs over"};
    const Words words(picture);
    if (!words.tell()) return {};
    if (is_plain_kinect(words))
        return {
            preset_named("kinect-raw"),
            "its values are a Kinect's disparities of 11 bits, from 300 to 1092, and 2047 where it saw none"};
    if (is_kinect(words, swapped))
        return {preset_named("nyu"),
                "with their bytes swapped its values are a Kinect's disparities, from 0 to 2047"};
    if (has_player(picture, words))
        return {preset_named("kinect-sdk1"),
                "its 3 lowest bits are 0 but for areas, as the numbers of persons are, and depth goes on "
                "above them"};
    if (has_one_confidence(picture, words))
        return {preset_named("depth16"),
                "its 3 highest bits are the same everywhere, and flat places are flat without them"};
    if (has_confidence(picture, words))
        return {preset_named("depth16"),
                "its 3 highest bits change between neighbours whose other bits are nearly the same"};
    if (is_rotated(words))
        return {preset_named("sun"),
                "its values are multiples of 8, with the bits of what is beyond 8.191 m below them"};
    return {};
}

RendererBackground::RendererBackground(const StoredImage& picture) {
    constexpr float round[] = {10, 100, 1000, 65.535F, 655.35F, 6553.5F, 65535};
    constexpr float far_beyond = 1.25F;
    constexpr std::size_t one_in = 200;
    float next = 0;
    std::size_t piled = 0;
    until_stopped(picture.values.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            const float size = std::abs(picture.values[k]);
            if (!(size < endless)) continue;
            if (size > farthest_)
                next = std::exchange(farthest_, size), piled = 1;
            else if (size == farthest_)
                ++piled;
            else
                next = std::max(next, size);
        }
    });
    const bool is_beyond =
        one_in * piled > picture.values.size() && farthest_ > far_beyond * next && next > 0;
    if (farthest_ != largest_half && !(is_beyond && std::ranges::count(round, farthest_) > 0)) farthest_ = 0;
}

bool are_negated(const StoredImage& picture) {
    if (std::ranges::none_of(picture.values, [](float value) { return value < 0; })) return false;
    const RendererBackground background(picture);
    return std::ranges::none_of(picture.values,
                                [&](float value) { return value > 0 && !background.is(value); }) &&
           !negative_none(picture, background);
}

std::optional<EmptyBackground> empty_background(const StoredImage& picture) {
    const auto width = static_cast<std::size_t>(picture.image.width), pixels = pixel_count(picture.image);
    const auto is_border = [&](std::size_t k) {
        return k < width || k + width >= pixels || k % width == 0 || (k + 1) % width == 0;
    };
    double most = 0;
    for (std::size_t k = 0; k < pixels; ++k) most = std::max(most, value_at(picture, k));
    for (const double empty : {most, 0.0}) {
        if (stop_requested()) break;
        std::size_t all = 0, border = 0, around = 0;
        for (std::size_t k = 0; k < pixels;) {
            ++border;
            around += value_at(picture, k) == empty;
            k += k % width == 0 && !is_border(k + 1) ? width - 1 : 1;  // over a row's inside
        }
        if (4 * around < 3 * border) continue;
        double least = most, largest = 0;
        double sums[2] = {0, 0}, counts[2] = {0, 0};  // of things, and of their rims
        for (std::size_t k = 0; k < pixels; ++k) {
            const double value = value_at(picture, k);
            const bool is_at_border = is_border(k), is_empty = value == empty;
            all += is_empty;
            if (is_empty || is_at_border) continue;
            const bool is_rim = std::ranges::any_of(std::array{k - 1, k + 1, k - width, k + width},
                                                    [&](auto n) { return value_at(picture, n) == empty; });
            sums[is_rim] += value;
            ++counts[is_rim];
            least = std::min(least, value);
            largest = std::max(largest, value);
        }
        if (5 * all < pixels || counts[0] == 0 || counts[1] == 0) continue;
        const double rim = sums[1] / counts[1] - sums[0] / counts[0];
        const bool is_clear = std::abs(rim) > 0.05 * (largest - least);
        return EmptyBackground{empty, is_clear ? rim < 0 : empty == 0};
    }
    return {};
}

EstimatedValues estimate_values(const StoredImage& picture) {
    EstimatedValues values;
    values.is_float = !picture.values.empty();
    values.bits = values.is_float ? 32 : 8 * picture.image.bytes_per_sample;
    const double most = values.is_float ? 1 : 65535;
    const std::size_t pixels = pixel_count(picture.image);
    MedianCounts median;
    double sums[2] = {0, 0};
    std::size_t counts[2] = {0, 0}, at_least = 0, at_most = 0, beyond = 0, negative = 0, usable = 0,
                zeros = 0, largest = 0;
    const RendererBackground background(picture);
    const auto none = negative_none(picture, background);
    values.has_negative_none = none.has_value();
    const double sign = are_negated(picture) ? -1 : 1;
    const auto is_usable = [&](double value) {
        return std::isfinite(value) && value != 0 && (values.is_float || value != most);
    };
    until_stopped(pixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const double value = sign * value_at(picture, k);
            if (values.is_float && background.is(value)) {
                values.has_background = true;
                continue;
            }
            if (value == none) continue;
            at_least += value >= 0 && value < 0.02 * most;
            // 65535 alone, far above all others, is a sky or none.
            at_most += value > 0.98 * most && (values.is_float ? value <= most : value < most);
            beyond += value > most;
            negative += value < 0;
            zeros += value == 0;
            largest += !values.is_float && value == most;
            if (!is_usable(value)) continue;
            median.add(static_cast<float>(value));
            ++usable;
            const std::size_t third = 3 * k / pixels;
            if (third == 1) continue;
            sums[third / 2] += value;
            ++counts[third / 2];
        }
    });
    if (usable == 0) return values;
    values.any = true;
    median.begin_again(usable);
    until_stopped(pixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const double value = sign * value_at(picture, k);
            if (is_usable(value) && value != none && !(values.is_float && background.is(value)))
                median.add_again(static_cast<float>(value));
        }
    });
    values.median = median.median();
    values.usable = static_cast<double>(usable) / static_cast<double>(pixels);
    values.zeros = static_cast<double>(zeros) / static_cast<double>(pixels);
    values.largest = static_cast<double>(largest) / static_cast<double>(pixels);
    values.negative = static_cast<double>(negative) / static_cast<double>(pixels);
    // The whole range is used, and no value stands for no depth.
    values.is_normalised = values.bits != 8 && !values.has_background && !none && beyond == 0 &&
                           negative == 0 && at_least > 0 && at_most > 0 && 20 * (pixels - usable) < pixels;
    values.are_shares = values.is_float && !values.has_background && beyond == 0 && negative == 0;
    values.divisor = divisor_of(Words(picture));
    if (counts[0] > 0) values.upper = sums[0] / static_cast<double>(counts[0]);
    if (counts[1] > 0) values.lower = sums[1] / static_cast<double>(counts[1]);
    return values;
}

std::optional<FloatLattice> LatticeSearch::of_lengths(double metres) {
    std::sort(sample_.begin(), sample_.end());
    if (sample_.empty() || !(sample_.front() > 0)) return std::nullopt;
    const Numbers depths = numbers_of(sample_, false);
    if (auto found = of_usual_unit(depths, metres)) return found;
    if (std::ranges::all_of(depths.each, [](const Occurring& each) {
            return lowest_bit_of_half(static_cast<float>(each.number)) > 0;
        })) {
        if (auto found = of_rounded_unit(depths, metres)) return found;
        if (auto found = of_halves(depths)) return found;
    }
    if (auto found = of_any_step(depths, coarsest_of_depths * depths.median)) return found;
    const Numbers reciprocals = numbers_of(sample_, true);
    auto found = of_any_step(reciprocals, coarsest_of_reciprocals * reciprocals.median);
    if (found) found->of_reciprocals = true;
    return found;
}

std::optional<FloatLattice> LatticeSearch::of_numbers() {
    std::sort(sample_.begin(), sample_.end());
    if (sample_.empty()) return std::nullopt;
    return of_any_step(numbers_of(sample_, false), std::numeric_limits<double>::max());
}

}  // namespace touchable
