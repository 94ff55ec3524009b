#pragma once

// What pictures of depth tell of the camera that took them: levels in which codes lie, terraces and how wide
// they are, noise, and places that are smooth enough to try filters on.
//
// Each estimator is given the stored codes of frames, one by one, and answers when asked; all count in
// integers or with + - x / sqrt alone, so that the answers are the same on every machine. One thread at a
// time.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// A length that was measured at a depth, both in scene units and above zero, and how much it counts.
struct LengthAtDepth {
    double depth, length, weight;
};

/// constant + quadratic depth^2 with the least squares of relative errors; neither is negative. Zero without
/// lengths.
DepthLength fitted_length(const std::vector<LengthAtDepth>& lengths);

/// Which codes of a recording occur, and how far they are apart. Integer counts and + - x / alone.
class LevelEstimator {
public:
    explicit LevelEstimator(const DepthCoding& coding) : coding_(coding), counts_(65536) {}

    void add(const CodePicture& picture);

    /// Of the valid pixels, scene units, without those at the far plane, where backgrounds are, unless there
    /// are no others. Nothing where there were none.
    std::optional<double> median_depth() const;
    /// How far neighbouring depths that occur are apart, where that is more than a code: as of codes that
    /// were rounded from something coarser, such as disparity. Zero where every code occurs, and where what
    /// occurs has no rule. docs/conventions.md, Levels.
    DepthLength levels() const;

private:
    /// Of a code: how often it occurs, and how many of its right and upper neighbours are valid, or the same.
    struct CodeCount {
        std::int64_t pixels = 0, right = 0, same_right = 0, above = 0, same_above = 0;
    };
    /// Codes from `first` to before `end`, among which levels are as far apart.
    struct Window {
        std::int64_t pixels = 0;
        double depth = 0, distance = 0;  // of its middle, and from level to level, scene units
    };

    std::optional<Window> window(int first, int end) const;
    std::vector<Window> windows() const;
    static DepthLength levels_of_floats(const std::vector<Window>& found);

    const DepthCoding coding_;
    std::vector<CodeCount> counts_;
};

/// How wide and how high the terraces of coarsely stored depth are.
struct Contours {
    int width = 0;   ///< pixels: a quarter of what is no step lies on terraces at least so wide
    int height = 0;  ///< codes from one terrace to the next, where half of all steps have it; otherwise 0

    /// Whether a terrace_reach of 16 leaves contour lines.
    bool are_wide() const { return width > 2 * least_terrace_reach; }
    /// That makes slopes of them.
    int reach() const;
    /// How far levels are apart; zero: every code is one.
    DepthLength levels(const DepthCoding& coding) const;
    bool operator==(const Contours&) const = default;
};

/// Measures terraces along rows and columns of pictures: treads, which are runs of one code, and the steps
/// between them, which may be short ramps, as where a phone has enlarged its depth. Integers alone: the same
/// on every machine.
class ContourEstimator {
public:
    void add(const CodePicture& picture);
    Contours contours() const;

private:
    struct Tread {
        int first = 0, end = 0, code = 0;
    };
    struct Terrace {
        int width, step, code;  // pixels; the higher one of its two steps, codes; its own code
        bool goes_on;           // both steps go up, or both down, as on a slope
    };

    void add_line(const int* codes, std::ptrdiff_t stride, int count);
    int height() const;

    std::int64_t narrow_ = 0;  // pixels in shorter runs than treads
    std::vector<std::int64_t> steps_ = std::vector<std::int64_t>(65536);  // how many are so many codes high
    std::vector<Terrace> terraces_;                                       // with a step at either end
    std::vector<Tread> treads_;                                           // of a line
};

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
    double dropouts() const {
        return kept_ > 0 && is_film() ? static_cast<double>(dropped_) / static_cast<double>(kept_) : 0;
    }
    /// Share of the pixels that are invalid, and at least six of their eight neighbours are valid.
    double tiny_holes() const { return share(tiny_holes_); }
    /// Share of the pixels that hang between two surfaces, at edges (landed, flying_pixels.hpp).
    double flying() const { return share(flying_); }
    /// Of those, share of the pixels that are a quarter of the way or more from both: no rounded rim is.
    double midway() const { return share(midway_); }
    /// Share of the pixels, at edges, from which depth goes from one surface to another in one step, to the
    /// right or down.
    double clean_edges() const { return share(clean_edges_); }

private:
    struct Window {
        double depth = 0, step = 0;  ///< of its middle, and of one code there, scene units
        std::array<ClippedSums, 3> changes;
        ClippedSums bends;
    };

    double share(std::int64_t pixels) const {
        return pixels_ > 0 ? static_cast<double>(pixels) / static_cast<double>(pixels_) : 0;
    }
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
    const Window& window_of(int code) const {
        return windows_[window_of_code_[static_cast<std::size_t>(code)]];
    }

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

/// Filters that were tried on a recording, and what they leave.
struct TriedFilters {
    bool temporal = false;  ///< with the noise that was measured
    int median = 0;         ///< 0, 3 or 5 pixels
    bool terraces = false;  ///< whether they are removed
    DepthLength levels;     ///< how far apart removal takes levels to be
    double harshness = 0;   ///< the more, the less is kept of edges and relief
    double left_deg = 0;    ///< how far faces of the surface are off the smooth surface around them, RMS
};

/// The noise that the temporal filter is given where this was measured: more, so that two levels beside each
/// other, too, are averaged (docs/measurements.md).
DepthLength stated_noise(const DepthLength& measured, int median);

/// Every median, without terrace removal and with it, of levels as far apart as these, or as rough depths
/// would have, and somewhat nearer and farther; all of them without the temporal filter and with it. From the
/// mildest to the harshest. Nothing where too few places are smooth. `noise`: from frame to frame; zero:
/// there is nothing to average. Once it is asked to stop it tries no more.
std::vector<TriedFilters> tried_filters(const SmoothPatches& patches, const DepthLength& levels,
                                        const DepthLength& noise);

/// No filter, and terrace removal of these levels alone; zero: every code is one.
std::vector<TriedFilters> tried_removal(const SmoothPatches& patches, const DepthLength& levels);

/// That with this median, removal and averaging; null: it was not tried.
const TriedFilters* found_among(const std::vector<TriedFilters>& tried, const FilterSettings& filter);
/// Of those with the temporal filter, or without it, the mildest that leaves hardly more than the best; null:
/// there is none.
const TriedFilters* mildest_of_the_best(const std::vector<TriedFilters>& tried, bool temporal);

}  // namespace touchable
