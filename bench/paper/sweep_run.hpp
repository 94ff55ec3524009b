// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/paper/paper_clip.hpp"
#include "bench/paper/scripted_path.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The paper's first experiment (Table I): a scripted hand moves over a clip as fast as a person might, in
/// contact, 2 mm under the true surface. Several fingers (`setup.fingers`) follow each other on the path.
struct SweepRun {
    TouchCase setup;
    PaperFilter filter;
    ScriptedPath path;
    int seconds = 30;  ///< after one second in which the hand comes down
    int repeats = 5;
};

/// The paper's average: one finger's tick in its contents of 720x480 and of 320x240. It expects F fingers to
/// take F times as long.
inline constexpr double papers_globe_us = 253.4, papers_chest_us = 80.9;

/// Appends primitives_second_max (of all fingers) and primitives_mean (of one), contact_pct, capped_ticks and
/// the hash of the forces of all ticks; an error if a tick is invalid. Times nothing.
Result<void> count_primitives(std::shared_ptr<const PaperClip> clip, const SweepRun& run, Figures& figures);

/// Appends tick_us_second_max and primitives_second_max (the largest of each second, mean over the seconds),
/// primitives_mean, the times of a tick and, of clips filtered beforehand, `frame_ms`, the least time to
/// build a frame; an error if a tick is invalid (see `verify`).
Result<void> measure_sweep(std::shared_ptr<const PaperClip> clip, const SweepRun& run, Figures& figures);

}  // namespace touchable
