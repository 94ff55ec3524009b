#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "bench/suite.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/frame/surface_frame.hpp"
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
    /// (bench/README.md). `setup`: of the run. `frames`: the surfaces that were sent, again and again from the
    /// first on, `period` frames each time. An error where the run's forces are not those of these surfaces.
    Result<void> add_figures(const TouchSetup& setup, const std::vector<SurfaceFrame>& frames, int period,
                             const test::NetworkFaults& faults, Figures& figures) const;

private:
    using Vectors = std::vector<glm::dvec3>;  // of all fingers
    struct Tick {
        std::int64_t tick = 0, time_ns = 0;
        std::int64_t frame = 0, frame_ns = 0;  // the frame that was felt, and its time
        Vectors goals, forces;
    };
    /// Where the surface is: the frame of a moment, and when it was taken.
    struct Sent {
        std::vector<const SurfaceFrame*> frames;  // of a period
        std::int64_t first = 0;                   // of the period, that the run calls frame 0
        std::int64_t frame_ns = 0, zero_ns = 0;   // when frame 0 was taken
        std::int64_t newest(std::int64_t time_ns) const;
        FramePair pair(std::int64_t number, std::int64_t time_ns) const;
        FramePair pair(std::int64_t number) const { return pair(number, zero_ns + number * frame_ns); }
    };

    std::int64_t taken_frame_0(std::int64_t frame_ns) const;
    template <class PairOf>
    std::vector<Vectors> solved(const TouchSetup& setup, std::int64_t goals_late_ms, const PairOf& pair_of,
                                std::size_t count) const;
    Result<std::int64_t> first_of_period(const TouchSetup& setup, Sent sent) const;

    const ClipReader& reader_;
    std::vector<Tick> ticks_;
    std::vector<std::int64_t> taken_ns_;  // of each frame that was felt, and
    std::vector<std::int64_t> numbers_;   // its number
};

}  // namespace touchable
