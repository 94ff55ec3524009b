#include "engine/clip/line_fit.hpp"

#include <algorithm>
#include <cstdint>

namespace touchable {
namespace {

constexpr std::size_t fewest_points = 8, judging_points = 256;
constexpr int trials = 96, refinements = 6;
constexpr double per_median = 1.4826;  // standard deviation of normal noise / median distance
constexpr double most_scale = 16;      // and its reciprocal the least
constexpr double least_spread = 16;    // of `from`, times the noise: nearer together no scale can be told

double size(double number) {
    return number < 0 ? -number : number;
}

/// The middle one, the lower of two; `numbers` come in another order.
double median_of(std::vector<double>& numbers) {
    const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>((numbers.size() - 1) / 2);
    std::nth_element(numbers.begin(), middle, numbers.end());
    return *middle;
}

/// Numbers that are the same on every machine.
class Draw {
public:
    std::size_t below(std::size_t count) {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;
        return static_cast<std::size_t>((state_ >> 33) % count);
    }

private:
    std::uint64_t state_ = 88172645463325252U;
};

class Fit {
public:
    Fit(const std::vector<LinePoint>& points, double least_noise)
        : points_(points), least_noise_(least_noise) {
        std::vector<double> from;
        from.reserve(points.size());
        for (const LinePoint& point : points) from.push_back(point.from);
        const auto at = [&](std::size_t k) {
            std::nth_element(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(k), from.end());
            return from[k];
        };
        spread_ = at(from.size() - 1 - from.size() / 10) - at(from.size() / 10);
    }
    LineFit make() {
        LineFit fit;
        fit.line = has_scale() ? by_pairs() : shifted({});
        for (int k = 0; k < refinements; ++k) {
            fit.noise = noise_of(fit.line);
            fit.line = refined(fit.line, fit.noise);
        }
        fit.noise = noise_of(fit.line);
        return fit;
    }

private:
    static double distance(const Line& line, const LinePoint& point) {
        return size(point.to - line.at(point.from));
    }
    bool has_scale() const { return spread_ > least_spread * least_noise_; }
    double noise_of(const Line& line) const {
        std::vector<double> distances;
        distances.reserve(points_.size());
        for (const LinePoint& point : points_) distances.push_back(distance(line, point));
        return std::max(least_noise_, per_median * median_of(distances));
    }
    /// Of this scale.
    Line shifted(Line line) const {
        std::vector<double> shifts;
        shifts.reserve(points_.size());
        for (const LinePoint& point : points_) shifts.push_back(point.to - line.scale * point.from);
        line.shift = median_of(shifts);
        return line;
    }
    /// That to which half of the points lie nearest.
    Line by_pairs() const {
        Draw draw;
        const std::size_t step = std::max<std::size_t>(1, points_.size() / judging_points);
        Line best = shifted({});
        double least = -1;
        std::vector<double> distances;
        for (int trial = 0, tried = 0; trial < trials && tried < 8 * trials; ++tried) {
            const LinePoint &a = points_[draw.below(points_.size())],
                            &b = points_[draw.below(points_.size())];
            if (size(a.from - b.from) < spread_ / 4) continue;
            ++trial;
            Line line;
            line.scale = (a.to - b.to) / (a.from - b.from);
            if (!(line.scale >= 1 / most_scale && line.scale <= most_scale)) continue;
            line.shift = a.to - line.scale * a.from;
            distances.clear();
            for (std::size_t k = 0; k < points_.size(); k += step)
                distances.push_back(distance(line, points_[k]));
            const double middle = median_of(distances);
            if (least >= 0 && middle >= least) continue;
            least = middle;
            best = line;
        }
        return best;
    }
    /// Weighted by 1/(1 + (distance / two noises)^2)^2: what is far away does not count.
    Line refined(const Line& line, double noise) const {
        double weights = 0, from = 0, to = 0;
        std::vector<double> each;
        each.reserve(points_.size());
        for (const LinePoint& point : points_) {
            const double share = distance(line, point) / (2 * noise), fall = 1 + share * share;
            const double weight = 1 / (fall * fall);
            each.push_back(weight);
            weights += weight;
            from += weight * point.from;
            to += weight * point.to;
        }
        if (!has_scale()) return {1, (to - from) / weights};
        const double middle = from / weights, height = to / weights;
        double together = 0, alone = 0;
        for (std::size_t k = 0; k < points_.size(); ++k) {
            const double x = points_[k].from - middle;
            together += each[k] * x * (points_[k].to - height);
            alone += each[k] * x * x;
        }
        const double scale = together / alone;
        if (!(scale >= 1 / most_scale && scale <= most_scale)) return line;
        return {scale, height - scale * middle};
    }

    const std::vector<LinePoint>& points_;
    double least_noise_, spread_ = 0;
};

}  // namespace

std::optional<LineFit> fit_line(const std::vector<LinePoint>& points, double least_noise) {
    if (points.size() < fewest_points) return std::nullopt;
    return Fit(points, least_noise).make();
}

}  // namespace touchable
