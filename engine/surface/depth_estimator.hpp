#pragma once

// What the first frames of a recording tell of the camera's depth, and the filters that suit it.
//
// A DepthEstimator looks at frames, one call each: the steps in which depth is stored, whether they are
// terraces, noise in time and over the picture, pixels that fly between surfaces, contours; `measured` also
// tries filters on smooth patches of these frames. choose_filters keeps, of the filters that a scene leaves
// open, those with which a pen feels least that is not there.
//
// One thread at a time; a stop is heard between steps.

#include <deque>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/estimators.hpp"

namespace touchable {

/// What the first frames of a recording tell of the depth that is stored in it. Lengths are scene units.
struct MeasuredDepth {
    int frames = 0;       ///< that were looked at; noise needs three
    double median = 0;    ///< depth of what is there to touch
    double pixel = 0;     ///< width of a pixel there
    DepthLength levels;   ///< zero: every code is one
    double distance = 0;  ///< from one level to the next at the median
    double kappa = 0;     ///< there, with these levels
    Contours contours;
    DepthLength noise;  ///< of flat places, from frame to frame; zero: none was found
    double noise_at_edges = 0, noise_at_rims = 0;  ///< at the median
    double roughness = 0;                          ///< of flat places, from pixel to pixel, at the median
    double dropouts = 0;                           ///< share of the pixels that lose their depth for a frame
    double tiny_holes = 0;                         ///< share of the pixels that are tiny holes
    double flying = 0;                             ///< share of the pixels that hang between two surfaces
    double midway = 0;                             ///< share of those a quarter of the way from both at least
    double clean_edges = 0;  ///< share of the pixels beside which depth jumps in one step
    /// How many times as deep a frame is as the one before or behind it, where every second one agrees:
    /// frames of two kinds take turns. 1: not so.
    double alternates_by = 1;
    /// Filters, and what they leave: of a camera's depth a search, of other depth whose steps are felt the
    /// removal of these. None: too little of it is smooth.
    std::vector<TriedFilters> tried;

    /// From this share of pixels on they are no chance, and worth to be filled.
    static constexpr double some_tiny_holes = 1e-4;

    double noise_at_median() const { return noise.at(median); }
    /// Whether noise is worth to be averaged, in pictures of this width.
    bool is_noisy(int width) const;
    /// Whether something says that a camera measured it: noise, dropouts, tiny holes, or levels of disparity.
    bool from_a_camera() const;
    /// Whether enough pixels hang between surfaces to be pulled in. Of depth that shows nothing of a camera,
    /// as phones and networks store it, only where edges are ramps, not where they are clean but for a few.
    bool has_flying_pixels() const;
};

/// Looks at the frames of a clip from the first one on; of pictures larger than 4096x4096 at their middle.
/// The same on every machine.
class DepthEstimator {
public:
    explicit DepthEstimator(const Scene& scene) : scene_(scene), levels_(scene.depth), noise_(scene.depth) {}
    static constexpr int frames = 16;    ///< no more are worth a look
    static constexpr int first_few = 4;  ///< enough, where they show nothing of a camera

    void add(const RawFrame& frame);
    /// Whether the next frame need not be looked at.
    bool enough() const;
    /// Levels that the scene states count as stated. Nothing where no pixel was valid.
    std::optional<MeasuredDepth> measured() const;

private:
    std::optional<MeasuredDepth> measured_without_trying() const;

    const Scene scene_;
    LevelEstimator levels_;
    ContourEstimator contours_;
    NoiseEstimator noise_;
    std::deque<CodePicture> last_;               // cropped
    std::vector<std::vector<float>> first_few_;  // depths of these frames at some pixels; 0: none
    int added_ = 0;
};

/// Whether terrace removal is worth while: enough kappa with the measured levels, and room for it.
bool removal_advised(const MeasuredDepth& measured, const Scene& scene);

/// Settles the filters that a scene's description leaves open, and TerraceRemoval::automatic, by what was
/// measured of its frames; nothing measured: they stay off. Terraces are removed and temporal noise is
/// averaged as the measured levels and noise say, where the scene does not state these. docs/measurements.md
/// has the measurements behind each rule.
void choose_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                    Scene& scene);

/// Whether frames have to be measured for `settle_filters`.
bool needs_measuring(const UnstatedFilters& unstated, const Scene& scene);
/// `choose_filters`, then refuses (ErrorKind::usage) a scene that cannot be filtered so: by the temporal
/// filter where neither scene nor frames say how noisy depth is.
Result<void> settle_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                            Scene& scene);

}  // namespace touchable
