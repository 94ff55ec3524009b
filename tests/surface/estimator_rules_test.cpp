// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/estimators.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// The measurements of docs/conventions.md in plain loops: every number of that page stands here once more.
/// It shares nothing with engine/surface but codes and their depths.
struct PlainEstimator {
    double median_depth = 0;  ///< 0: nothing is valid
    DepthLength levels;
    DepthLength noise_at_flat, noise_at_edges, noise_at_rims, roughness, wide_roughness;
    double dropouts = 0, tiny_holes = 0, flying = 0, midway = 0, clean_edges = 0, smooth = 0, changing = 0;

    /// Which rules decided something, by name; so a test knows that its pictures try them.
    std::vector<std::string> decided;
};

constexpr int nothing = CodePicture::invalid;
/// A value at a limit is within it, despite rounding.
constexpr double rounding = 1 + 1e-12;

/// One sample of a window: its size in codes, and the values that are averaged.
struct Sample {
    std::int64_t size, product, square;
};
struct Fit {
    double depth, length, weight;
};
struct Weight {
    double value;
    std::int64_t pixels;
};

double middle_of(std::vector<Weight> all) {
    std::sort(all.begin(), all.end(), [](const Weight& a, const Weight& b) { return a.value < b.value; });
    std::int64_t whole = 0, up_to = 0;
    for (const Weight& one : all) whole += one.pixels;
    for (const Weight& one : all)
        if (2 * (up_to += one.pixels) >= whole) return one.value;
    return 0;
}

class Measuring {
public:
    Measuring(const DepthCoding& coding, const std::vector<CodePicture>& pictures)
        : coding_(coding), pictures_(pictures) {}

    PlainEstimator all() {
        estimator_.median_depth = median();
        estimator_.levels = levels();
        look();
        estimator_.noise_at_flat = noise(0);
        estimator_.noise_at_edges = noise(1);
        estimator_.noise_at_rims = noise(2);
        estimator_.roughness = roughness(bends_);
        estimator_.wide_roughness = roughness(wide_bends_);
        estimator_.smooth = smooth();
        return estimator_;
    }

private:
    /// 64 codes, or an eighth of the first code where that is more.
    static std::pair<int, int> window_of(int code) {
        int first = 0;
        while (true) {
            const int end = std::min(65536, first + std::max(64, first / 8));
            if (code < end) return {first, end};
            first = end;
        }
    }
    double depth(int code) const { return coding_.depth(static_cast<std::uint16_t>(code)); }
    /// A window's depth is that of its middle; its step the mean distance of a code from the next.
    std::pair<double, double> depth_and_step(int first) const {
        const int last = std::min<int>(window_of(first).second - 1, coding_.code_max);
        if (last <= first) return {0, 0};
        return {depth((first + last) / 2), std::fabs(depth(last) - depth(first)) / (last - first)};
    }
    static int at(const CodePicture& picture, int x, int y) {
        if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return nothing;
        return picture.codes[static_cast<std::size_t>(y * picture.width + x)];
    }
    void decide(const char* rule) { estimator_.decided.emplace_back(rule); }

    // Levels.

