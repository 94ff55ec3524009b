// SPDX-License-Identifier: Apache-2.0
// Statistics of noise from frame to frame and from pixel to pixel, of holes, and of pixels between surfaces.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "engine/base/same_bits.hpp"
#include "engine/surface/estimators.hpp"
#include "engine/surface/flying_pixels.hpp"

namespace touchable {
namespace {

/// Of larger pictures only some rows are measured.
constexpr std::int64_t enough_pixels = 640 * 480;
/// Neighbours whose depths differ by more than 1/20 are an edge; more than twice that is no noise.
constexpr int edge_share = 20;
/// Fewer pixels say nothing.
constexpr std::int64_t least_count = 200;
/// Pixels 1/16 of the picture's width apart have no noise in common.
constexpr int far_apart_share = 16;
/// Common changes over the variance of codes: below 0.07 in films with measurable noise (a fast pan), mostly
/// above 0.2 in unrelated pictures.
constexpr double most_of_film = 0.125;
/// A gain is taken off changes where it makes them at least so much larger.
constexpr double common_per_own = 2;
/// Changes by which rounding alone differs from a common one: d and e by one code each.
constexpr double rounding_square = 2;
/// Every so many pixels of a row tell the change that all have in common.
constexpr int common_apart = 8;
constexpr std::array no_pair{CodePicture::invalid, CodePicture::invalid, CodePicture::invalid};
/// What bends so much less than the rest is smooth.
constexpr double smooth_share = 0.1;

int row_step(const CodePicture& picture) {
    return static_cast<int>(
        std::max<std::int64_t>(1, std::int64_t{picture.width} * picture.height / enough_pixels));
}

/// The measured rows, and those beside them.
CodePicture kept_rows(const CodePicture& picture) {
    const int step = row_step(picture);
    if (step <= 3) return picture;
    CodePicture kept{picture.width, 0, {}};
    for (int y = 1; y < picture.height - 1; y += step) {
        kept.codes.insert(kept.codes.end(), picture.row(y - 1), picture.row(y + 2));
        kept.height += 3;
    }
    return kept;
}

/// Class by the highest three bits: 4 n + the two below the highest.
std::size_t size_class(int size) {
    if (size < 4) return static_cast<std::size_t>(size);
    int shift = 0;
    while (size >> shift >= 8) ++shift;
    return static_cast<std::size_t>(4 * shift + (size >> shift));
}

/// The smallest size of a class.
double least_of_class(std::size_t number) {
    if (number < 4) return static_cast<double>(number);
    const std::size_t shift = (number - 4) / 4;
    return std::ldexp(static_cast<double>(number - 4 * shift), static_cast<int>(shift));
}

/// The code of a pixel; `invalid` outside the picture.
int code_of(const CodePicture& picture, int x, int y) {
    const bool inside = x >= 0 && x < picture.width && y >= 0 && y < picture.height;
    return inside ? picture.row(y)[x] : CodePicture::invalid;
}

}  // namespace

DepthLength fitted_length(const std::vector<LengthAtDepth>& all) {
    double ones = 0, squares = 0, fourths = 0, lengths = 0, products = 0;
    for (const LengthAtDepth& one : all) {
        const double weight = one.weight / (one.length * one.length), z2 = one.depth * one.depth;
        ones += weight;
        squares += weight * z2;
        fourths += weight * z2 * z2;
        lengths += weight * one.length;
        products += weight * z2 * one.length;
    }
    if (all.empty()) return {};
    const double determinant = ones * fourths - squares * squares;
    if (determinant > 1e-9 * ones * fourths) {
        const double constant = (lengths * fourths - products * squares) / determinant;
        const double quadratic = (ones * products - squares * lengths) / determinant;
        if (constant >= 0 && quadratic >= 0) return {constant, quadratic};
        if (constant < 0) return {0, products / fourths};
    }
    return {lengths / ones, 0};
}

void ClippedSums::add(int size, std::int64_t product, std::int64_t square) {
    Sum& sum = sums_[size_class(size)];
    ++sum.count;
    sum.product += product;
    sum.square += square;
}

ClippedSums::Means ClippedSums::means(double limit) const {
    std::int64_t whole = 0;
    for (const Sum& sum : sums_) whole += sum.count;
    Means means;
    for (int round = 0; round < 4; ++round) {
        Sum all;
        for (std::size_t k = 0; k < sums_.size() && least_of_class(k) <= limit; ++k) {
            all.count += sums_[k].count;
            all.product += sums_[k].product;
            all.square += sums_[k].square;
        }
        if (all.count == 0 || 2 * all.count < whole) return {};
        const auto count = static_cast<double>(all.count);
        means = {all.count, static_cast<double>(all.product) / count,
                 static_cast<double>(all.square) / count};
        limit = std::min(limit, std::max(1.0, 4 * std::sqrt(means.square)));
    }
    return means;
}

std::int64_t ClippedSums::count_to(double size) const {
    std::int64_t count = 0;
    for (std::size_t k = 0; k < sums_.size() && least_of_class(k) <= size; ++k) count += sums_[k].count;
    return count;
}

NoiseEstimator::NoiseEstimator(const DepthCoding& coding) : window_of_code_(65536) {
    for (int first = 0; first < 65536; first = end_of_window(first)) {
        Window window;
        const int end = end_of_window(first);
        const auto depth = [&](int code) { return coding.depth(static_cast<std::uint16_t>(code)); };
        const int last = std::min<int>(end - 1, coding.code_max);
        if (last > first) {
            window.depth = depth((first + last) / 2);
            window.step = std::fabs(depth(last) - depth(first)) / (last - first);
        }
        for (int code = first; code < end; ++code)
            window_of_code_[static_cast<std::size_t>(code)] = static_cast<std::uint8_t>(windows_.size());
        windows_.push_back(std::move(window));
    }
    changes_ = own_changes_ = Changes(windows_.size());
}

NoiseEstimator::Place NoiseEstimator::place_of(const CodePicture& picture, int x, int y) const {
    const int here = picture.row(y)[x];
    const int around[] = {picture.row(y)[x - 1], picture.row(y)[x + 1], picture.row(y - 1)[x],
                          picture.row(y + 1)[x]};
    const Window& window = window_of(here);
    int most = 0;
    for (const int code : around) {
        if (code == CodePicture::invalid) return Place::rim;
        most = std::max(most, std::abs(code - here));
    }
    return edge_share * most * window.step > window.depth ? Place::edge : Place::flat;
}

int NoiseEstimator::flat_codes(const Window& window) const {
    return std::max(1, static_cast<int>(window.depth / (flat_share * window.step)));
}

void NoiseEstimator::look_at_edge(const CodePicture& picture, int x, int y) {
    const auto at = [&](int dx, int dy) { return code_of(picture, x + dx, y + dy); };
    const Window& window = window_of(at(0, 0));
    if (window.step == 0) return;
    bool flies = false, is_midway = false;
    for_each_hanging(at, flat_codes(window), [&, here = at(0, 0)](int low, int high) {
        flies = true;
        is_midway |= 4 * std::min(here - low, high - here) >= high - low;
    });
    flying_ += flies;
    midway_ += is_midway;
    clean_edges_ += is_clean_edge(picture, x, y);
}

bool NoiseEstimator::is_clean_edge(const CodePicture& picture, int x, int y) const {
    const Window& window = window_of(code_of(picture, x, y));
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
        const int before = code_of(picture, x - dx, y - dy), here = code_of(picture, x, y),
                  there = code_of(picture, x + dx, y + dy), beyond = code_of(picture, x + 2 * dx, y + 2 * dy);
        if (std::min(std::min(before, there), beyond) < 0) continue;
        const int jump = std::abs(there - here);
        if (jump > 4 * flat_codes(window) && 4 * std::abs(here - before) <= jump &&
            4 * std::abs(beyond - there) <= jump)
            return true;
    }
    return false;
}

