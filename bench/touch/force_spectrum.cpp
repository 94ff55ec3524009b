#include "bench/touch/force_spectrum.hpp"

#include <algorithm>

#include "engine/trigonometry.hpp"

namespace touchable {
namespace {

/// One turn in as many steps as a series has samples: a wave reads it round and round.
struct Turn {
    std::vector<double> cosines, sines;

    explicit Turn(std::size_t steps) {
        for (std::size_t n = 0; n < steps; ++n) {
            const double turns = static_cast<double>(n) / static_cast<double>(steps);
            cosines.push_back(cosine(2 * pi * turns));
            sines.push_back(sine(2 * pi * turns));
        }
    }
};

/// Sum of squares of the wave that has so many periods in the series (Parseval), the mirrored one with it.
double wave_power(const std::vector<double>& series, const Turn& turn, std::size_t wave) {
    double in = 0, out = 0;
    std::size_t at = 0;
    for (const double value : series) {
        in += value * turn.cosines[at];
        out += value * turn.sines[at];
        at = (at + wave) % series.size();
    }
    return (wave == 0 ? 1.0 : 2.0) * (in * in + out * out) / static_cast<double>(series.size());
}

}  // namespace

double band_power(const std::vector<double>& series, double tick_hz, double from_hz, double to_hz) {
    if (series.empty()) return 0;
    const auto count = static_cast<double>(series.size());
    double mean = 0;
    for (const double value : series) mean += value / count;
    const Turn turn(series.size());
    std::vector<double> windowed;
    double window_power = 0, all = 0;
    for (std::size_t n = 0; n < series.size(); ++n) {
        const double window = 0.5 - 0.5 * turn.cosines[n];
        window_power += window * window;
        windowed.push_back(window * (series[n] - mean));
        all += windowed[n] * windowed[n];
    }
    const auto hz = [&](std::size_t wave) { return static_cast<double>(wave) * tick_hz / count; };
    double power = 0;
    if (to_hz >= tick_hz / 2) {  // all, less what is slower: there are fewer of those
        power = all;
        for (std::size_t wave = 0; hz(wave) < from_hz; ++wave) power -= wave_power(windowed, turn, wave);
    } else {
        for (std::size_t wave = 0; hz(wave) < to_hz; ++wave)
            if (hz(wave) >= from_hz) power += wave_power(windowed, turn, wave);
    }
    return std::max(power, 0.0) / window_power;
}

}  // namespace touchable