    double median() const {
        std::vector<Weight> near, far;
        for (const auto& [code, pixels] : frequency())
            (depth(code) < 0.999 * coding_.far ? near : far).push_back({depth(code), pixels});
        return middle_of(near.empty() ? far : near);
    }
    std::map<int, std::int64_t> frequency() const {
        std::map<int, std::int64_t> pixels;
        for (const CodePicture& picture : pictures_)
            for (const int code : picture.codes)
                if (code != nothing) ++pixels[code];
        return pixels;
    }
    DepthLength levels() {
        const auto pixels = frequency();
        std::vector<Weight> distances, shares, depths;
        for (int first = 0; first < 65536; first = window_of(first).second) {
            std::map<int, std::int64_t> here(pixels.lower_bound(first),
                                             pixels.lower_bound(window_of(first).second));
            if (!here.empty()) add_levels(here, distances, shares, depths);
        }
        if (distances.size() < 3) {
            if (!distances.empty()) decide("fewer than three windows");
            return {};
        }
        // Three quarters within a fifth.
        const auto common = [](const std::vector<Weight>& all) -> std::optional<double> {
            const double middle = middle_of(all);
            std::int64_t whole = 0, near = 0;
            for (const Weight& one : all) {
                whole += one.pixels;
                if (std::fabs(one.value - middle) <= middle / 5) near += one.pixels;
            }
            return near * 4 >= whole * 3 ? std::optional(middle) : std::nullopt;
        };
        if (const auto quadratic = common(shares)) {
            decide("levels grow with depth squared");
            return {0, *quadratic};
        }
        if (const auto constant = common(distances)) {
            decide("levels are evenly apart");
            return {*constant, 0};
        }
        if (const auto floats = levels_of_floats(distances, depths); floats != DepthLength{}) {
            decide("levels double at powers of two");
            return floats;
        }
        decide("levels have no rule");
        return {};
    }
    /// As of numbers of so many binary digits.
    static DepthLength levels_of_floats(const std::vector<Weight>& distances,
                                        const std::vector<Weight>& depths) {
        std::vector<Weight> digits;
        for (std::size_t k = 0; k < depths.size(); ++k)
            digits.push_back({std::floor(std::log2(depths[k].value / distances[k].value)), depths[k].pixels});
        const double usual = middle_of(digits);
        std::int64_t whole = 0, like = 0;
        std::vector<double> seen;
        for (std::size_t k = 0; k < depths.size(); ++k) {
            whole += depths[k].pixels;
            const double doublings = std::log2(distances[k].value / distances[0].value),
                         off = std::exp2(doublings - std::floor(doublings)) / 2;  // 0.5 to 1
            if (digits[k].value != usual || (off > 0.535 && off < 0.935)) continue;
            like += depths[k].pixels;
            seen.push_back(depths[k].value);
        }
        if (like * 4 < whole * 3) return {};
        const double n = *std::min_element(seen.begin(), seen.end()),
                     f = *std::max_element(seen.begin(), seen.end());
        if (n == f) return {};
        // Through the line at both ends: share (n f + z^2)/(n + f), least of it, against the line, between
        // them.
        const double share = std::exp2(-usual);
        double least = 1;
        for (int k = 0; k <= 64; ++k) {
            const double z = n + (f - n) * k / 64;
            least = std::min(least, (n * f / z + z) / (n + f));
        }
        const double wider = 2 / (1 + least);
        return {wider * share * n * f / (n + f), wider * share / (n + f)};
    }
    /// A divisor of two or more.
    static bool have_a_divisor(const std::map<int, std::int64_t>& levels) {
        for (int divisor = 2; divisor <= levels.begin()->first; ++divisor)
            if (std::all_of(levels.begin(), levels.end(),
                            [&](const auto& one) { return one.first % divisor == 0; }))
                return true;
        return false;
    }
    void add_levels(std::map<int, std::int64_t> here, std::vector<Weight>& distances,
                    std::vector<Weight>& shares, std::vector<Weight>& depths) {
        std::int64_t whole = 0;
        for (const auto& [code, pixels] : here) whole += pixels;
        const auto codes = static_cast<std::int64_t>(here.size());
        if (whole < 20 * codes) return decide("fewer than 20 pixels a code");
        std::erase_if(here, [&](const auto& one) { return one.second < whole / (20 * codes); });
        if (static_cast<std::int64_t>(here.size()) < codes) decide("stray codes");
        if (here.size() < 4) return decide("fewer than 4 levels");
        const int least = here.begin()->first, most = here.rbegin()->first;
        std::int64_t n = 0;
        for (const auto& [code, pixels] : here) n += pixels;
        const double s = most - least, met = s * static_cast<double>(n) / (s + static_cast<double>(n));
        if (coding_.kind == DepthCodingKind::metric && here.size() >= 8 && have_a_divisor(here)) {
            decide("all codes are multiples");
        } else {
            if (met < 2 * static_cast<double>(here.size())) return decide("chance meets as few codes");
            if (!is_terraced(here)) return decide("no terraces");
        }
        std::vector<Weight> gaps;
        for (auto one = here.begin(), next = std::next(one); next != here.end(); ++one, ++next)
            gaps.push_back(
                {static_cast<double>(next->first - one->first), std::min(one->second, next->second)});
        const double distance = middle_of(gaps) * std::fabs(depth(most) - depth(least)) / s;
        const double z = depth((least + most) / 2);
        distances.push_back({distance, n});
        depths.push_back({z, n});
        shares.push_back({distance / (z * z), n});
    }
    /// A seventh of the pixels of these codes have the code of their right neighbour, and of the upper one.
    bool is_terraced(const std::map<int, std::int64_t>& levels) const {
        std::int64_t right = 0, same_right = 0, above = 0, same_above = 0;
        for (const CodePicture& picture : pictures_)
            for (int y = 0; y < picture.height; ++y)
                for (int x = 0; x < picture.width; ++x) {
                    const int code = at(picture, x, y);
                    if (!levels.contains(code)) continue;
                    right += at(picture, x + 1, y) != nothing;
                    same_right += at(picture, x + 1, y) == code;
                    above += at(picture, x, y - 1) != nothing;
                    same_above += at(picture, x, y - 1) == code;
                }
        return same_right * 7 >= right && same_above * 7 >= above;
    }

    // The rest.

