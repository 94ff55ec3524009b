// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/force_spectrum.hpp"

#include <cassert>
#include <complex>
#include <cstddef>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

using Complex = std::complex<double>;

std::size_t least_prime_factor(std::size_t number) {
    for (std::size_t factor = 2; factor * factor <= number; ++factor)
        if (number % factor == 0) return factor;
    return number;
}

/// The discrete Fourier transform of a series of any length, by Cooley and Tukey (1965): one of p m values is
/// split into p of m values each.
class FourierTransform {
public:
    explicit FourierTransform(std::size_t count) {
        for (std::size_t n = 0; n < count; ++n) {
            const double angle = -2 * pi * static_cast<double>(n) / static_cast<double>(count);
            roots_.emplace_back(cosine(angle), sine(angle));
        }
    }
    std::vector<Complex> of(const std::vector<double>& series) const {
        std::vector<Complex> waves(series.size());
        transform(series.data(), series.size(), 1, waves.data());
        return waves;
    }

private:
    /// Transforms `count` values, every `stride`-th; count x stride is the total length.
    void transform(const double* values, std::size_t count, std::size_t stride, Complex* waves) const {
        if (count == 1) {
            *waves = *values;
            return;
        }
        const std::size_t parts = least_prime_factor(count), size = count / parts;
        for (std::size_t part = 0; part < parts; ++part)
            transform(values + part * stride, size, stride * parts, waves + part * size);
        std::vector<Complex> column(parts);
        for (std::size_t k = 0; k < size; ++k) {
            for (std::size_t part = 0; part < parts; ++part) column[part] = waves[part * size + k];
            for (std::size_t wave = k; wave < count; wave += size) {
                Complex sum = 0;
                for (std::size_t part = 0; part < parts; ++part)
                    sum += column[part] * roots_[part * wave % count * stride];
                waves[wave] = sum;
            }
        }
    }

    std::vector<Complex> roots_;
};

std::vector<double> hann_window(std::size_t count) {
    std::vector<double> window;
    for (std::size_t n = 0; n < count; ++n)
        window.push_back(0.5 - 0.5 * cosine(2 * pi * static_cast<double>(n) / static_cast<double>(count)));
    return window;
}

std::vector<double> without_mean(const double* begin, const double* end) {
    double mean = 0;
    for (const double* value = begin; value != end; ++value)
        mean += *value / static_cast<double>(end - begin);
    std::vector<double> rest;
    for (const double* value = begin; value != end; ++value) rest.push_back(*value - mean);
    return rest;
}

}  // namespace

double Spectrum::between(double from_hz, double to_hz) const {
    double sum = 0;
    for (std::size_t wave = 0; wave < power.size(); ++wave) {
        const double hz = static_cast<double>(wave) * hz_step;
        const bool last = wave + 1 == power.size();
        if (hz >= from_hz && (hz < to_hz || (last && hz == to_hz))) sum += power[wave];
    }
    return sum;
}

Spectrum welch_spectrum(const std::vector<double>& series, double tick_hz, int segments) {
    const std::size_t count = series.size() / static_cast<std::size_t>(segments);
    assert(segments >= 1 && count >= 2);
    const FourierTransform fourier(count);
    const std::vector<double> window = hann_window(count);
    double window_power = 0;
    for (const double weight : window) window_power += weight * weight;
    Spectrum spectrum{tick_hz / static_cast<double>(count), std::vector<double>(count / 2 + 1)};
    for (int segment = 0; segment < segments; ++segment) {
        const double* const begin = series.data() + static_cast<std::size_t>(segment) * count;
        std::vector<double> windowed = without_mean(begin, begin + count);
        for (std::size_t n = 0; n < count; ++n) windowed[n] *= window[n];
        const std::vector<Complex> waves = fourier.of(windowed);
        // Parseval: the squares of all waves, over their number, are the squares of the values. All waves
        // except the first and the last occur twice.
        for (std::size_t k = 0; k < spectrum.power.size(); ++k) {
            const double twice = k == 0 || 2 * k == count ? 1 : 2;
            spectrum.power[k] +=
                twice * std::norm(waves[k]) / (static_cast<double>(count) * window_power * segments);
        }
    }
    return spectrum;
}

double band_power(const std::vector<double>& series, double tick_hz, double from_hz, double to_hz) {
    return welch_spectrum(series, tick_hz, 1).between(from_hz, to_hz);
}

}  // namespace touchable
