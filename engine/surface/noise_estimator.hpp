#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/scene/code_curve.hpp"
#include "engine/surface/code_picture.hpp"

namespace touchable {

/// Sums over values of about the same size, so that those beyond a limit can be left out afterwards.
class ClippedSums {
public:
    void add(int size, std::int64_t product, std::int64_t square);

    struct Means {
        std::int64_t count = 0;
        double product = 0, square = 0;
    };
    /// Without what is larger than `limit`, then, three times, than four root mean squares of the rest.
    /// Count 0 where that leaves less than half.
    Means means(double limit) const;

private:
    struct Sum {
        std::int64_t count = 0, product = 0, square = 0;
    };
    std::array<Sum, 128> sums_{};  // by a size's highest three bits
};

/// How much the depths of a recording change from frame to frame though nothing moves, and from pixel to
/// pixel though the surface is flat. Integer sums and + - x / sqrt alone.
class NoiseEstimator {
public:
    explicit NoiseEstimator(const DepthCoding& coding);
    /// Depths that differ by no more than this share, 1/50, are one surface, as far as flying pixels go.
    static constexpr int flat_share = 50;

    /// The next frame. All have the same size. Of a large one only the rows that are looked at are kept.
    void add(const CodePicture& picture);

    enum class Place { flat, edge, rim };  ///< rim: beside an invalid pixel
    /// Standard deviation of a depth from frame to frame, scene units. Of a quantity that goes up and down
    /// about a value, successive differences d, d' have the mean product -variance; what moves steadily has
    /// d d' > 0. So zero where most pixels move, and where nothing changes. Zero for unrelated pictures, too.
    DepthLength noise(Place place) const;
    /// How far a depth is off the plane of its eight neighbours, RMS over flat places, scene units.
    DepthLength roughness() const;
    /// Of the pixels that are valid in a frame and in the one after the next: those that are not in between.
    /// 0 for unrelated pictures.
    double dropouts() const;
    /// Share of the pixels that are invalid, and at least six of their eight neighbours are valid.
    double tiny_holes() const;
    /// Share of the pixels that hang between two surfaces, at edges (landed, flying_pixels.hpp).
    double flying() const;
    /// Of those, share of the pixels that are a quarter of the way or more from both: no rounded rim is.
    double midway() const;
    /// Share of the pixels, at edges, from which depth goes from one surface to another in one step, to the
    /// right or down.
    double clean_edges() const;

private:
    struct Window {
        double depth = 0, step = 0;  ///< of its middle, and of one code there, scene units
        std::array<ClippedSums, 3> changes;
        ClippedSums bends;
    };

    Place place_of(const CodePicture& picture, int x, int y) const;
    /// Codes at a pixel's depth that differ by no more are one surface.
    int flat_codes(const Window& window) const;
    void look_at_edge(const CodePicture& picture, int x, int y);
    bool is_clean_edge(const CodePicture& picture, int x, int y) const;
    void look_at_pixel(const CodePicture& picture, int x, int y);
    /// Of pictures of which every `step`th row is looked at.
    void look_at_changes(const CodePicture& before, const CodePicture& here, const CodePicture& after,
                         int step);
    /// False for unrelated pictures. Their depths change like noise, too, but pixels far apart change
    /// together, by about as much as depth varies over a picture. Pixels far apart share none of a camera's
    /// noise.
    bool is_film() const;
    const Window& window_of(int code) const;

    std::vector<Window> windows_;
    std::vector<std::uint8_t> window_of_code_;
    std::vector<CodePicture> last_;  // two at most
    std::int64_t kept_ = 0, dropped_ = 0, pixels_ = 0, tiny_holes_ = 0, flying_ = 0, midway_ = 0,
                 clean_edges_ = 0;
    /// Pixels with a partner far away: their codes, and how much both change together.
    struct {
        std::int64_t count = 0, code = 0, square = 0, product = 0;
    } pairs_;
};

}  // namespace touchable
