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

/// A clip as one pinhole camera sees all of it: the lens of its depth is undone, and its colour brought onto
/// depth's pixels, where its scene has a `lens` or a `colour_camera`, and frames whose camera is another than
/// the scene's are brought onto that; the scene that it then gives has none of these. Other clips as they
/// are.
///
/// Each pixel then has the stored depth, haptic and height (and colour that has depth's pixels) of the one
/// nearest to where it was shown; nothing is mixed. A picture of depth has no depth where nothing was shown;
/// where other cameras make that necessary and every code is a depth, an error says so. Depth is not changed
/// by its new place, planar or range: both are what they were along the ray.
Result<std::unique_ptr<ClipReader>> with_pinhole_frames(std::unique_ptr<ClipReader> clip);

/// Brings colour onto depth's pixels: each takes the pixel of the colour picture in which its point of the
/// surface lies. Depth stays as it is.
///
/// - A point is hidden where a surface lies before it as the colour camera sees it, or up to one and
///   a half of depth's pixels beside it: nearer by more than a slope of 80 degrees would explain. (Depth does
///   not say where between two of its pixels a surface ends, and a lens spreads its colour.) It is grey, as
///   all is beyond the colour picture's edge: no colour is better than a wrong one.
/// - A gap of `most_filled` pixels of a row or a column at most takes the colour of the pixel beside it, of
///   the two sides that of the farther one: what is hidden belongs to what lies behind.
/// - A pixel without depth is taken to be as far away as the nearest one of its row with depth, where that is
///   up to four pixels away; else, or where it is hidden there, as the farther one of its neighbours in the
///   row; or else the other.
class ColourRegistration {
public:
    /// Of a scene with a colour_camera, whose depth coding is settled. What grows with the pictures takes
    /// memory with the first of them: a scene file can claim any size.
    explicit ColourRegistration(const Scene& scene);

    /// Such a gap is a speck of noise or of rounding, and colours two pixels apart differ little: a colour
    /// camera itself mixes those of two pixels. A wider one would be seen as a stripe.
    static constexpr std::size_t most_filled = 2;

    /// Finds out where each pixel's colour is. `depth` of the scene's size.
    void look_at(const PlaneView& depth);
    /// Looks at it, too. `colour`: RGB of the colour camera's size.
    Image registered(const PlaneView& depth, const PlaneView& colour);
    /// Of the pixels with depth last looked at, those that the colour camera does not see: 0 to 1.
    double unseen_share() const { return unseen_share_; }
    /// Of all of them, with depth or without, those that are grey.
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
    // Of the picture at hand, one for each pixel.
    std::vector<std::uint8_t> has_depth_;
    std::vector<float> depth_;  // planar; of pixels without depth what they are taken for; 0: nothing
    std::vector<Place> places_;
    std::vector<Sight> sights_;
    std::vector<std::int32_t> from_;  // the pixel whose colour it has: itself, one beside it; -1: grey
    double unseen_share_ = 0, grey_share_ = 0;
    // What is nearest to the colour camera, in cells as wide as depth's pixels appear to it.
    const double cell_;  // colour pixels
    const float scale_;  // cells in a colour pixel
    // A point so many times as far away as what is nearest in its cell, or in one beside it, is hidden.
    const float margin_, wide_margin_;
    const int cells_x_, cells_y_;
    std::vector<float> nearest_, nearest_around_;
};

}  // namespace touchable