/// Counts a tiny hole, or adds how much the surface bends at the pixel.
void NoiseEstimator::look_at_pixel(const CodePicture& picture, int x, int y) {
    const int here = picture.row(y)[x];
    int valid = 0, bend = 4 * here;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int code = picture.row(y + dy)[x + dx];
            if ((dx == 0 && dy == 0) || code == CodePicture::invalid) continue;
            ++valid;
            bend += dx != 0 && dy != 0 ? code : -2 * code;
        }
    ++pixels_;
    if (here == CodePicture::invalid) {
        tiny_holes_ += valid >= 6;
        return;
    }
    const Place place = place_of(picture, x, y);
    if (place == Place::edge) look_at_edge(picture, x, y);
    if (valid == 8 && place == Place::flat) {
        const std::int64_t square = std::int64_t{bend} * bend;
        windows_[window_of_code_[static_cast<std::size_t>(here)]].bends.add(std::abs(bend), 0, square);
        if (last_.empty()) add_wide_bend(picture, x, y);
    }
}

void NoiseEstimator::add_wide_bend(const CodePicture& picture, int x, int y) {
    std::int64_t bend = 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int code = code_of(picture, x + 2 * dx, y + 2 * dy);
            if (code == CodePicture::invalid) return;
            bend += std::int64_t{dx == 0 ? 2 : -1} * (dy == 0 ? 2 : -1) * code;
        }
    windows_[window_of_code_[static_cast<std::size_t>(picture.row(y)[x])]].wide_bends.add(
        static_cast<int>(std::abs(bend)), 0, bend * bend);
}

