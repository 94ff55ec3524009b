#pragma once

#include "bench/paper/paper_clip.hpp"
#include "bench/paper/scripted_path.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The paper's first experiment (Table I): a scripted hand moves over a clip as fast as a person might, in
/// contact, 2 mm under the true surface.
struct SweepRun {
    TouchCase setup;
    PaperFilter filter;
    ScriptedPath path;
    int seconds = 30;  ///< after one second in which the hand comes down
    int repeats = 5;
};

/// Appends primitives_second_max and primitives_mean, contact_pct, capped_ticks and the hash of the forces of
/// all ticks; an error if a tick is invalid. Times nothing.
Result<void> count_primitives(std::shared_ptr<const PaperClip> clip, const SweepRun& run, Figures& figures);

/// Appends tick_us_second_max and primitives_second_max (the largest of each second, mean over the seconds),
/// primitives_mean, and the times of a tick; an error if a tick is invalid (see `verify`).
Result<void> measure_sweep(std::shared_ptr<const PaperClip> clip, const SweepRun& run, Figures& figures);

}  // namespace touchable
