#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/result.hpp"
#include "player/session/run_record.hpp"

namespace touchable {

/// What a person wants of a machine.
struct TouchDemand {
    int width = 720, height = 480;
    int fingers = 1;
    int rate = 30;  ///< frames per second

    std::string in_words() const;  ///< "720x480 at 30 frames/s with 1 finger"
};

/// What a short piece of that came to here. Wall times, but for CPU time, which is of all threads.
struct TrialFigures {
    std::string builder;         ///< what `--live` takes for such a clip
    Spread decode_ms, build_ms;  ///< of a frame
    Spread tick_us;              ///< all fingers
    double frame_cpu_ms = 0;     ///< decoding and building
    double tick_cpu_us = 0;      ///< with the hand's own work
    int frames = 0, ticks = 0;   ///< that were measured

    double cpu_ms_per_second(const TouchDemand& demand) const;
    /// Whether frames waited for cores more than they used them: other programs had them.
    bool is_crowded() const { return decode_ms.mean + build_ms.mean > 2 * frame_cpu_ms; }
};

/// Makes a clip of that size in the folder of temporary files (depth of 16 bits and colour), decodes, builds
/// (median 3x3) and touches it, and removes it. Takes seconds.
Result<TrialFigures> try_touch(const TouchDemand& demand);

struct TrialVerdict {
    bool can = false;
    double most_rate = 0;  ///< frames per second, with as many fingers
    std::string why;       ///< what takes longest, and how long it may
};
/// Whether frames are decoded and built as fast as they are due, on a thread each, ticks end before the next
/// one is due, and all of it fits a machine of so many cores with a tenth left for everything else.
TrialVerdict judge(const TouchDemand& demand, const TrialFigures& figures, int cores);

nlohmann::ordered_json trial_json(const TouchDemand& demand, const TrialFigures& figures,
                                  const TrialVerdict& verdict, int cores);
/// The verdict on a plain line, then the figures.
std::string trial_to_text(const TouchDemand& demand, const TrialFigures& figures, const TrialVerdict& verdict,
                          int cores);

}  // namespace touchable