void NoiseEstimator::Changes::add(std::size_t window, Place place, const std::array<int, 3>& codes,
                                  const std::array<int, 3>& there, const std::array<int, 2>& common,
                                  const std::array<int, 2>& common_there) {
    const std::int64_t d = codes[1] - codes[0] - common[0], e = codes[2] - codes[1] - common[1];
    of[window][static_cast<std::size_t>(place)].add(static_cast<int>(std::max(std::abs(d), std::abs(e))),
                                                    d * e, (d * d + e * e) / 2);
    if (there[1] == CodePicture::invalid) return;
    ++pairs;
    code += codes[1];
    square += std::int64_t{codes[1]} * codes[1];
    product -= d * (there[2] - there[1] - common_there[1]) + e * (there[1] - there[0] - common_there[0]);
    change += d * d + e * e;
}

template <class Visit>
void NoiseEstimator::each_kept(const Triple& pictures, const Visit& visit) const {
    const CodePicture& here = *pictures[1];
    for (int y = 1; y < here.height - 1; y += std::min(row_step_, 3))
        for (int x = 1; x < here.width - 1; ++x) {
            const std::array<int, 3> codes{pictures[0]->row(y)[x], here.row(y)[x], pictures[2]->row(y)[x]};
            if (codes[0] != CodePicture::invalid && codes[2] != CodePicture::invalid) visit(x, y, codes);
        }
}

std::vector<std::array<int, 2>> NoiseEstimator::common_changes(const Triple& pictures) const {
    std::vector<std::array<std::vector<int>, 2>> all(windows_.size());
    each_kept(pictures, [&](int x, int, const std::array<int, 3>& codes) {
        if (x % common_apart != 0 || codes[1] == CodePicture::invalid) return;
        auto& [to, from] = all[window_of_code_[static_cast<std::size_t>(codes[1])]];
        to.push_back(codes[1] - codes[0]);
        from.push_back(codes[2] - codes[1]);
    });
    std::vector<std::array<int, 2>> common(windows_.size());
    for (std::size_t w = 0; w < all.size(); ++w)
        for (std::size_t k = 0; k < 2; ++k)
            if (std::vector<int>& of = all[w][k]; !of.empty())
                common[w][k] = sorted_element(of, of.size() / 2);
    return common;
}

void NoiseEstimator::look_at_changes(const Triple& pictures) {
    const CodePicture& here = *pictures[1];
    const int far_apart = std::max(1, here.width / far_apart_share);
    const auto common = common_changes(pictures);
    constexpr std::array<int, 2> none{0, 0};
    each_kept(pictures, [&](int x, int y, const std::array<int, 3>& codes) {
        ++kept_;
        const int code = codes[1];
        if (code == CodePicture::invalid) {
            ++dropped_;
            return;
        }
        const Place place = place_of(here, x, y);
        const std::array<int, 3> there{code_of(*pictures[0], x + far_apart, y),
                                       code_of(here, x + far_apart, y),
                                       code_of(*pictures[2], x + far_apart, y)};
        const std::size_t window = window_of_code_[static_cast<std::size_t>(code)];
        flat_ += place == Place::flat;
        changed_ += place == Place::flat && (codes[0] != code || code != codes[2]);
        const bool is_pair = *std::ranges::min_element(there) >= 0;
        changes_.add(window, place, codes, is_pair ? there : no_pair, none, none);
        if (x % common_apart != 0) return;
        own_changes_.add(window, place, codes, is_pair ? there : no_pair, common[window],
                         is_pair ? common[window_of_code_[static_cast<std::size_t>(there[1])]] : none);
    });
}

