#pragma once

// The estimators of measure_quality (recorded_clip.hpp): each looks at frames of a clip in order.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Compares edges of colour with edges of depth. If a near surface ends in front of a far one, its colour
/// should end at the same pixel.
class ColourEdges {
public:
    explicit ColourEdges(const Scene& scene) : coding_(scene.depth), step_(std::max(1, scene.width / 640)) {}

    /// Adds a frame with colour. `where`, unless null: pixels of edges whose colour is two steps or more away
    /// are set to 1, row by row.
    void add(const RawFrame& frame, std::vector<std::uint8_t>* where = nullptr);

    /// nullopt if there were too few edges.
    std::optional<ClipQuality::ColourFit> fit() const;

private:
    enum Facing { to_right, to_left, down, up };  // from the near surface to the far one
    static constexpr int reach = 8;               // steps examined on either side
    static constexpr int offsets = 2 * reach + 1;

    struct Line;
    static bool is_silhouette(const Line& line, int at, int out);
    static std::optional<int> offset_of_colour(const Line& line, int at, int out);
    void look(const Line& line, int at, Facing facing, std::vector<std::uint8_t>* where);
    std::int64_t count(Facing facing) const;
    double median(Facing facing) const;
    std::int64_t near_median(Facing facing) const;
    double agreement(Facing a, Facing b) const;

    const DepthCoding coding_;
    const int step_;  // pixels from one sample of a profile to the next
    std::vector<float> depths_;
    std::array<std::array<std::int64_t, offsets>, 4> counts_{};
};

/// Looks at all frames of a clip, in order.
class FrameTimesEstimator {
public:
    void add(const RawFrame& frame);
    ClipQuality::FrameTimes times() const;

private:
    ClipQuality::FrameTimes so_far_;
    std::optional<RawFrame> before_;
    std::vector<std::int64_t> steps_ns_;
    std::int64_t same_ = 0, same_of_new_colour_ = 0;  // since the last change
};

/// Looks at the haptic pictures of a clip.
class HapticValuesEstimator {
public:
    explicit HapticValuesEstimator(const Scene& scene) : scene_(scene) {}

    /// Adds a frame with a haptic picture. `where`, unless null: affected pixels are set to 1, row by row.
    void add(const RawFrame& frame, ClipQuality::Where::Haptic* where = nullptr);
    ClipQuality::HapticValues values() const;

private:
    const Scene scene_;
    double stiffest_ = 0;
    std::int64_t pixels_ = 0, too_stiff_ = 0, more_dynamic_ = 0, mixed_ = 0;
};

/// Measures whether a whole picture's depth oscillates from frame to frame, as with networks that scale each
/// picture on its own: a finger at rest feels a pulse. If more than half of the colours change, another shot
/// begins, and the change is ignored.
class PumpingEstimator {
public:
    explicit PumpingEstimator(const DepthCoding& coding) : coding_(coding) {}

    /// Adds the next frame.
    void add(const RawFrame& frame);
    /// Standard deviation of the whole picture's depth, as a share of it; 0: no oscillation. Successive
    /// changes d, d' of an oscillation have the mean product -variance; a steady change has d d' > 0. nullopt
    /// with fewer than four frames.
    std::optional<double> share() const;

private:
    bool is_cut() const;

    static constexpr int every = 4;  // pixels from one sample to the next, either way

    const DepthCoding coding_;
    std::vector<double> before_, here_, ratios_;
    std::vector<std::uint8_t> colours_before_, colours_;  // green, of the same pixels; empty: no colour
    std::optional<double> last_change_;
    double products_ = 0;
    std::int64_t count_ = 0;
};

}  // namespace touchable