    void look() {
        std::int64_t pixels = 0, tiny = 0, in_the_air = 0, between = 0, clean = 0, kept = 0, dropped = 0,
                     flat_pixels = 0, changing = 0;
        for (std::size_t n = 0; n < pictures_.size(); ++n) {
            const CodePicture& picture = pictures_[n];
            const int rows = std::max(1, picture.width * picture.height / 307200);
            for (int y = 1; y < picture.height - 1; y += rows)
                for (int x = 1; x < picture.width - 1; ++x) {
                    ++pixels;
                    const int valid = valid_around(picture, x, y);
                    tiny += at(picture, x, y) == nothing && valid >= 6;
                    if (at(picture, x, y) == nothing) continue;
                    const int place = place_of(picture, x, y);
                    const Flight flight = place == edge ? this->flight(picture, x, y) : none;
                    in_the_air += flight != none;
                    between += flight == midway;
                    clean += place == edge && is_clean_edge(picture, x, y);
                    if (place == flat && valid == 8) add_bend(picture, x, y, n == 0);
                }
            if (n < 2) continue;
            const CodePicture &a = pictures_[n - 2], &b = pictures_[n - 1];
            const auto common = common_changes(a, b, picture, rows);
            for (int y = 1; y < picture.height - 1; y += rows)
                for (int x = 1; x < picture.width - 1; ++x) {
                    if (at(a, x, y) == nothing || at(picture, x, y) == nothing) continue;
                    ++kept;
                    dropped += at(b, x, y) == nothing;
                    if (at(b, x, y) == nothing) continue;
                    all_.add(*this, a, b, picture, x, y, {});
                    if (x % 8 == 0) own_.add(*this, a, b, picture, x, y, common);
                    if (place_of(b, x, y) != flat) continue;
                    ++flat_pixels;
                    changing += at(a, x, y) != at(b, x, y) || at(b, x, y) != at(picture, x, y);
                }
        }
        const auto share = [](std::int64_t part, std::int64_t whole) {
            return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
        };
        film_ = film();
        estimator_.dropouts = film_ ? share(dropped, kept) : 0;
        estimator_.changing = share(changing, flat_pixels);
        estimator_.tiny_holes = share(tiny, pixels);
        estimator_.flying = share(in_the_air, pixels);
        estimator_.midway = share(between, pixels);
        estimator_.clean_edges = share(clean, pixels);
    }
    static int valid_around(const CodePicture& picture, int x, int y) {
        int valid = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                valid += (dx != 0 || dy != 0) && at(picture, x + dx, y + dy) != nothing;
        return valid;
    }
    enum { flat, edge, rim };
    int place_of(const CodePicture& picture, int x, int y) const {
        const int code = at(picture, x, y);
        const auto [z, step] = depth_and_step(window_of(code).first);
        bool is_edge = false;
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
            const int other = at(picture, x + dx, y + dy);
            if (other == nothing) return rim;
            if (std::abs(other - code) * step > z / 20 * rounding) is_edge = true;
        }
        return is_edge ? edge : flat;
    }
    /// Step 2 of "From stored value to surface".
    enum Flight { none, flying, midway };
    Flight flight(const CodePicture& picture, int x, int y) {
        const int c = at(picture, x, y);
        const auto [z, step] = depth_and_step(window_of(c).first);
        const int gate = std::max(1, static_cast<int>(z / (50 * step)));
        Flight flight = none;
        for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
            const auto line = [&, dx = dx, dy = dy](int way) {
                std::vector<int> codes;
                for (int k = 0; k <= 12 && (codes.empty() || codes.back() != nothing); ++k)
                    codes.push_back(at(picture, x + way * k * dx, y + way * k * dy));
                if (codes.back() == nothing) codes.pop_back();
                return codes;
            };
            const auto a = line(-1), b = line(1);
            const auto end_a = surface_along(a, gate), end_b = surface_along(b, gate);
            if (end_a.first == nothing || end_b.first == nothing || end_a.second + end_b.second > 12)
                continue;
            if (std::abs(c - a[1]) <= gate && std::abs(c - b[1]) <= gate) continue;
            if ((end_a.first < c) == (end_b.first < c)) continue;
            const int from_a = std::abs(c - end_a.first), from_b = std::abs(c - end_b.first);
            if (from_a <= 2 * gate || from_b <= 2 * gate) continue;
            decide(end_a.second + end_b.second > 4 ? "flying on a ramp" : "flying");
            const bool far = 4 * std::min(from_a, from_b) >= std::abs(end_a.first - end_b.first);
            if (far) decide("midway");
            flight = std::max(flight, far ? midway : flying);
        }
        return flight;
    }
    /// The code of the surface at a line's end, and the steps to there.
    static std::pair<int, int> surface_along(const std::vector<int>& codes, int gate) {
        const int count = static_cast<int>(codes.size());
        const auto step = [&](int k) {
            return codes[static_cast<std::size_t>(k + 1)] - codes[static_cast<std::size_t>(k)];
        };
        if (count > 3 && std::abs(step(2)) <= gate) return {codes[2], std::abs(step(1)) <= gate ? 1 : 2};
        for (int end = 3; end + 1 < count; ++end) {
            bool is_ramp = std::abs(step(end)) <= gate;
            for (int k = 0; k < end; ++k)
                is_ramp = is_ramp && std::abs(step(k)) > gate && (step(k) > 0) == (step(0) > 0);
            if (is_ramp) return {codes[static_cast<std::size_t>(end)], end};
        }
        return {nothing, 0};
    }
    bool is_clean_edge(const CodePicture& picture, int x, int y) {
        const auto [z, step] = depth_and_step(window_of(at(picture, x, y)).first);
        const int gate = std::max(1, static_cast<int>(z / (50 * step)));
        for (const bool down : {false, true}) {
            int codes[4];  // before, here, and two beyond
            for (int k = 0; k < 4; ++k)
                codes[k] = at(picture, x + (down ? 0 : k - 1), y + (down ? k - 1 : 0));
            if (std::count(codes, codes + 4, nothing) > 0) continue;
            const int jump = std::abs(codes[2] - codes[1]);
            const int most = std::max(std::abs(codes[1] - codes[0]), std::abs(codes[3] - codes[2]));
            if (jump > 4 * gate && 4 * most <= jump) {
                decide("clean edge");
                return true;
            }
        }
        return false;
    }
    void add_bend(const CodePicture& picture, int x, int y, bool is_first) {
        for (const int far : {1, 2}) {
            if (far == 2 && !is_first) break;
            std::int64_t s = 0;
            bool is_whole = true;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const int code = at(picture, x + far * dx, y + far * dy);
                    is_whole = is_whole && code != nothing;
                    s += (dx == 0 ? 2 : -1) * (dy == 0 ? 2 : -1) * std::int64_t{code};
                }
            if (is_whole)
                (far == 1 ? bends_ : wide_bends_)[window_of(at(picture, x, y)).first].push_back(
                    {std::abs(s), 0, s * s});
        }
    }
    /// By the first code of a window: the median change of its pixels from a to b, and from b to c.
    using Common = std::map<int, std::pair<std::int64_t, std::int64_t>>;
    Common common_changes(const CodePicture& a, const CodePicture& b, const CodePicture& c, int rows) const {
        std::map<int, std::pair<std::vector<int>, std::vector<int>>> all;
        for (int y = 1; y < b.height - 1; y += rows)
            for (int x = 8; x < b.width - 1; x += 8) {
                if (at(a, x, y) == nothing || at(b, x, y) == nothing || at(c, x, y) == nothing) continue;
                auto& [to, from] = all[window_of(at(b, x, y)).first];
                to.push_back(at(b, x, y) - at(a, x, y));
                from.push_back(at(c, x, y) - at(b, x, y));
            }
        Common common;
        for (auto& [first, lists] : all) {
            std::ranges::sort(lists.first);
            std::ranges::sort(lists.second);
            const std::size_t middle = lists.first.size() / 2;
            common[first] = {lists.first[middle], lists.second[middle]};
        }
        return common;
    }
    struct Pair {
        double code, common, change;
    };
    struct Changes {
        std::map<int, std::vector<Sample>> of[3];
        std::vector<Pair> pairs;

        void add(const Measuring& by, const CodePicture& a, const CodePicture& b, const CodePicture& c, int x,
                 int y, const Common& common) {
            const auto change = [&](int column) {
                const auto found = common.find(by.window_of(at(b, column, y)).first);
                const auto less =
                    found == common.end() ? std::pair<std::int64_t, std::int64_t>{} : found->second;
                return std::pair<std::int64_t, std::int64_t>{
                    at(b, column, y) - at(a, column, y) - less.first,
                    at(c, column, y) - at(b, column, y) - less.second};
            };
            const auto [d, e] = change(x);
            of[by.place_of(b, x, y)][by.window_of(at(b, x, y)).first].push_back(
                {std::max(std::abs(d), std::abs(e)), d * e, (d * d + e * e) / 2});
            const int there = x + std::max(1, b.width / 16);
            if (at(a, there, y) == nothing || at(b, there, y) == nothing || at(c, there, y) == nothing)
                return;
            const auto [d2, e2] = change(there);
            pairs.push_back({static_cast<double>(at(b, x, y)), static_cast<double>(-(d * e2 + e * d2)) / 2,
                             static_cast<double>(d * d + e * e)});
        }
    };
    /// The changes that noise is computed of; null for unrelated pictures: a film's distant pixels share at
    /// most an eighth of the codes' variance.
    const Changes* film() {
        double mean = 0, variance = 0, common = 0, change = 0, own_common = 0, own_change = 0;
        const std::vector<Pair>& pairs = all_.pairs;
        for (const Pair& pair : pairs) mean += pair.code / static_cast<double>(pairs.size());
        for (const Pair& pair : pairs) {
            variance += (pair.code - mean) * (pair.code - mean);
            common += pair.common;
            change += pair.change;
        }
        for (const Pair& pair : own_.pairs) {
            own_common += pair.common;
            own_change += pair.change;
        }
        const auto size = static_cast<double>(std::max<std::size_t>(pairs.size(), 1)),
                   own_size = static_cast<double>(std::max<std::size_t>(own_.pairs.size(), 1));
        if (2 * own_change / own_size < change / size && own_change > 2 * own_size &&
            16 * own_common <= own_change) {
            decide("a common change");
            return &own_;
        }
        if (8 * common > variance) decide("unrelated pictures");
        return 8 * common <= variance ? &all_ : nullptr;
    }

    using Samples = std::map<int, std::vector<Sample>>;  // by the window's first code

    /// Their mean product and square, and how many they are; nothing where more than half is left out.
    struct Means {
        double count = 0, product = 0, square = 0;
    };
    Means clipped(const std::vector<Sample>& all, double limit) {
        Means means;
        for (int round = 0; round <= 3; ++round) {
            if (round > 0) limit = std::min(limit, std::max(1.0, 4 * std::sqrt(means.square)));
            means = {};
            for (const Sample& one : all) {
                std::int64_t low = 1;  // of what lies below the size's highest three bits
                while (one.size / low >= 8) low *= 2;
                if (static_cast<double>(one.size / low * low) > limit * rounding) continue;
                means.count += 1;
                means.product += static_cast<double>(one.product);
                means.square += static_cast<double>(one.square);
            }
            if (2 * means.count < static_cast<double>(all.size())) {
                decide("more than half is left out");
                return {};
            }
            means.product /= means.count;
            means.square /= means.count;
        }
        return means;
    }
    DepthLength noise(int place) {
        if (!film_) return {};
        const Samples& changes = film_->of[place];
        std::vector<Fit> noisy;
        double pixels = 0, pixels_of_noisy = 0;
        for (const auto& [first, samples] : changes) {
            const auto [z, step] = depth_and_step(first);
            const Means means = clipped(samples, z / 10 / step);
            if (means.count < 200) {
                decide("fewer than 200 pixels");
                continue;
            }
            pixels += means.count;
            if (-means.product <= 0.3 * means.square) {
                decide("not noisy");
                continue;
            }
            pixels_of_noisy += means.count;
            noisy.push_back({z, step * std::sqrt(-means.product), means.count});
        }
        if (noisy.empty()) return {};
        if (2 * pixels_of_noisy < pixels) {
            decide("less than half is noisy");
            return {};
        }
        return fitted(noisy);
    }
    DepthLength roughness(const Samples& bends) {
        std::vector<Fit> rough;
        for (const auto& [first, samples] : bends) {
            const auto [z, step] = depth_and_step(first);
            const Means means = clipped(samples, 6 * z / 10 / step);
            if (means.count >= 200 && means.square > 0)
                rough.push_back({z, step * std::sqrt(means.square / 36), means.count});
        }
        return fitted(rough);
    }
    /// Share of what is left that bends by a tenth of the root mean square, against depth, by the highest
    /// three bits.
    double smooth() {
        double smooth = 0, whole = 0, squares = 0;
        const auto each = [&](auto&& visit) {
            for (const auto& [first, samples] : bends_) {
                const auto [z, step] = depth_and_step(first);
                if (z == 0) continue;
                const Means means = clipped(samples, 6 * z / 10 / step);
                if (means.count >= 200) visit(samples, z / step, means);
            }
        };
        each([&](const std::vector<Sample>&, double codes, const Means& means) {
            whole += means.count;
            squares += means.count * means.square / (codes * codes);
        });
        if (squares == 0) return 0;
        const double limit = std::sqrt(squares / whole) / 10;
        each([&](const std::vector<Sample>& samples, double codes, const Means&) {
            for (const Sample& one : samples) {
                std::int64_t low = 1;
                while (one.size / low >= 8) low *= 2;
                smooth += static_cast<double>(one.size / low * low) <= limit * codes;
            }
        });
        return smooth / whole;
    }
    /// constant + quadratic z^2 by least squares of the relative error, neither negative: the best of all
    /// that may be.
    DepthLength fitted(const std::vector<Fit>& fits) {
        if (fits.empty()) return {};
        double a = 0, b = 0, c = 0, u = 0, v = 0;  // of the normal equations
        for (const Fit& fit : fits) {
            const double one = 1 / fit.length, z2 = fit.depth * fit.depth / fit.length;
            a += fit.weight * one * one;
            b += fit.weight * one * z2;
            c += fit.weight * z2 * z2;
            u += fit.weight * one;
            v += fit.weight * z2;
        }
        if (fits.size() == 1) return {u / a, 0};
        const DepthLength both{(u * c - v * b) / (a * c - b * b), (a * v - b * u) / (a * c - b * b)};
        if (both.constant < 0) decide("noise has no constant");
        if (both.quadratic < 0) decide("noise does not grow");
        if (both.constant < 0) return {0, v / c};
        if (both.quadratic < 0) return {u / a, 0};
        return both;
    }

    const DepthCoding& coding_;
    const std::vector<CodePicture>& pictures_;
    PlainEstimator estimator_;
    Samples bends_, wide_bends_;
    Changes all_, own_;
    const Changes* film_ = nullptr;
};

