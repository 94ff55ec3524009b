// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the first frames of a recording show of the camera's depth, and the filters that suit it.
//
// A DepthEstimator takes frames, one per call, and measures the steps in which depth is stored, whether they
// are terraces, noise in time and over the picture, pixels that fly between surfaces, and contours;
// `measured` also tries filters on smooth patches of these frames. Of the filters that a scene leaves open,
// choose_filters takes those that leave the least false relief to be felt.
//
// Threads: one at a time; a stop request takes effect between steps.

#include <deque>
#include <limits>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/estimators.hpp"

namespace touchable {

/// Measurements of the stored depth in the first frames of a recording. Lengths are scene units.
struct MeasuredDepth {
    int frames = 0;       ///< frames that were measured; noise needs three
    double median = 0;    ///< depth of what can be touched
    double farthest = 0;  ///< of it, but for the last hundredth
    double pixel = 0;     ///< width of a pixel at the median
    DepthLength levels;   ///< zero: every code is a level
    double distance = 0;  ///< from one level to the next at the median
    double kappa = 0;     ///< at the median, with these levels
    Contours contours;
    DepthLength noise;  ///< of flat places, from frame to frame; zero: none was found
    double noise_at_edges = 0, noise_at_rims = 0;  ///< at the median
    double roughness = 0;                          ///< of flat places, from pixel to pixel, at the median
    double wide_roughness = 0;                     ///< over two pixels
    double smooth = 0;                             ///< share of flat places that are hardly rough
    double changing = 0;                           ///< share of flat places that change from frame to frame
    double dropouts = 0;                           ///< share of the pixels that lose their depth for a frame
    double tiny_holes = 0;                         ///< share of the pixels that are tiny holes
    double flying = 0;                             ///< share of the pixels that hang between two surfaces
    double midway = 0;                             ///< share at least a quarter of the way from both
    double clean_edges = 0;  ///< share of the pixels beside which depth jumps in one step
    /// Factor between the depths of successive frames if every second one agrees: frames of two kinds
    /// alternate. 1: they do not.
    double alternates_by = 1;
    /// Filters, and what they leave: for a camera's depth a search, for other depth with perceptible steps
    /// the removal of these. Empty: too little of it is smooth.
    std::vector<TriedFilters> tried;
    std::shared_ptr<const SmoothPatches> patches;  ///< on which they were tried; null: none were

    /// Share of pixels from which on tiny holes are not chance, and are worth filling.
    static constexpr double some_tiny_holes = 1e-4;

    double noise_at_median() const { return noise.at(median); }
    /// Whether noise is worth averaging, in pictures of this width.
    bool is_noisy(int width) const;
    /// Whether it has signs of a camera: noise, dropouts, tiny holes, or levels of disparity.
    bool from_a_camera() const;
    /// Whether flat places are rough as noise makes them: by more than a fraction of a pixel's width, hardly
    /// more over two pixels than from one to the next, everywhere, and differently in each frame. One picture
    /// cannot tell noise from texture as fine as pixels that is everywhere.
    bool is_rough() const;
    /// Whether every filter is tried; of other depth, the removal of perceptible steps alone.
    bool is_searched() const { return from_a_camera() || is_rough(); }
    /// Whether enough pixels hang between surfaces to be pulled in. For depth without signs of a camera, as
    /// phones and networks store it, only if edges are ramps rather than clean with few exceptions.
    bool has_flying_pixels() const;
    /// Detail of a scene's filters, 0 to 1, by their place on the frontier; nothing: they are not on it.
    std::optional<double> detail_of(const FilterSettings& filter) const;
    /// Depth beyond which these filters leave too much noise for force to be trusted. Nothing: nothing is so
    /// far away, or it was not found.
    std::optional<double> trusted_to(const FilterSettings& filter) const;
    /// Depth up to which error bars (ErrorSigns) hold: not of depth without noise, whose bars are the scene's
    /// own bends, nor beyond `trusted_to`. 0: nowhere; infinity: everywhere.
    double error_bars_to(const FilterSettings& filter) const {
        constexpr double everywhere = std::numeric_limits<double>::infinity();
        return is_searched() ? trusted_to(filter).value_or(everywhere) : 0;
    }
};

/// Measures the frames of a clip from the first one on; of pictures larger than 4096x4096 the middle. The
/// same on every machine.
class DepthEstimator {
public:
    explicit DepthEstimator(const Scene& scene) : scene_(scene), levels_(scene.depth), noise_(scene.depth) {}
    static constexpr int frames = 16;    ///< more are not worth measuring
    static constexpr int first_few = 4;  ///< enough, if they show neither a camera nor noise

    void add(const RawFrame& frame);
    /// Whether the next frame is not needed.
    bool enough() const;
    /// Levels that the scene states are used as stated. Nothing if no pixel was valid.
    std::optional<MeasuredDepth> measured() const;

private:
    std::optional<MeasuredDepth> measured_without_trying() const;

    const Scene scene_;
    LevelEstimator levels_;
    ContourEstimator contours_;
    NoiseEstimator noise_;
    std::deque<CodePicture> last_;               // cropped
    std::vector<std::vector<float>> first_few_;  // depths of these frames at some pixels; 0: invalid
    int added_ = 0;
};

/// Whether terrace removal is worth while: it leaves less where it was tried, or kappa is large; and there is
/// room for its codes.
bool removal_advised(const MeasuredDepth& measured, const Scene& scene);

/// Settles the filters that a scene's description leaves open, and TerraceRemoval::automatic, by the
/// measurements of its frames; without measurements they stay off. Terrace removal and temporal averaging use
/// the measured levels and noise, unless the scene states them. docs/measurements.md has the measurements
/// behind each rule.
void choose_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                    Scene& scene);

/// Whether frames have to be measured for `settle_filters`.
bool needs_measuring(const UnstatedFilters& unstated, const Scene& scene);
/// `choose_filters`, then refuses (ErrorKind::usage) a scene that cannot be filtered as it says: by the
/// temporal filter if neither scene nor frames tell the noise of depth.
Result<void> settle_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                            Scene& scene);

}  // namespace touchable
