#pragma once

#include <cstdint>
#include <vector>

#include "engine/authoring/pixel_features.hpp"

namespace touchable {

/// Some pixels that lie together and are alike: a patch of one surface, with the plane through it.
struct Superpixel {
    std::int32_t x = 0, y = 0;                                               ///< its middle
    std::int32_t pixels = 0;                                                 ///< 0: there is none in its cell
    std::int32_t brightness = 0, red_green = 0, yellow_blue = 0, depth = 0;  ///< means; depth at its middle
    std::int32_t slope_x = 0, slope_y = 0;                                   ///< of depth, 1/256 per pixel
    std::int32_t noise = 0;    ///< of depth about that plane, squared
    std::int32_t spread = 1;   ///< of its pixels along the narrower of x and y, squared
    std::int32_t quantum = 0;  ///< of depth: from one code to the next
    std::uint16_t label = 0;   ///< of its segment in the last frame; 0: none

    /// Of the plane: 1 / depth is even in the picture, so that log depth is bent.
    std::int32_t depth_at(std::int32_t at_x, std::int32_t at_y) const {
        constexpr std::int64_t bend = 11818;  // 2 PixelFeatures::depth_per_octave / ln 2
        const std::int64_t even =
            (std::int64_t{slope_x} * (at_x - x) + std::int64_t{slope_y} * (at_y - y)) >> 8;
        return static_cast<std::int32_t>(depth + even + even * even / bend);
    }
};

/// Cuts a picture into superpixels (SLIC, Achanta et al. 2012), one for each cell of a grid, that stay with
/// what they show from frame to frame. A pixel goes to the nearest of those of its cell and the eight around
/// it, in colour, in depth from the superpixel's plane, and in place.
class Superpixels {
public:
    static constexpr std::uint16_t none = 0xFFFF;

    Superpixels(int width, int height, int side);

    /// `known`: each pixel's label in the last frame, 0 where there is none or the pixel shows something
    /// else now. It stays with its label unless it is clearly nearer to a superpixel of another.
    void divide(const PixelFeatures& features, const std::vector<std::uint16_t>& known, RowBands& bands);
    /// The next frame has nothing of the last one.
    void forget();

    const std::vector<std::uint16_t>& of_pixels() const { return of_pixels_; }
    std::vector<Superpixel>& all() { return all_; }
    const std::vector<Superpixel>& all() const { return all_; }
    int columns() const { return columns_; }
    int rows() const { return rows_; }
    int side() const { return side_; }
    int width() const { return width_; }
    int height() const { return height_; }

private:
    /// Of the pixels of a superpixel, places from its cell's corner.
    struct Sums {
        std::int64_t pixels, x, y, brightness, red_green, yellow_blue, z, xx, xy, yy, xz, yz, zz;
        void operator+=(const Sums& other);
    };
    void seed(const PixelFeatures& features, const std::vector<std::uint16_t>& known);
    void assign(const PixelFeatures& features, const std::vector<std::uint16_t>& known, const RowBand& band);
    void add_up(const PixelFeatures& features, const RowBand& band);
    void update(std::size_t k);

    int width_, height_, side_, columns_, rows_;
    std::vector<int> column_ends_, row_ends_;  // where cells begin, and the last one ends
    std::vector<int> row_of_y_;
    bool is_new_ = true;
    std::vector<Superpixel> all_;
    std::vector<std::uint16_t> of_pixels_;
    std::vector<std::vector<Sums>> sums_;  // by thread
};

}  // namespace touchable
