#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <vector>

#include "bench/suite.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/frames.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/stream/relay.hpp"

namespace touchable {

/// Force error caused by delay. Records the goals and forces of a live run over a network; afterwards solves
/// the same goals on each moment's true surface, as without a network, and by a model of teleoperation
/// without a local surface: goals are sent to the surface's machine, forces come back.
class DelayedTouch final : public TouchSink {
public:
    /// `reader`: the run's, which knows when a frame was taken; must outlive this.
    explicit DelayedTouch(const ClipReader& reader) : reader_(reader) {}
    Result<void> consume(const TouchTick& tick) override;

    /// Appends undelayed_n, off_n, far_off_n (RMS over ticks and fingers) and without_touch_pct
    /// (bench/README.md). `setup`: the run's. `frames`: the surfaces that were sent, repeated every `period`
    /// frames. An error if the run's forces do not match these surfaces.
    Result<void> add_figures(const TouchSetup& setup, const std::vector<SurfaceFrame>& frames, int period,
                             const test::NetworkFaults& faults, Figures& figures) const;

private:
    using Vectors = std::vector<glm::dvec3>;  // per finger
    struct Tick {
        std::int64_t tick = 0, time_ns = 0;
        FramePair pair;  // the pair felt, without its surfaces
        Vectors goals, forces;
    };
    /// The sender's side: the frame of a moment, and when it was taken.
    struct Sent {
        std::vector<const SurfaceFrame*> frames;  // one period
        std::int64_t frame_ns = 0;                // frame interval
        std::int64_t first_ns = 0;                // exposure of the run's first frame
        std::int64_t first = 0;                   // its place in the period
        std::int64_t early = 0;  // place in the period of the run's frame 0, which came before the run
        FramePair newest(std::int64_t time_ns) const;
        const SurfaceFrame* taken(std::int64_t taken_ns) const;
        const SurfaceFrame* at(std::int64_t place) const;
    };

    FramePair felt(const Tick& tick, const Sent& sent) const;
    template <class PairOf>
    std::vector<Vectors> solved(const TouchSetup& setup, std::int64_t goals_late_ms, const PairOf& pair_of,
                                std::size_t count) const;
    double match(const TouchSetup& setup, Sent& sent, std::int64_t Sent::*place, std::size_t count) const;

    const ClipReader& reader_;
    std::vector<Tick> ticks_;
    std::size_t early_ticks_ = 0;                    // ticks on frames from before the run, without exposure
    std::map<std::int64_t, std::int64_t> taken_ns_;  // exposure of each other felt frame, by its number
};

}  // namespace touchable
