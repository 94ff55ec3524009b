#include "tests/surface/plain_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

namespace touchable::test {
namespace {

constexpr int nothing = CodePicture::invalid;
/// What is at a limit is within it, whatever rounding says.
constexpr double rounding = 1 + 1e-12;

/// What a measure is made of, of one window: sizes in codes, and what is averaged.
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
        estimator_.noise_at_flat = noise(changes_[0]);
        estimator_.noise_at_edges = noise(changes_[1]);
        estimator_.noise_at_rims = noise(changes_[2]);
        estimator_.roughness = roughness();
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
    /// Of two or more.
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
        std::int64_t pixels = 0, tiny = 0, in_the_air = 0, between = 0, clean = 0, kept = 0, dropped = 0;
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
                    if (place == flat && valid == 8) add_bend(picture, x, y);
                }
            if (n < 2) continue;
            const CodePicture &a = pictures_[n - 2], &b = pictures_[n - 1];
            for (int y = 1; y < picture.height - 1; y += rows)
                for (int x = 1; x < picture.width - 1; ++x) {
                    if (at(a, x, y) == nothing || at(picture, x, y) == nothing) continue;
                    ++kept;
                    dropped += at(b, x, y) == nothing;
                    if (at(b, x, y) != nothing) add_change(a, b, picture, x, y);
                }
        }
        const auto share = [](std::int64_t part, std::int64_t whole) {
            return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
        };
        is_film_ = is_film();
        estimator_.dropouts = is_film_ ? share(dropped, kept) : 0;
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
    /// Of codes along a line: that of the surface at its end, and the steps to there.
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
    void add_bend(const CodePicture& picture, int x, int y) {
        std::int64_t s = 4 * at(picture, x, y);
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
            s -= 2 * at(picture, x + dx, y + dy);
        for (const auto& [dx, dy] : {std::pair{-1, -1}, {1, -1}, {-1, 1}, {1, 1}})
            s += at(picture, x + dx, y + dy);
        bends_[window_of(at(picture, x, y)).first].push_back({std::abs(s), 0, s * s});
    }
    void add_change(const CodePicture& a, const CodePicture& b, const CodePicture& c, int x, int y) {
        const std::int64_t d = at(b, x, y) - at(a, x, y), e = at(c, x, y) - at(b, x, y);
        changes_[place_of(b, x, y)][window_of(at(b, x, y)).first].push_back(
            {std::max(std::abs(d), std::abs(e)), d * e, (d * d + e * e) / 2});
        const int there = x + std::max(1, b.width / 16);
        if (at(a, there, y) == nothing || at(b, there, y) == nothing || at(c, there, y) == nothing) return;
        const std::int64_t d2 = at(b, there, y) - at(a, there, y), e2 = at(c, there, y) - at(b, there, y);
        pairs_.push_back({static_cast<double>(at(b, x, y)), static_cast<double>(-(d * e2 + e * d2)) / 2});
    }
    /// What a pixel and one far away have in common is no more than an eighth of the codes' variance.
    struct Pair {
        double code, common;
    };
    bool is_film() {
        double mean = 0, variance = 0, common = 0;
        for (const Pair& pair : pairs_) mean += pair.code / static_cast<double>(pairs_.size());
        for (const Pair& pair : pairs_) {
            variance += (pair.code - mean) * (pair.code - mean);
            common += pair.common;
        }
        if (8 * common > variance) decide("unrelated pictures");
        return 8 * common <= variance;
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
    DepthLength noise(const Samples& changes) {
        if (!is_film_) return {};
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
    DepthLength roughness() {
        std::vector<Fit> rough;
        for (const auto& [first, samples] : bends_) {
            const auto [z, step] = depth_and_step(first);
            const Means means = clipped(samples, 6 * z / 10 / step);
            if (means.count >= 200 && means.square > 0)
                rough.push_back({z, step * std::sqrt(means.square / 36), means.count});
        }
        return fitted(rough);
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
    Samples changes_[3], bends_;
    std::vector<Pair> pairs_;
    bool is_film_ = true;
};

}  // namespace

PlainEstimator plain_estimator(const DepthCoding& coding, const std::vector<CodePicture>& pictures) {
    return Measuring(coding, pictures).all();
}

}  // namespace touchable::test