PlainEstimator plain_estimator(const DepthCoding& coding, const std::vector<CodePicture>& pictures) {
    return Measuring(coding, pictures).all();
}

// Measurements against the numbers of docs/conventions.md (plain_estimator), over random pictures near each
// limit; and the limits from which they indicate a camera.

/// Codes from 600 to 4000, 1 unit or about it apart, 0 being none.
DepthCoding coding_of_codes(SplitMix64& random) {
    DepthCoding coding;
    coding.semantics = DepthSemantics::planar;
    coding.near = 500;
    coding.far = 4000;
    coding.code_max = 4000;
    coding.invalid_code_count = 1;
    const auto kind = random.next() % 4;
    coding.kind = kind < 2    ? DepthCodingKind::metric
                  : kind == 2 ? DepthCodingKind::linear
                              : DepthCodingKind::inverse;
    coding.scale = kind == 0 ? 1 : 0.2;
    coding.near_is_high = random.next() % 2 == 0;
    if (coding.kind == DepthCodingKind::metric) coding.far = 4000 * coding.scale;
    if (coding.kind == DepthCodingKind::metric) coding.near = 0;
    derive_valid_range(coding);
    return coding;
}

/// Stripes that differ in depth by about as much as an edge does; each with noise, drift, outliers, waves and
/// holes of its own.
std::vector<CodePicture> any_recording(SplitMix64& random, int width, int height) {
    struct Stripe {
        int end;
        double code, noise, drift, wave, outliers, farthest, holes, dropouts;
    };
    std::vector<Stripe> stripes;
    const bool is_wide = random.next() % 2 == 0;
    const double drift = random.next() % 3 == 0 ? 0 : random.within(0, 1.2);  // times the noise
    for (int x = 0; x < width;) {
        x += static_cast<int>(is_wide ? random.within(6, 40) : random.within(1, 14));
        const double before = stripes.empty() ? random.within(700, 3000) : stripes.back().code;
        const double code = std::clamp(before * (1 + random.within(-0.12, 0.12)), 620.0, 3900.0);
        const double noise = random.next() % 4 == 0 ? random.within(0, 0.6) : random.within(0, 0.02 * code);
        stripes.push_back({x, code, noise, random.next() % 2 == 0 ? drift * noise : 0,
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.15 * code),
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.5), random.within(0, 0.4),
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.1),
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.1)});
    }
    std::vector<CodePicture> pictures(3 + random.next() % 2);
    const auto stripe_of = [&](int k) {
        return std::find_if(stripes.begin(), stripes.end(),
                            [&](const Stripe& stripe) { return k % width < stripe.end; });
    };
    std::vector<bool> hole;
    for (int k = 0; k < width * height; ++k) hole.push_back(random.unit() < stripe_of(k)->holes);
    SplitMix64 others = random;  // pictures that are no film sway, a film's gain changes
    const double sway = others.next() % 4 == 0 ? others.within(0, 0.1) : 0;
    const bool is_gain = others.next() % 2 == 0;
    for (std::size_t n = 0; n < pictures.size(); ++n) {
        const double sways = n % 2 == 0 ? 1 + sway : 1 - sway;
        pictures[n] = {width, height, {}};
        for (int k = 0; k < width * height; ++k) {
            const auto of = stripe_of(k);
            double code = of->code + of->noise * normal([&] { return random.unit(); }) +
                          of->drift * static_cast<double>(n);
            code += of->wave * random.unit() * (k % 3 == 0);
            if (random.unit() < of->outliers) code *= 1 + random.within(-of->farthest, of->farthest);
            code *= is_gain || k % width < width / 2 ? sways : 2 - sways;
            const bool none = hole[static_cast<std::size_t>(k)] || random.unit() < of->dropouts;
            pictures[n].codes.push_back(none ? CodePicture::invalid
                                             : static_cast<int>(std::clamp(code + 0.5, 1.0, 4000.0)));
        }
    }
    return pictures;
}

