#pragma once

#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/authoring/superpixels.hpp"
#include "engine/scene/camera.hpp"

namespace touchable {

/// Merges neighbouring superpixels to regions, those first that differ least: by the step of depth between
/// their planes, by the crease between them, where concave ones count more, as one thing standing on another
/// makes them, and by colour.
class RegionMerging {
public:
    /// `smallest`: pixels of the smallest region that stays one.
    RegionMerging(const Camera& camera, std::int32_t smallest) : camera_(camera), smallest_(smallest) {}

    /// The region of each superpixel, which is the number of one of its superpixels. Superpixels that had
    /// one label (`labels`, by superpixel; 0: not known) stay together unless they differ clearly, and those
    /// that had two stay apart unless they clearly do not.
    const std::vector<std::uint16_t>& merge(const Superpixels& superpixels,
                                            const std::vector<std::uint16_t>& labels);

private:
    /// Between two superpixels, or two regions.
    struct Border {
        std::int64_t length = 0, x = 0, y = 0;  ///< pixels, and the sums of their places
        // Sums over its length: squared differences of colour; steps of depth, from the other to this one;
        // creases, concave ones above 0. Noise, which goes either way, leaves little of the last two.
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

}  // namespace touchable
