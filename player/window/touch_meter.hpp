#pragma once

#include <mutex>

#include "player/run/touch_session.hpp"
#include "player/window/study.hpp"

namespace touchable {

/// How a participant touched, by the session's ticks.
struct TouchMeasures {
    double contact_s = 0;     ///< in which at least one finger touched
    int touches = 0;          ///< how often a finger came to the surface
    double mean_newtons = 0;  ///< on the finger with the largest force, over the time of contact; 0: none
    double most_newtons = 0;  ///< on any finger
};

/// Measures one touch after the other. Ticks come by a session's thread; the rest is the window's.
class TouchMeter final : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) override;
    /// From now on. With the force on, forces are those that reach the hand (all of them, for a mouse);
    /// with it off, those that it would have felt.
    void begin(StudyForce force);
    TouchMeasures measures() const;

private:
    mutable std::mutex mutex_;
    StudyForce force_ = StudyForce::on;
    std::int64_t contact_ticks_ = 0;
    double sum_newtons_ = 0;
    TouchMeasures measured_;
    std::vector<bool> touched_;  // by finger, in the tick before
};

}  // namespace touchable