DepthCoding millimetre_coding(double far, double scale = 1) {
    DepthCoding coding;
    coding.semantics = DepthSemantics::planar;
    coding.kind = DepthCodingKind::metric;
    coding.scale = scale;
    coding.far = far;
    coding.code_max = 65535;
    return coding;
}

void expect_near(const DepthLength& found, const DepthLength& plain, const char* what) {
    EXPECT_NEAR(found.constant, plain.constant, 1e-9 * plain.constant) << what;
    EXPECT_NEAR(found.quadratic, plain.quadratic, 1e-9 * plain.quadratic) << what;
}

NoiseEstimator noise_of(const DepthCoding& coding, const std::vector<CodePicture>& pictures) {
    NoiseEstimator estimator(coding);
    for (const CodePicture& picture : pictures) estimator.add(picture);
    return estimator;
}

TEST(EstimatorRules, MeasureNoiseAsDocumented) {
    const int rounds = 400 / static_cast<int>(sweep_step());
    SplitMix64 random(29);
    std::map<std::string, int> decided;
    int noisy = 0, rough = 0;
    for (int round = 0; round < rounds && !testing::Test::HasFailure(); ++round) {
        SCOPED_TRACE(round);
        const DepthCoding coding = coding_of_codes(random);
        const auto pictures = any_recording(random, static_cast<int>(40 + random.next() % 60), 30);
        const PlainEstimator plain = plain_estimator(coding, pictures);
        const NoiseEstimator estimator = noise_of(coding, pictures);
        expect_near(estimator.noise(NoiseEstimator::Place::flat), plain.noise_at_flat,
                    "noise at flat places");
        expect_near(estimator.noise(NoiseEstimator::Place::edge), plain.noise_at_edges, "noise at edges");
        expect_near(estimator.noise(NoiseEstimator::Place::rim), plain.noise_at_rims, "noise at rims");
        expect_near(estimator.roughness(), plain.roughness, "roughness");
        expect_near(estimator.wide_roughness(), plain.wide_roughness, "wide roughness");
        EXPECT_EQ(estimator.smooth(), plain.smooth);
        EXPECT_EQ(estimator.changing(), plain.changing);
        EXPECT_EQ(estimator.dropouts(), plain.dropouts);
        EXPECT_EQ(estimator.tiny_holes(), plain.tiny_holes);
        EXPECT_EQ(estimator.flying(), plain.flying);
        EXPECT_EQ(estimator.midway(), plain.midway);
        EXPECT_EQ(estimator.clean_edges(), plain.clean_edges);
        for (const std::string& rule : plain.decided) ++decided[rule];
        noisy += plain.noise_at_flat != DepthLength{};
        rough += plain.roughness != DepthLength{};
    }
    EXPECT_GT(noisy, rounds * 3 / 8);
    EXPECT_GT(rough, rounds * 3 / 4);
    for (const char* rule :
         {"fewer than 200 pixels", "more than half is left out", "not noisy", "less than half is noisy",
          "noise has no constant", "noise does not grow", "flying", "flying on a ramp", "midway",
          "clean edge", "unrelated pictures", "a common change"})
        EXPECT_GT(decided[rule], rounds / 20) << rule;
}

