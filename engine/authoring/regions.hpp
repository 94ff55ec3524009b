// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <map>
#include <tuple>

#include "engine/authoring/segmentation.hpp"
#include "engine/base/threads.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A group of similar pixels that lie together: a patch of one surface, with the plane through it.
struct Superpixel {
    std::int32_t x = 0, y = 0;                                               ///< its middle
    std::int32_t pixels = 0;                                                 ///< 0: there is none in its cell
    std::int32_t brightness = 0, red_green = 0, yellow_blue = 0, depth = 0;  ///< means; depth at its middle
    std::int32_t slope_x = 0, slope_y = 0;                                   ///< of depth, 1/256 per pixel
    std::int32_t noise = 0;    ///< of depth about that plane, squared
    std::int32_t spread = 1;   ///< of its pixels along the narrower of x and y, squared
    std::int32_t quantum = 0;  ///< of depth: from one code to the next
    std::uint16_t label = 0;   ///< of its segment in the last frame; 0: none

    /// Depth of the plane: 1 / depth is linear in the picture, so that log depth is bent.
    std::int32_t depth_at(std::int32_t at_x, std::int32_t at_y) const {
        constexpr std::int64_t bend = 11818;  // 2 PixelFeatures::depth_per_octave / ln 2
        const std::int64_t even =
            (std::int64_t{slope_x} * (at_x - x) + std::int64_t{slope_y} * (at_y - y)) >> 8;
        return static_cast<std::int32_t>(depth + even + even * even / bend);
    }
};

/// Cuts a picture into superpixels (SLIC, Achanta et al. 2012), one for each cell of a grid, that follow
/// their surface from frame to frame. A pixel joins the nearest superpixel of its cell and the eight around
/// it, by colour, depth from the superpixel's plane, and place.
class Superpixels {
public:
    static constexpr std::uint16_t none = 0xFFFF;

    Superpixels(int width, int height, int side);

    /// `known`: each pixel's label in the last frame, 0 if it had none or shows something else now. A pixel
    /// keeps its label unless it is clearly nearer to a superpixel with another.
    void divide(const PixelFeatures& features, const std::vector<std::uint16_t>& known, RowBands& bands);
    /// Forgets the last frame: the next one has nothing in common with it.
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
    /// Sums over the pixels of a superpixel; places from its cell's corner.
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

/// Merges neighbouring superpixels to regions, the least different first: by the step of depth between their
/// planes, by the crease between them, where concave ones count more, as one thing standing on another makes
/// them, and by colour.
class RegionMerging {
public:
    /// `smallest`: pixels of the smallest region that stays one.
    RegionMerging(const Camera& camera, std::int32_t smallest) : camera_(camera), smallest_(smallest) {}

    /// Returns the region of each superpixel, which is the number of one of its superpixels. Superpixels with
    /// one label (`labels`, by superpixel; 0: not known) stay together unless they clearly differ, and those
    /// with two labels stay apart unless they are clearly alike.
    const std::vector<std::uint16_t>& merge(const Superpixels& superpixels,
                                            const std::vector<std::uint16_t>& labels);

private:
    /// The border between two superpixels, or two regions.
    struct Border {
        std::int64_t length = 0, x = 0, y = 0;  ///< pixels, and the sums of their places
        // Sums over its length: squared differences of colour; steps of depth, from the other to this one;
        // creases, concave ones above 0. Noise of either sign nearly cancels in the last two.
        std::int64_t colour = 0, step = 0, crease = 0;
    };
    struct Region {
        std::int64_t pixels = 0, brightness = 0, red_green = 0, yellow_blue = 0;  ///< sums
        std::uint16_t label = 0;
        std::uint32_t version = 0;
        std::vector<std::pair<std::uint16_t, Border>> borders;  ///< by region, ascending
    };
    struct Candidate {
        std::int64_t difference;
        std::uint16_t a, b;
        std::uint32_t version_a, version_b;
        /// For a heap whose top differs least.
        bool operator<(const Candidate& other) const {
            return std::tie(difference, a, b) > std::tie(other.difference, other.a, other.b);
        }
    };
    struct Normal {
        std::int64_t x = 0, y = 0, z = 0, doubt = 0;
        std::int64_t point_x = 0, point_y = 0;
    };

    void find_borders(const Superpixels& superpixels);
    void find_normals(const Superpixels& superpixels);
    void measure(const std::vector<Superpixel>& all, std::size_t a, std::size_t b, Border& border) const;
    std::int64_t difference(std::size_t a, std::size_t b, const Border& border) const;
    void make_regions(const Superpixels& superpixels, const std::vector<std::uint16_t>& labels);
    void share_borders(const Superpixels& superpixels);
    void offer(std::size_t region);
    void join(std::size_t into, std::size_t from);
    void join_alike();

    const Camera camera_;
    const std::int32_t smallest_;
    std::vector<Border> table_;
    std::vector<Normal> normals_;
    std::vector<Region> regions_;
    std::vector<Candidate> queue_;
    std::vector<std::uint16_t> region_of_;
};

/// Gives small islands to the region that they touch most: islands of fewer than `smallest` pixels that are
/// not their whole region. `regions`: row by row; `none`: no region.
class RegionCleaning {
public:
    static constexpr std::uint16_t none = 0xFFFF;
    void clean(std::vector<std::uint16_t>& regions, int width, int height, std::int32_t smallest);

private:
    struct Run {
        std::int32_t first, last, row;
        std::uint16_t region;
        std::uint32_t island;
    };
    /// Number of pixels along which a small island, by its first run, touches each region.
    using Contacts = std::map<std::uint32_t, std::map<std::uint16_t, std::int32_t>>;

    void find_runs(const std::vector<std::uint16_t>& regions, int width, int height);
    template <class Touch>
    void for_each_contact(Touch&& touch) const;
    std::uint32_t island_of(std::uint32_t run);
    void find_islands();
    Contacts contacts_of_small(std::int32_t smallest);

    std::vector<Run> runs_;
    std::vector<std::uint32_t> row_begins_;
};

}  // namespace touchable
