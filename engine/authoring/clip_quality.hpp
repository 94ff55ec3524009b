#pragma once

// What of a clip would feel wrong, measured: colour that does not lie on depth, depth that pulses, frames
// that are missing or late, haptic values that no device renders (the command `info`, when it verifies).
//
// measure_quality reads a clip once and gives all of it as figures; nothing is judged here. One thread's; a
// stop is heard between frames.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Edges of colour against edges of depth. Where a near surface ends before a far one, its colour should end
/// at the same pixel.
class ColourEdges {
public:
    explicit ColourEdges(const Scene& scene);

    /// Looks at a frame with colour. `where`: pixels of edges whose colour is two steps or more away are set
    /// to 1 there, row by row; nothing: nobody wants to know.
    void add(const RawFrame& frame, std::vector<std::uint8_t>* where = nullptr);

    /// Medians, in pixels of the depth plane.
    struct Fit {
        std::int64_t edges = 0;  ///< places that were compared
        /// Share of them within two steps of their median, across or down, whichever is less. Where colour
        /// lies far beside depth, by more than is looked at, edges of colour are found by chance, all over
        /// the window: then the other figures mean nothing.
        double agreement = 0;
        bool agrees() const { return agreement >= 0.45; }
        /// By how much colour lies to the right of depth, and below it. Nothing: too few edges face both
        /// ways.
        std::optional<double> right, below;
        /// By how much near surfaces reach beyond their colour, so that the background's colour lies on
        /// their rims; below 0: their colour reaches beyond them.
        double rim = 0;
    };
    /// Nothing where there were too few edges.
    std::optional<Fit> fit() const;

private:
    enum Facing { to_right, to_left, down, up };  // from the near surface to the far one
    static constexpr int reach = 8;               // steps on either side that are looked at
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

/// How frames follow each other.
struct FrameTimes {
    std::int64_t frames = 0;
    /// Whose depth, haptic and height are those of the one before, though the surface moves: it changes
    /// within longest_repeat frames before and after. A surface that stands still for longer is no fault.
    std::int64_t repeated = 0;
    std::int64_t changed = 0;        ///< that are others than the one before
    std::int64_t of_new_colour = 0;  ///< of those: colour has changed
    static constexpr std::int64_t longest_repeat = 4;
    double usual_ms = 0;       ///< from one to the next, the median
    std::int64_t missing = 0;  ///< as many fit into longer times
    std::int64_t jumps = 0;    ///< times that stand still, go back, or follow within a quarter of the usual
    double longest_ms = 0;
    std::int64_t longest_at = 0;  ///< the frame after it
};

/// Looks at all frames of a clip, in order.
class FrameTimesEstimator {
public:
    void add(const RawFrame& frame);
    FrameTimes times() const;

private:
    FrameTimes so_far_;
    std::optional<RawFrame> before_;
    std::vector<std::int64_t> steps_ns_;
    std::int64_t same_ = 0, same_of_new_colour_ = 0;  // since the last change
};

/// What the haptic pictures of a clip ask of a device. Shares are of the pixels that have a surface.
struct HapticValues {
    double stiffest = 0;      ///< N/mm
    double too_stiff = 0;     ///< share that is stiffer than stiffest_of_devices
    double more_dynamic = 0;  ///< share with dynamic friction above static friction
    /// Share that has the value of no neighbour on either side, though these agree among themselves: noise of
    /// a codec that mixes materials.
    double mixed = 0;
};

/// N/mm. The stiffest that a hand-held device renders by what its makers and the literature say
/// (docs/devices.md); most render less.
inline constexpr double stiffest_of_devices = 3.0;

class HapticValuesEstimator {
public:
    explicit HapticValuesEstimator(const Scene& scene) : scene_(scene) {}

    /// Pixels that are set to 1, row by row, of those shares; nothing: nobody wants to know.
    struct Where {
        std::vector<std::uint8_t> too_stiff, more_dynamic, mixed;
    };
    /// Looks at a frame with a haptic picture.
    void add(const RawFrame& frame, Where* where = nullptr);
    HapticValues values() const;

private:
    const Scene scene_;
    double stiffest_ = 0;
    std::int64_t pixels_ = 0, too_stiff_ = 0, more_dynamic_ = 0, mixed_ = 0;
};

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

/// What was measured of a whole clip. How each is measured stands with its type.
struct ClipQuality {
    FrameTimes times;
    std::int64_t blank = 0;                  ///< frames without any depth
    std::int64_t first_blank = 0;            ///< number of the first of them
    std::optional<double> pumping;           ///< share of the depth (PumpingEstimator)
    std::optional<ColourEdges::Fit> colour;  ///< nothing: no colour, or too few edges
    std::optional<HapticValues> haptic;      ///< nothing: no haptic picture

    /// In the first frame: pixels that are concerned are 1, row by row.
    struct Where {
        Image picture;  ///< colour, or without it depth as grey, near is bright
        std::vector<std::uint8_t> colour_edges, level_steps;
        HapticValuesEstimator::Where haptic;
    } where;
};

/// Reads all frames of a clip that is at its beginning. `scene`: with the levels of its depth
/// (FilterSettings::levels), where these are known. `progress` is given the number of frames that were read.
/// An error of kind interrupted where the program is asked to stop.
Result<ClipQuality> measure_quality(ClipReader& clip, const Scene& scene,
                                    const std::function<void(std::int64_t)>& progress);

}  // namespace touchable