/// 1200 pixels at 1000 mm with noise, of which `share` were 200 mm, more than a tenth, farther in the first
/// frame.
DepthLength noise_of_what_is_left(double share) {
    const int width = 42, height = 32;
    SplitMix64 random(43);
    NoiseEstimator estimator(millimetre_coding(4000));
    for (int n = 0; n < 3; ++n) {
        CodePicture picture{width, height, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const bool was_farther = n == 0 && (x - 1) + 40 * (y - 1) < share * 1200;
                picture.codes.push_back((was_farther ? 1200 : 1000) + static_cast<int>(random.next() % 9));
            }
        estimator.add(picture);
    }
    return estimator.noise(NoiseEstimator::Place::flat);
}

TEST(EstimatorRules, IgnoreMostlyClippedWindows) {
    for (const double share : {0.4, 0.5}) {
        // The standard deviation of nine even numbers is 2.58.
        EXPECT_NEAR(noise_of_what_is_left(share).constant, 2.58, 0.15) << share;
    }
    for (const double share : {0.51, 0.6}) EXPECT_EQ(noise_of_what_is_left(share), DepthLength{}) << share;
}

TEST(EstimatorRules, FindNoNoiseOnPlane) {
    NoiseEstimator estimator(millimetre_coding(4000));
    for (int n = 0; n < 3; ++n) estimator.add({40, 30, std::vector<int>(40 * 30, 1000)});
    EXPECT_EQ(estimator.noise(NoiseEstimator::Place::flat), DepthLength{});
    EXPECT_EQ(estimator.roughness(), DepthLength{});
}

