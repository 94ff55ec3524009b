#pragma once

#include <cstdint>
#include <vector>

#include "engine/frame/plane_view.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Brings colour onto depth's pixels: each takes the pixel of the colour picture in which its point of the
/// surface lies. Depth stays as it is.
///
/// - A point is hidden where a surface lies before it as the colour camera sees it: nearer by more than a
///   slope of 80 degrees would explain. It then takes the colour of the nearest pixel of its row that is
///   seen, of the two sides the one that is farther away: what is hidden belongs to what lies behind. Outside
///   the colour picture, and in a row of which nothing is seen, it is grey.
/// - A pixel without depth is taken to be where the farther of its row's neighbours with depth is.
class ColourRegistration {
public:
    /// Of a scene with a colour_camera, whose depth coding is settled. What grows with the pictures takes
    /// memory with the first of them: a scene file can claim any size.
    explicit ColourRegistration(const Scene& scene);

    /// `depth` of the scene's size, `colour` RGB of the colour camera's.
    Image registered(const PlaneView& depth, const PlaneView& colour);
    /// Of the last picture's pixels with depth, those that the colour camera does not see: 0 to 1.
    double unseen_share() const { return unseen_share_; }
    /// Of all of its pixels, with depth or without, those that are grey.
    double grey_share() const { return grey_share_; }

private:
    /// Where a pixel's point is in the colour picture.
    struct Place {
        float x = 0, y = 0;  ///< pixels
        float depth = 0;     ///< along the colour camera's axis; 0: behind it, or unknown
    };
    void make_room();
    void find_depths(const PlaneView& depth);
    void place_all();
    void find_nearest();
    enum class Sight : std::uint8_t { seen, hidden, outside };
    Sight sight_of(const Place& place) const;
    void fill_unseen(Image& picture);

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
    double unseen_share_ = 0, grey_share_ = 0;
    // What is nearest to the colour camera, in cells as wide as depth's pixels appear to it.
    const double cell_;   // colour pixels
    const float scale_;   // cells in a colour pixel
    const float margin_;  // a point so many times as far away as what is nearest is hidden
    const int cells_x_, cells_y_;
    std::vector<float> nearest_;
};

}  // namespace touchable
