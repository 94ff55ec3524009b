#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Whether a whole picture's depth goes to and fro from frame to frame, as of networks that scale each
/// picture on its own: a finger at rest feels a pulse. Where more than half of the colours change, another
/// scene begins, which says nothing of that.
class PumpingEstimator {
public:
    explicit PumpingEstimator(const DepthCoding& coding) : coding_(coding) {}

    /// The next frame.
    void add(const RawFrame& frame);
    /// Standard deviation of the whole picture's depth, as a share of it; 0: there is none. Of what goes to
    /// and fro, successive changes d, d' have the mean product -variance; what moves on has d d' > 0. Nothing
    /// with fewer than four frames.
    std::optional<double> share() const;

private:
    bool is_cut() const;

    static constexpr int every = 4;  // pixels from one that is looked at to the next, either way

    const DepthCoding coding_;
    std::vector<double> before_, here_, ratios_;
    std::vector<std::uint8_t> colours_before_, colours_;  // green, of the same pixels; empty: no colour
    std::optional<double> last_change_;
    double products_ = 0;
    std::int64_t count_ = 0;
};

}  // namespace touchable
