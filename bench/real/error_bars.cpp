// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include "bench/real/known_room.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr double scale_of_rooms = 0.5;
constexpr double wanted = 0.95;

using Weights = std::array<double, 4>;

/// Errors of one camera, and what its bars are made of.
struct Errors {
    std::vector<Weights> squares;
    std::vector<double> errors;

    double bar(std::size_t k, const Weights& weights) const {
        return std::sqrt(std::inner_product(weights.begin(), weights.end(), squares[k].begin(), 0.0));
    }
    double share_within(const Weights& weights) const {
        std::size_t within = 0;
        for (std::size_t k = 0; k < errors.size(); ++k) within += errors[k] <= bar(k, weights);
        return static_cast<double>(within) / static_cast<double>(errors.size());
    }
};

Weights scaled_weights(Weights weights, double factor) {
    for (double& weight : weights) weight *= factor;
    return weights;
}

/// Weights by which `wanted` of the errors of these cameras, on average, lie within their bars: the quantile
/// of log(error) by gradient descent on a smooth pinball loss (Koenker and Bassett 1978; Adam, Kingma and Ba
/// 2015), on every n-th place, then scaled.
Weights fitted(const std::vector<const Errors*>& cameras) {
    constexpr std::size_t of_each = 300;
    constexpr int steps = 500;
    constexpr double smooth = 0.15, rate = 0.05;
    std::vector<Weights> squares;
    std::vector<double> logs;
    for (const Errors* const camera : cameras) {
        const std::size_t step = std::max<std::size_t>(1, camera->errors.size() / of_each);
        for (std::size_t k = 0; k < camera->errors.size(); k += step) {
            squares.push_back(camera->squares[k]);
            logs.push_back(std::log(camera->errors[k] + 1e-3));
        }
    }
    Weights log_weights, first{}, second{};
    const auto count = static_cast<double>(logs.size());
    const double start = std::exp(2 * std::accumulate(logs.begin(), logs.end(), 0.0) / count);
    for (std::size_t n = 0; n < log_weights.size(); ++n) {
        double mean = 0;
        for (const Weights& each : squares) mean += each[n] / count;
        log_weights[n] = std::log(start / std::max(mean, 1e-9) + 1e-9);
    }
    Weights weights{};
    for (int step = 0; step < steps; ++step) {
        for (std::size_t n = 0; n < weights.size(); ++n) weights[n] = std::exp(log_weights[n]);
        Weights slopes{};
        for (std::size_t k = 0; k < squares.size(); ++k) {
            const double square =
                std::inner_product(weights.begin(), weights.end(), squares[k].begin(), 1e-12);
            const double over = logs[k] - 0.5 * std::log(square);
            const double slope = 1 / (1 + std::exp(-over / smooth)) - (1 - wanted);
            for (std::size_t n = 0; n < weights.size(); ++n)
                slopes[n] -= slope * 0.5 * weights[n] * squares[k][n] / square / count;
        }
        for (std::size_t n = 0; n < weights.size(); ++n) {
            first[n] = 0.9 * first[n] + 0.1 * slopes[n];
            second[n] = 0.99 * second[n] + 0.01 * slopes[n] * slopes[n];
            log_weights[n] -=
                rate * (1 - static_cast<double>(step) / steps) * first[n] / std::sqrt(second[n] + 1e-12);
        }
    }
    double low = 0.1, high = 4;
    while (high - low > 1e-4) {
        const double middle = 0.5 * (low + high);
        double within = 0;
        for (const Errors* const camera : cameras)
            within += camera->share_within(scaled_weights(weights, middle));
        (within < wanted * static_cast<double>(cameras.size()) ? low : high) = middle;
    }
    return scaled_weights(weights, high);
}

std::vector<double> ranks(const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t k) { return values[k]; });
    std::vector<double> out(values.size());
    for (std::size_t rank = 0; rank < order.size(); ++rank) out[order[rank]] = static_cast<double>(rank);
    return out;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const double mean = 0.5 * static_cast<double>(a.size() - 1);
    double both = 0, alone = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        both += (a[k] - mean) * (b[k] - mean);
        alone += (a[k] - mean) * (a[k] - mean);
    }
    return both / alone;
}

/// What share of cameras has how many of its errors within their bars.
struct Right {
    int right = 0;
    double least = 1;
    void add(double share) {
        right += share >= 0.92 && share <= 0.98;
        least = std::min(least, share);
    }
    void report(const std::string& begin, std::size_t cameras, Figures& figures) const {
        figures.push_back({begin + "right_pct", 100.0 * right / static_cast<double>(cameras), "%"});
        figures.push_back({begin + "least_pct", 100 * least, "%"});
    }
};

void judge(const std::string& what, const std::vector<Errors>& cameras, const Weights& weights, bool fits,
           Figures& figures) {
    Right shipped, anew;
    double width = 0, rank = 0;
    for (const Errors& camera : cameras) {
        shipped.add(camera.share_within(weights));
        std::vector<double> bars, errors = camera.errors;
        for (std::size_t k = 0; k < errors.size(); ++k) bars.push_back(camera.bar(k, weights));
        rank += correlation(ranks(bars), ranks(errors));
        const double mean = std::accumulate(bars.begin(), bars.end(), 0.0) / static_cast<double>(bars.size());
        width += mean / sorted_element(errors,
                                       static_cast<std::size_t>(wanted * static_cast<double>(errors.size())));
    }
    const auto count = static_cast<double>(cameras.size());
    shipped.report(what, cameras.size(), figures);
    figures.push_back({what + "width", width / count, ""});
    figures.push_back({what + "rank", rank / count, ""});
    if (!fits) return;
    for (const Errors& left_out : cameras) {
        std::vector<const Errors*> others;
        for (const Errors& camera : cameras)
            if (&camera != &left_out) others.push_back(&camera);
        anew.add(left_out.share_within(fitted(others)));
    }
    anew.report(what + "fit_", cameras.size(), figures);
    std::vector<const Errors*> all;
    for (const Errors& camera : cameras) all.push_back(&camera);
    const Weights best = fitted(all);
    for (std::size_t n = 0; n < best.size(); ++n)
        figures.push_back({what + "weight_" + std::to_string(n + 1), best[n], ""});
}

}  // namespace

Result<void> measure_error_bars(const std::filesystem::path& data, const std::vector<SensorModel>& models,
                                bool quick, Figures& figures) {
    struct Sides {
        std::vector<Errors> direction, size;
    };
    Sides film, still;
    for (const SensorModel& model : models) {
        KnownRoom rooms(data, model, scale_of_rooms);
        for (Sides* const sides : {&film, &still}) {
            TRY_ASSIGN(const auto places, rooms.press_with_bars(sides == &still, quick));
            Errors& degrees = sides->direction.emplace_back();
            Errors& depths = sides->size.emplace_back();
            for (const BarPlace& place : places) {
                degrees.squares.push_back(place.signs.angle);
                degrees.errors.push_back(place.degrees);
                depths.squares.push_back(place.signs.depth);
                depths.errors.push_back(place.depth);
            }
        }
    }
    judge("direction_", film.direction, ErrorSigns::weights.angle, true, figures);
    judge("size_", film.size, ErrorSigns::weights.depth, true, figures);
    judge("still_direction_", still.direction, ErrorSigns::weights.angle, false, figures);
    judge("still_size_", still.size, ErrorSigns::weights.depth, false, figures);
    return {};
}

}  // namespace touchable
