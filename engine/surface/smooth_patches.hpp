#pragma once

#include <array>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "engine/scene/code_curve.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/surface_frame.hpp"
#include "engine/surface/code_picture.hpp"

namespace touchable {

/// Places of a recording whose surface is smooth, so that it is known better than a pixel tells: a paraboloid
/// of 1/depth fitted to 32x32 pixels. With 16 pixels around them, as far as filters reach, they are put side
/// by side into one small picture, a mosaic, on which filters are tried quickly. Integers and + - x / sqrt
/// alone: the same on every machine.
class SmoothPatches {
public:
    /// Places are chosen in the last of some pictures of one size: of 8x8 parts of it the smoothest place in
    /// each that is not all of one code, and of these those that are about as smooth as the best, without the
    /// ones that have a low relief where there are enough others. Of the pictures only what `cropped` leaves.
    SmoothPatches(const Scene& scene, const std::deque<CodePicture>& pictures);
    /// The columns and rows in which a place can lie: of a side that is longer, 1536 at most.
    static CodePicture cropped(const CodePicture& picture);
    static constexpr int core = 32, side = 64, most_across = 8;
    /// Pixels along each side of a core whose faces are not looked at: there the fit is less sure.
    static constexpr int margin = 8;
    /// Fewer tell nothing about a recording.
    static constexpr int fewest = 6;
    /// Pictures that are worth to be given: the temporal filter has settled with the last one.
    static constexpr int frames = 8;

    bool enough() const { return patches_.size() >= fewest; }

    /// Of each picture, with the scene's coding.
    const std::vector<RawFrame>& mosaics() const { return mosaics_; }
    /// A scene of them, without filters.
    const Scene& mosaic_scene() const { return mosaic_scene_; }

    struct Place {
        int x, y;
    };
    /// Of each patch's core: its first pixel in the picture, and in the mosaic.
    std::vector<std::pair<Place, Place>> places() const;
    /// Of their middles.
    double median_depth() const;
    /// How far depths of the last picture are off their smooth surfaces, RMS, scene units: noise, levels and
    /// whatever else is no surface.
    DepthLength roughness() const;
    /// How far the faces of a surface that was made of the last mosaic are off these surfaces, RMS, degrees.
    /// A face that is off by more than 60 degrees counts as that.
    double faces_off_deg(const SurfaceFrame& built) const;

private:
    /// w = sum of its six coefficients times 1, x, y, x^2, x y, y^2, in pixels/16 from the patch's middle.
    struct Fit {
        std::array<double, 6> of{};
        double residual = 0;  // RMS, of w
        bool ok = false;
    };
    struct Patch {
        int x = 0, y = 0;  // of the first pixel of its core
        Fit fit;
    };
    using Pictures = std::span<const CodePicture* const>;

    /// visit(x, y, 1/depth as stored, w) of each pixel of a core that has a depth.
    template <class Visit>
    void each_depth(Pictures pictures, int left, int top, const Visit& visit) const;
    /// To the same core in one picture, or several.
    Fit fitted(Pictures pictures, int left, int top) const;
    bool has_relief(Pictures pictures, const Patch& patch) const;
    const int* row_of(const CodePicture& picture, int x, int y) const;
    void choose(const CodePicture& picture);
    void fit_to_all(Pictures pictures);
    RawFrame mosaic(const CodePicture& picture) const;

    const Scene scene_;
    std::vector<double> inverse_of_code_;
    Scene mosaic_scene_;
    int no_depth_ = 0;  // a code that is invalid
    std::vector<Patch> patches_;
    std::vector<RawFrame> mosaics_;
};

}  // namespace touchable
