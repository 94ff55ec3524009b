#pragma once

#include "bench/paper/paper_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The paper's second experiment (Fig. 19): a hand scratches the chest softly, and the force is recorded for
/// ten segments of 10 s. The hand is a scripted one that holds the device and yields (HeldHandle).
struct ScratchRun {
    TouchCase setup;
    PaperFilter filter;
};

/// Bands of one octave whose powers are reported, Hz: first, and how many.
inline constexpr double first_octave_hz = 7.8125;
inline constexpr int octaves = 6;

/// Appends force_band_mn (20 to 500 Hz), force_band_mn_<from>_<to> of each octave, mean and largest force,
/// the share of ticks in contact, and for plots force_psd_<hz>hz. An error where a force is not k S (P - G),
/// a proxy is behind the surface, or less than half of the ticks are in contact.
Result<void> measure_scratch(std::shared_ptr<const PaperClip> clip, const ScratchRun& run, Figures& figures);

}  // namespace touchable
