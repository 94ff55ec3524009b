#include "bench/touch/force_spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/content/seeded_noise.hpp"

namespace touchable {
namespace {

constexpr double rate = 1000;  // Hz
constexpr std::size_t segment = 10'000;

std::vector<double> sine_wave(double amplitude, double hz, double offset, std::size_t count) {
    std::vector<double> series;
    for (std::size_t n = 0; n < count; ++n)
        series.push_back(
            offset + amplitude * std::sin(2 * std::numbers::pi * hz * static_cast<double>(n) / rate + 0.4));
    return series;
}

/// Uniform in -1 to 1: variance 1/3.
std::vector<double> white_noise(std::size_t count) {
    SplitMix64 random(7);
    std::vector<double> series;
    for (std::size_t n = 0; n < count; ++n) series.push_back(random.within(-1, 1));
    return series;
}

TEST(ForceSpectrum, HasASineInItsBandWithItsPower) {
    const std::vector<double> series = sine_wave(3, 50, 12, segment);
    EXPECT_NEAR(band_power(series, rate, 49, 51), 4.5, 1e-9);
    EXPECT_NEAR(band_power(series, rate, 20, 500), 4.5, 1e-9);
    EXPECT_NEAR(band_power(series, rate, 0, 49), 0, 1e-12);
    EXPECT_NEAR(band_power(series, rate, 51, 500), 0, 1e-12);
}

TEST(ForceSpectrum, HasASineBetweenTwoWavesToo) {
    const std::vector<double> series = sine_wave(3, 50.037, 0, segment);
    EXPECT_NEAR(band_power(series, rate, 49, 51), 4.5, 1e-3);
    EXPECT_LT(band_power(series, rate, 60, 500), 1e-6);
}

TEST(ForceSpectrum, IsFlatOfWhiteNoise) {
    const Spectrum spectrum = welch_spectrum(white_noise(10 * segment), rate, 10);
    ASSERT_EQ(spectrum.power.size(), segment / 2 + 1);
    EXPECT_DOUBLE_EQ(spectrum.hz_step, 0.1);
    const double density = 1.0 / 3 / (rate / 2);
    // Of n independent waves the mean strays by 1/sqrt(n); a window of Hann's leaves two in three, ten times.
    for (double from = 15.625; from < 500; from *= 2) {
        const double waves = 10 * from / spectrum.hz_step * 2 / 3;
        EXPECT_NEAR(spectrum.between(from, 2 * from) / (density * from), 1, 4 / std::sqrt(waves)) << from;
    }
}

TEST(ForceSpectrum, BandsSideBySideHoldAllOfIt) {
    const Spectrum spectrum = welch_spectrum(white_noise(999), rate, 1);
    double sum = 0;
    for (const double power : spectrum.power) sum += power;
    const double parts =
        spectrum.between(0, 31.25) + spectrum.between(31.25, 250) + spectrum.between(250, 500);
    EXPECT_GT(sum, 0.2);
    EXPECT_NEAR(parts, sum, 1e-12);
}

TEST(ForceSpectrum, IsThatOfASlowTransformWhateverTheLength) {
    using std::numbers::pi_v;
    for (const std::size_t count : {2U, 7U, 30U, 48U, 121U}) {
        const std::vector<double> series = white_noise(count);
        const Spectrum spectrum = welch_spectrum(series, rate, 1);
        long double mean = 0, window_power = 0;
        for (const double value : series) mean += value / static_cast<long double>(count);
        std::vector<long double> windowed;
        for (std::size_t n = 0; n < count; ++n) {
            const long double half =
                std::sin(pi_v<long double> * static_cast<long double>(n) / static_cast<long double>(count));
            windowed.push_back(half * half * (series[n] - mean));
            window_power += half * half * half * half;
        }
        ASSERT_EQ(spectrum.power.size(), count / 2 + 1);
        for (std::size_t k = 0; k < spectrum.power.size(); ++k) {
            long double in = 0, out = 0;
            for (std::size_t n = 0; n < count; ++n) {
                const long double angle = 2 * pi_v<long double> * static_cast<long double>(k * n % count) /
                                          static_cast<long double>(count);
                in += windowed[n] * std::cos(angle);
                out += windowed[n] * std::sin(angle);
            }
            const long double twice = k == 0 || 2 * k == count ? 1 : 2;
            const auto expected = static_cast<double>(twice * (in * in + out * out) /
                                                      (static_cast<long double>(count) * window_power));
            EXPECT_NEAR(spectrum.power[k], expected, 1e-13) << count << ", wave " << k;
        }
    }
}

TEST(ForceSpectrum, OfSegmentsIsTheirMean) {
    std::vector<double> series = sine_wave(2, 100, 5, 1000);
    const std::vector<double> louder = sine_wave(4, 100, -5, 1000);
    series.insert(series.end(), louder.begin(), louder.end());
    EXPECT_NEAR(welch_spectrum(series, rate, 2).between(95, 105), (2 + 8) / 2.0, 1e-9);
}

}  // namespace
}  // namespace touchable
