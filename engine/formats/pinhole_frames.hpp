// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Presents a clip as one pinhole camera sees it: undoes the lens of depth (the scene's `lens`), brings
/// colour onto depth's pixels (`colour_camera`), and brings frames of other cameras onto the scene's camera.
/// The resulting scene has none of these. Clips without them are returned unchanged.
///
/// Each pixel gets depth, haptic and height (and colour that has depth's pixels) of the stored pixel nearest
/// to its ray; nothing is mixed. Pixels beyond the stored picture have no depth; an error if frames' cameras
/// require this and every code is a depth. Depth keeps its value, planar or range, as both stay the same
/// along a ray.
Result<std::unique_ptr<ClipReader>> with_pinhole_frames(std::unique_ptr<ClipReader> clip);

/// Brings colour onto depth's pixels: each takes the pixel of the colour picture that shows its point of the
/// surface. Depth stays as it is.
///
/// - A point is hidden if, for the colour camera, a surface in front of it or up to one and a half of
///   depth's pixels beside it is nearer by more than a slope of 80 degrees would explain. (Depth does not
///   say where between two of its pixels a surface ends, and a lens spreads its colour; a surface goes on
///   into up to four pixels without depth beside it.) Hidden points and all beyond the colour picture's
///   edge are grey: no colour is better than a wrong one.
/// - A gap of at most `most_filled` pixels in a row or column takes the colour of the farther one of the two
///   pixels beside it: hidden points belong to the surface behind.
/// - A pixel without depth takes that of the nearest pixel in its row with depth, if that is up to four
///   pixels away; otherwise, or if it is hidden there, that of its farther neighbour in the row, or else of
///   the other.
class ColourRegistration {
public:
    /// `scene` has a colour_camera and a settled depth coding. Buffers of a picture's size are allocated with
    /// the first picture: a scene file can claim any size.
    explicit ColourRegistration(const Scene& scene);

    /// A gap this narrow is a speck of noise or rounding, and colours two pixels apart differ little: a
    /// colour camera itself mixes those of two pixels. A wider one would show as a stripe.
    static constexpr std::size_t most_filled = 2;

    /// Finds each pixel's place in the colour picture. `depth`: of the scene's size.
    void look_at(const PlaneView& depth);
    /// Calls look_at and returns colour on depth's pixels. `colour`: RGB of the colour camera's size.
    Image registered(const PlaneView& depth, const PlaneView& colour);
    /// Share, 0 to 1, of the last picture's pixels with depth that the colour camera does not see.
    double unseen_share() const { return unseen_share_; }
    /// Share of all its pixels, with depth or without, that are grey.
    double grey_share() const { return grey_share_; }

private:
    /// Where a pixel's point is in the colour picture.
    struct Place {
        float x = 0, y = 0;  ///< pixels
        float depth = 0;     ///< along the colour camera's axis; 0: behind it, or unknown
    };
    Place place_of(int x, int y, double length) const;
    void place_all(const PlaneView& depth);
    void place_holes();
    void place_hole(int x, int y, const std::array<float, 3>& depths);
    void find_nearest();
    void cover(const Place& place);
    void spread_nearest();
    enum class Sight : std::uint8_t { seen, hidden, outside };
    Sight sight_of(const Place& place) const;
    void fill_line(std::size_t first, std::size_t step, std::size_t count);
    void fill_gaps();

    const int width_, height_;
    const Camera camera_;
    const DepthCoding coding_;
    const ColourCamera colour_;
    const double reach_;                 // of the colour camera's lens
    std::vector<double> depth_of_code_;  // 0: not valid
    // For the current picture, one for each pixel.
    std::vector<std::uint8_t> has_depth_;
    std::vector<float> depth_;  // planar; assumed for pixels without depth; 0: none
    std::vector<Place> places_;
    std::vector<Sight> sights_;
    std::vector<std::int32_t> from_;  // the pixel whose colour it has: itself, one beside it; -1: grey
    double unseen_share_ = 0, grey_share_ = 0;
    // Depths nearest to the colour camera, in cells as wide as depth's pixels appear to it.
    const double cell_;  // colour pixels
    const float scale_;  // cells in a colour pixel
    // A point is hidden beyond this many times the nearest depth in its cell, or around it.
    const float margin_, wide_margin_;
    const int cells_x_, cells_y_;
    std::vector<float> nearest_, nearest_around_;
};

}  // namespace touchable