// Larger pictures than 640x480 are looked at in some of their rows.
TEST(EstimatorRules, SampleRowsOfLargePictures) {
    SplitMix64 random(31);
    const DepthCoding coding = coding_of_codes(random);
    // Every row, every second, every third.
    const std::vector<int> heights = sweep_step() == 1 ? std::vector{959, 960, 1441} : std::vector{960};
    for (const int height : heights) {
        std::vector<CodePicture> pictures(3);
        for (CodePicture& picture : pictures) {
            picture = {640, height, {}};
            for (int k = 0; k < 640 * height; ++k) {
                const bool none = random.next() % 50 == 0;
                picture.codes.push_back(none ? CodePicture::invalid
                                             : static_cast<int>(1500 + random.next() % 8));
            }
        }
        const PlainEstimator plain = plain_estimator(coding, pictures);
        const NoiseEstimator estimator = noise_of(coding, pictures);
        EXPECT_EQ(estimator.tiny_holes(), plain.tiny_holes) << height;
        EXPECT_EQ(estimator.dropouts(), plain.dropouts) << height;
        expect_near(estimator.roughness(), plain.roughness, "roughness");
    }
}

/// Patches of levels; how far apart these are, how many pixels they have and how wide patches are is near to
/// what decides.
CodePicture any_levels(SplitMix64& random) {
    const int width = 60, height = 40;
    // Evenly, with depth squared, about one of these, none, as of floats.
    const auto rule = std::min<std::uint64_t>(random.next() % 7, 4);
    const double gap = random.within(3, 14), exponent = rule == 0 ? 0 : 2, wrong = rule == 2 ? 0.5 : 0.1;
    const auto digits = static_cast<double>(6 + random.next() % 3);
    std::vector<int> levels;
    const int windows = static_cast<int>(2 + random.next() % 4);
    double code = random.within(600, 1200);
    for (int n = 0; n < windows; ++n, code *= random.within(1.15, 1.4)) {
        const int count = static_cast<int>(2 + random.next() % (rule == 4 ? 19 : 7));
        double level = code;
        for (int k = 0; rule == 4 && k < count; ++k) {
            const double step = std::exp2(std::max(0.0, std::floor(std::log2(level)) - digits));
            level = step * std::floor(level / step);
            levels.push_back(static_cast<int>(level));
            level += step;
        }
        if (rule == 4) continue;
        const double off = 1 + random.within(-wrong, wrong);
        for (int k = 0; k < count; ++k) {
            levels.push_back(static_cast<int>(level));
            const double step = off * gap * std::pow(level / 1500, exponent);
            level += rule == 3 ? random.within(1, 30) : std::max(1.0, step);
        }
    }
    const bool is_near = random.next() % 2 == 0;  // to a seventh
    const double wide = random.within(is_near ? 0.05 : 0, is_near ? 0.2 : 0.5);
    const double tall = random.within(is_near ? 0.05 : 0, is_near ? 0.2 : 0.5);
    const double strays = random.next() % 2 == 0 ? 0 : random.within(0, 0.05);
    const double shown = random.within(0.02, 1);  // the rest is none
    CodePicture picture{width, height, std::vector<int>(static_cast<std::size_t>(width * height), 0)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            int& here = picture.codes[static_cast<std::size_t>(y * width + x)];
            if (x > 0 && random.unit() < wide) {
                here = *(&here - 1);
            } else if (y > 0 && random.unit() < tall) {
                here = *(&here - width);
            } else {
                here = levels[random.next() % levels.size()];
                if (random.unit() < strays) here += static_cast<int>(random.next() % 40);
                if (random.unit() > shown) here = CodePicture::invalid;
            }
        }
    return picture;
}

