#include "engine/formats/float_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace touchable {
namespace {

constexpr double rounding_of_floats =
    0x1p-22;                            // relative: of a quotient, or of a product with a rounded unit
constexpr double least_step = 64;       // roundings: a number lies that near a lattice once in 32 times
constexpr double most_off = 0.01;       // share of the floats that may lie between
constexpr double beyond_codes = 0.001;  // and beyond the codes
constexpr std::size_t fewest_numbers = 8;
constexpr std::size_t most_fitted = 4096;
constexpr double coarsest_of_depths = 1.0 / 25, coarsest_of_reciprocals = 1.0 / 4;  // of the median
/// That halves fit a unit though they came from none. It may be large: they are moved by no more than what
/// rounding to them did.
constexpr double strongest_chance = 0.05;

struct Occurring {
    double number;
    double pixels;
};

/// Each number once, ascending, without the share that is beyond all others.
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

/// Share of the pixels between the numbers of a lattice. It is looked at no further once it is too large.
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

/// Numbers of the lattice that occur are enough, and the codes suffice for all.
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

/// A number of few digits, or one divided by a whole one, where such a one is that near.
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

/// A lattice through `anchor`, fitted to the numbers from there outward, each counted once its place is
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

/// The same through zero, as it is where the numbers are whole multiples.
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

/// Any lattice: what neighbours of the sorted numbers have in common, a few of them at a time, so that one
/// that is off the lattice spoils few of these trials. The coarsest stands.
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

/// The lowest bit that is set in a float of 11 bits; 0 of one that has more.
double lowest_bit_of_half(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    if ((bits & 0x1fffU) != 0 || (bits & 0x7f800000U) == 0) return 0;
    const std::uint32_t digits = (bits & 0x7fffffU) | 0x800000U, lowest = digits & ~(digits - 1);
    const std::uint32_t exponent = bits & 0x7f800000U;
    float one = 0;
    std::memcpy(&one, &exponent, sizeof one);
    return double{one} * lowest / 0x800000U;
}

/// Halves are as far apart as this where they are as large as `value`.
double step_of_halves(double value) {
    double step = 0x1p-24;
    while (step * 2048 <= value) step *= 2;
    return step;
}

/// Halves that are the nearest ones to multiples of a usual unit: where units are farther apart than halves,
/// most halves do not occur.
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

/// The step of the halves nearest to zero, as long as that leaves codes for all; a coarser one where few are
/// so near.
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

}  // namespace

std::optional<FloatLattice> LatticeSearch::of_lengths(double metres) {
    std::sort(sample_.begin(), sample_.end());
    if (sample_.empty() || !(sample_.front() > 0)) return std::nullopt;
    const Numbers depths = numbers_of(sample_, false);
    if (auto found = of_usual_unit(depths, metres)) return found;
    const bool are_halves = std::all_of(depths.each.begin(), depths.each.end(), [](const Occurring& each) {
        return lowest_bit_of_half(static_cast<float>(each.number)) > 0;
    });
    if (are_halves) {
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