void NoiseEstimator::add(const CodePicture& picture) {
    for (int y = 1; y < picture.height - 1; y += row_step(picture))
        for (int x = 1; x < picture.width - 1; ++x) look_at_pixel(picture, x, y);
    row_step_ = row_step(picture);
    last_.push_back(kept_rows(picture));
    if (last_.size() < 3) return;
    look_at_changes({&last_[0], &last_[1], &last_[2]});
    last_.erase(last_.begin());
}

bool NoiseEstimator::is_film(const Changes& changes) {
    if (changes.pairs == 0) return true;
    const auto count = static_cast<double>(changes.pairs);
    const double mean = static_cast<double>(changes.code) / count;
    const double variance = static_cast<double>(changes.square) / count - mean * mean;
    return static_cast<double>(changes.product) / (2 * count) <= most_of_film * std::max(0.0, variance);
}

const NoiseEstimator::Changes* NoiseEstimator::film() const {
    const auto mean = [](const Changes& of, std::int64_t sum) {
        return static_cast<double>(sum) / static_cast<double>(std::max<std::int64_t>(of.pairs, 1));
    };
    const double all = mean(changes_, changes_.change), own = mean(own_changes_, own_changes_.change);
    if (mean(own_changes_, own_changes_.product) <= most_of_film * own && own > rounding_square &&
        common_per_own * own < all)
        return &own_changes_;
    return is_film(changes_) ? &changes_ : nullptr;
}

DepthLength NoiseEstimator::noise(Place place) const {
    const Changes* const changes = film();
    if (!changes) return {};
    std::vector<LengthAtDepth> points;
    std::int64_t all = 0, noisy = 0;
    for (std::size_t w = 0; w < windows_.size(); ++w) {
        const Window& window = windows_[w];
        if (window.step == 0) continue;
        const double limit = 2 * window.depth / (edge_share * window.step);
        const auto means = changes->of[w][static_cast<std::size_t>(place)].means(limit);
        if (means.count < least_count) continue;
        all += means.count;
        // White noise has -1/2; what stands still or moves steadily has 0 or more.
        if (!(means.product < -0.3 * means.square)) continue;
        noisy += means.count;
        points.push_back(
            {window.depth, window.step * std::sqrt(-means.product), static_cast<double>(means.count)});
    }
    if (2 * noisy < all) return {};
    return fitted_length(points);
}

DepthLength NoiseEstimator::roughness_of(ClippedSums Window::*bends) const {
    std::vector<LengthAtDepth> points;
    for (const Window& window : windows_) {
        if (window.step == 0) continue;
        // Six times the limit for a depth, as the sum of bends is six times as much off as a code.
        const auto means = (window.*bends).means(12 * window.depth / (edge_share * window.step));
        if (means.count < least_count || means.square == 0) continue;
        // The sum's weights are 4, four times -2 and four times 1: 36 times the variance of one code.
        points.push_back(
            {window.depth, window.step * std::sqrt(means.square / 36), static_cast<double>(means.count)});
    }
    return fitted_length(points);
}

double NoiseEstimator::smooth() const {
    // Relative to the width of a pixel, which grows with depth.
    double all = 0, squares = 0, smooth = 0;
    const auto each = [&](const auto& visit) {
        for (const Window& window : windows_) {
            if (window.step == 0 || window.depth == 0) continue;
            const double codes = window.depth / window.step;
            const auto means = window.bends.means(12 * codes / edge_share);
            if (means.count >= least_count) visit(window, codes, means);
        }
    };
    each([&](const Window&, double codes, const ClippedSums::Means& means) {
        all += static_cast<double>(means.count);
        squares += static_cast<double>(means.count) * means.square / (codes * codes);
    });
    if (squares == 0) return 0;
    const double limit = smooth_share * std::sqrt(squares / all);
    each([&](const Window& window, double codes, const ClippedSums::Means&) {
        smooth += static_cast<double>(window.bends.count_to(limit * codes));
    });
    return smooth / all;
}

}  // namespace touchable