TEST(EstimatorRules, MeasureLevelsAsDocumented) {
    const int rounds = 1600 / static_cast<int>(sweep_step());
    SplitMix64 random(37);
    std::map<std::string, int> decided;
    for (int round = 0; round < rounds && !testing::Test::HasFailure(); ++round) {
        SCOPED_TRACE(round);
        const double scale = round % 2 == 0 ? 1 : 0.2;
        const DepthCoding coding = millimetre_coding(scale * random.within(800, 4000), scale);
        const CodePicture picture = any_levels(random);
        const PlainEstimator plain = plain_estimator(coding, {picture});
        LevelEstimator estimator(coding);
        estimator.add(picture);
        expect_near(estimator.levels(), plain.levels, "levels");
        EXPECT_EQ(estimator.depth_of_share(50).value_or(0), plain.median_depth);
        for (const std::string& rule : plain.decided) ++decided[rule];
    }
    for (const char* rule :
         {"fewer than 20 pixels a code", "stray codes", "fewer than 4 levels", "chance meets as few codes",
          "no terraces", "fewer than three windows", "levels grow with depth squared",
          "levels are evenly apart", "all codes are multiples", "levels double at powers of two",
          "levels have no rule"})
        EXPECT_GT(decided[rule], sweep_step() == 1 ? 50 : 5) << rule;
}

// A background is at the far plane from 0.999 of it on.
TEST(EstimatorRules, ExcludeFarPlaneFromMedian) {
    for (const auto& [background, median] : {std::pair{9989, 9989}, {9990, 500}, {10'000, 500}}) {
        CodePicture picture{10, 10, std::vector<int>(100, background)};
        for (std::size_t k = 0; k < 20; ++k) picture.codes[k] = 500;
        LevelEstimator estimator(millimetre_coding(10'000));
        estimator.add(picture);
        EXPECT_EQ(*estimator.depth_of_share(50), median) << background;
    }
}

TEST(EstimatorRules, RecogniseCamerasByThresholds) {
    const auto is_camera = [](auto change) {
        MeasuredDepth measured;
        change(measured);
        return measured.from_a_camera();
    };
    EXPECT_FALSE(is_camera([](MeasuredDepth&) {}));
    EXPECT_FALSE(is_camera([](MeasuredDepth& of) { of.dropouts = 0.000499; }));
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.dropouts = 0.0005; }));
    EXPECT_FALSE(is_camera([](MeasuredDepth& of) { of.tiny_holes = 0.0000999; }));
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.tiny_holes = 0.0001; }));
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.levels.quadratic = 1e-9; }));
    EXPECT_FALSE(is_camera([](MeasuredDepth& of) { of.levels.constant = 5; })) << "a converter's rounding";
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.noise.constant = 1e-9; }));
}

TEST(EstimatorRules, RecogniseNoiseByThresholds) {
    const auto is_rough = [](auto change) {
        MeasuredDepth measured;
        measured.pixel = 10;
        measured.distance = 1;
        measured.roughness = measured.wide_roughness = 0.6;
        change(measured);
        return measured.is_rough();
    };
    EXPECT_TRUE(is_rough([](MeasuredDepth&) {}));
    EXPECT_FALSE(is_rough([](MeasuredDepth& of) { of.pixel = 12.1; })) << "a twentieth";
    EXPECT_TRUE(is_rough([](MeasuredDepth& of) { of.distance = 1.49; }));
    EXPECT_FALSE(is_rough([](MeasuredDepth& of) { of.distance = 1.51; })) << "as rough as rounding";
    EXPECT_TRUE(is_rough([](MeasuredDepth& of) { of.wide_roughness = 4.49 * 0.6; }));
    EXPECT_FALSE(is_rough([](MeasuredDepth& of) { of.wide_roughness = 4.51 * 0.6; })) << "it has a shape";
    EXPECT_TRUE(is_rough([](MeasuredDepth& of) { of.smooth = 0.3; }));
    EXPECT_FALSE(is_rough([](MeasuredDepth& of) { of.smooth = 0.301; }));
    for (const auto& [frames, changing, rough] :
         {std::tuple{2, 0.0, true}, {3, 0.0, false}, {3, 0.049, false}, {3, 0.05, true}})
        EXPECT_EQ(is_rough([&, frames = frames, changing = changing](MeasuredDepth& of) {
                      of.frames = frames;
                      of.changing = changing;
                  }),
                  rough)
            << frames << ", " << changing;
}

// Frames 0 to 15, or 0 to 3 where these show nothing of a camera.
TEST(EstimatorRules, LimitMeasuredFrames) {
    for (const bool is_camera : {false, true}) {
        Scene scene = depth_scene(64, 48, 16, Marking::zero);
        DepthEstimator estimator(scene);
        SplitMix64 random(5);
        int frames = 0;
        for (; !estimator.enough(); ++frames) {
            ASSERT_LT(frames, 100);
            std::vector<std::uint16_t> codes;
            for (int k = 0; k < 64 * 48; ++k)
                codes.push_back(static_cast<std::uint16_t>(1000 + (is_camera ? random.next() % 8 : 0)));
            estimator.add(store_plane(64, 48, codes, {}).frame());
        }
        EXPECT_EQ(frames, is_camera ? 16 : 4);
        EXPECT_EQ(estimator.measured()->frames, frames);
    }
}

}  // namespace
}  // namespace touchable::test
