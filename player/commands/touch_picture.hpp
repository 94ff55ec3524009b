#pragma once

#include <deque>
#include <glm/vec2.hpp>
#include <vector>

#include "player/options/picture_options.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// `touch --picture`: remembers the fingers at a moment of the run and where they went just before; once the
/// run is over, reads the frames of that moment again and draws them.
class TouchPicture final : public TouchSink {
public:
    /// `tick`: the moment; the first tick that is not before it, where some are skipped.
    TouchPicture(PictureOrder order, std::int64_t tick) : order_(std::move(order)), tick_(tick) {}
    Result<void> take(const TouchTick& tick) override;
    bool is_reached() const { return reached_; }  ///< the moment
    const SurfacePainter& painter() const { return *order_.painter; }
    /// Draws. Where the run ended before the moment: its last tick, if it was `cut_short`, else refused
    /// (ErrorKind::usage).
    Result<void> finish(const TouchSetup& setup, bool cut_short);
    /// What was drawn, for a person; empty before `finish`.
    const std::string& line() const { return line_; }

private:
    using Place = glm::dvec2;  // of a proxy in the image, pixels
    struct Moment {
        std::uint64_t epoch = 0;
        std::int64_t frame_prev = 0, frame_next = 0;
        double blend = 0;
        std::vector<FingerMark> fingers;  // trails are still empty
    };
    std::vector<FingerMark> fingers_on(const HeightField& field) const;

    PictureOrder order_;
    std::int64_t tick_;
    std::vector<std::deque<Place>> trails_;  // of each finger, since it last came into contact
    std::optional<Moment> moment_;           // the newest tick, until the moment
    bool reached_ = false;
    std::string line_;
};

/// The tick that a picture shows where nobody says: 60 % of the run, or of its shortest length (3 s) where
/// only reading the clip tells how long it is.
std::int64_t usual_picture_tick(const TouchSetup& setup);

}  // namespace touchable
