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

/// What delay costs the hand. A live run over a network keeps its goals and forces here; afterwards the same
/// goals are solved on the surface of each very moment, as if nothing came between, and by the model that
/// teleoperation without a local surface is: goals go to where the surface is, forces come back.
class DelayedTouch final : public TouchSink {
public:
    /// `reader`: of the run, which tells when a frame was taken; it outlives this.
    explicit DelayedTouch(const ClipReader& reader) : reader_(reader) {}
    Result<void> take(const TouchTick& tick) override;

    /// Appends undelayed_n, off_n, far_off_n (RMS over ticks and fingers) and without_touch_pct
    /// (bench/README.md). `setup`: of the run. `frames`: the surfaces that were sent, again and again from
    /// the first on, `period` frames each time. An error where the run's forces are not those of these
    /// surfaces.
    Result<void> add_figures(const TouchSetup& setup, const std::vector<SurfaceFrame>& frames, int period,
                             const test::NetworkFaults& faults, Figures& figures) const;

private:
    using Vectors = std::vector<glm::dvec3>;  // of all fingers
    struct Tick {
        std::int64_t tick = 0, time_ns = 0;
        FramePair pair;  // what was felt, without its surfaces
        Vectors goals, forces;
    };
    /// Where the surface is: the frame of a moment, and when it was taken.
    struct Sent {
        std::vector<const SurfaceFrame*> frames;  // of a period
        std::int64_t frame_ns = 0;                // from one frame to the next
        std::int64_t first_ns = 0;                // when the first frame that came in the run was taken
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
    std::size_t early_ticks_ = 0;                    // on frames that came before the run, which tell no time
    std::map<std::int64_t, std::int64_t> taken_ns_;  // of each other frame that was felt, by its number
};

}  // namespace touchable
