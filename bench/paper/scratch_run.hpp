// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "bench/paper/paper_clip.hpp"
#include "bench/paper/scripted_path.hpp"
#include "bench/suite.hpp"
#include "device/point_motion.hpp"

namespace touchable {

/// A scripted hand that scratches: its goal's path, how hard it presses (newtons, on a flat surface), and how
/// it holds the device. The paper's subject scratched "softly"; the others show the influence of that.
struct ScratchHand {
    std::string_view name;  ///< in the case's name, after its noise
    std::string_view words;
    ScriptedPath path = scratch;
    double press_n = 1;
    HandleDynamics dynamics{};
};
inline constexpr ScratchHand scratch_hands[] = {
    {"", "softly"},
    {"-hard", "twice as hard", scratch, 2},
    {"-fast", "twice as fast", {"scratch", 0.020, 1.66, 0.004, 0.62, 0.037}},
    {"-firm", "firmly held", scratch, 1, {.mass = 0.2, .damping = 2, .hand_stiffness = 1000}}};

/// The paper's second experiment (Fig. 19): a hand scratches the chest softly, and the force is recorded for
/// ten segments of 10 s. The hand is scripted, holds the device and yields (HeldHandle).
struct ScratchRun {
    TouchCase setup;
    PaperFilter filter;
    ScratchHand hand;
};

/// Bands of one octave whose powers are reported: the first one's start, Hz, and their number.
inline constexpr double first_octave_hz = 7.8125;
inline constexpr int octaves = 6;

/// Appends force_band_mn (20 to 500 Hz), force_band_mn_<from>_<to> of each octave, mean and largest force,
/// force_angle_deg_rms outside the true surface's friction cone, the share of ticks in contact, the hash of
/// the forces of all ticks, and for plots force_psd_<hz>hz. An error if a force is not k S (P - G), a proxy
/// is behind the surface, or less than half of the ticks are in contact.
Result<void> measure_scratch(std::shared_ptr<const PaperClip> clip, const ScratchRun& run, Figures& figures);

}  // namespace touchable
