// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace touchable {

/// Power over frequency, one-sided: wave k (k hz_step Hz) contributes power[k] to the mean square of a
/// series, from 0 to half the sampling rate. power[k] / hz_step is the power spectral density.
struct Spectrum {
    double hz_step = 0;
    std::vector<double> power;  ///< in the series' unit squared

    /// Mean square of the waves from `from_hz` to below `to_hz`; includes the last if `to_hz` is half the
    /// rate.
    double between(double from_hz, double to_hz) const;
};

/// Welch's estimate as in the paper's Fig. 19: the mean of the periodograms of `segments` consecutive
/// segments (1 or more), each without its mean and with a Hann window. A remainder at the series' end is not
/// used; a segment has at least two values. Any length is allowed; one with a large prime factor is slow. The
/// same bits on every machine.
Spectrum welch_spectrum(const std::vector<double>& series, double tick_hz, int segments);

/// Mean square of a series in a band, with one segment (`Spectrum::between`).
double band_power(const std::vector<double>& series, double tick_hz, double from_hz, double to_hz);

}  // namespace touchable
