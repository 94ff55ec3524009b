#pragma once

#include <string>
#include <vector>

namespace touchable {

/// What the haptic thread will find on this machine.
struct TimerFacts {
    double clock_resolution_ns = 0;           ///< of the monotonic clock
    double timer_slack_ns = 0;                ///< by which the kernel may let this thread oversleep
    double late_p50_us = 0, late_max_us = 0;  ///< waking from 200 sleeps to a 1 ms grid
    bool realtime_permitted = false;          ///< SCHED_FIFO
};

/// How a person permits SCHED_FIFO and locked memory to `program`: one way on each line.
std::vector<std::string> ways_to_realtime(const std::string& user, const std::string& program);
/// For who runs this program, and it.
std::vector<std::string> ways_to_realtime();

struct CpuFacts {
    std::string model;
    int cores = 0;  ///< that this program may use
};

struct CodecFact {
    std::string name;  ///< "ffv1 encoder"
    bool present = false;
};

struct FfmpegFacts {
    std::string version;
    std::vector<CodecFact> needed;
};

CpuFacts cpu_facts();
/// Takes a fifth of a second.
TimerFacts timer_facts();
FfmpegFacts ffmpeg_facts();

}  // namespace touchable
