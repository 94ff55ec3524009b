// SPDX-License-Identifier: Apache-2.0
#pragma once

// What pictures of depth show of their camera: levels of the codes, terraces and their widths, noise, and
// places that are smooth enough to try filters on.
//
// Each estimator takes the stored codes of frames, one by one, and returns its result on request; all count
// in integers or with + - x / sqrt alone, so that results are the same on every machine. One thread at a
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

/// A length that was measured at a depth, both in scene units and above zero, and its weight.
struct LengthAtDepth {
    double depth, length, weight;
};

/// Fits constant + quadratic depth^2 with the least squares of relative errors; neither is negative. Zero
/// without lengths.
DepthLength fitted_length(const std::vector<LengthAtDepth>& lengths);

/// Which codes of a recording occur, and how far apart they are. Integer counts and + - x / alone.
class LevelEstimator {
public:
    explicit LevelEstimator(const DepthCoding& coding) : coding_(coding), counts_(65536) {}

    void add(const CodePicture& picture);

    /// Depth nearer than which this share of the valid pixels is, scene units, without those at the far plane
    /// (backgrounds), unless there are no others: 50 for their median. Nothing without valid pixels.
    std::optional<double> depth_of_share(int hundredths) const;
    /// Distance between neighbouring depths that occur, if it is more than a code, as for codes rounded from
    /// something coarser, such as disparity. Zero if every code occurs, or if there is no rule.
    /// docs/conventions.md, Levels.
    DepthLength levels() const;

private:
    /// Counts of a code: its pixels, and how many of their right and upper neighbours are valid, or the same.
    struct CodeCount {
        std::int64_t pixels = 0, right = 0, same_right = 0, above = 0, same_above = 0;
    };
    /// Codes from `first` to before `end`, in which the distance of levels hardly changes.
    struct Window {
        std::int64_t pixels = 0;
        double depth = 0, distance = 0;  // of its middle, and between levels, scene units
    };

    std::optional<Window> window(int first, int end) const;
    std::vector<Window> windows() const;
    static DepthLength levels_of_floats(const std::vector<Window>& found);

    const DepthCoding coding_;
    std::vector<CodeCount> counts_;
};

/// Width and height of the terraces of coarsely stored depth.
struct Contours {
    int width = 0;   ///< pixels: a quarter of the measured ones lie on terraces at least so wide
    int height = 0;  ///< codes from one terrace to the next, if half of all steps have it; else 0

    /// Whether a terrace_reach of 16 leaves contour lines.
    bool are_wide() const { return width > 2 * least_terrace_reach; }
    /// The reach that makes slopes of them.
    int reach() const;
    /// Distance of levels; zero: every code is one.
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
    std::vector<std::int64_t> steps_ = std::vector<std::int64_t>(65536);  // number of steps by height, codes
    std::vector<Terrace> terraces_;                                       // with a step at either end
    std::vector<Tread> treads_;                                           // of a line
};

/// Sums by the size of values, so that those beyond a limit can be left out afterwards.
class ClippedSums {
public:
    void add(int size, std::int64_t product, std::int64_t square);

    struct Means {
        std::int64_t count = 0;
        double product = 0, square = 0;
    };
    /// Means without values larger than `limit`, then, three times, than four root mean squares of the rest.
    /// Count 0 if less than half is left.
    Means means(double limit) const;
    /// Number of values up to a size, to its highest three bits.
    std::int64_t count_to(double size) const;

private:
    struct Sum {
        std::int64_t count = 0, product = 0, square = 0;
    };
    std::array<Sum, 128> sums_{};  // by the size's highest three bits
};

/// Measures how much depths change from frame to frame though nothing moves, and from pixel to pixel though
/// the surface is flat. Integer sums and + - x / sqrt alone.
class NoiseEstimator {
public:
    explicit NoiseEstimator(const DepthCoding& coding);
    /// For flying pixels: depths that differ by no more than this share, 1/50, are one surface.
    static constexpr int flat_share = 50;

    /// Adds a frame. All have the same size. Of a large one only the rows that are measured are kept.
    void add(const CodePicture& picture);

    enum class Place { flat, edge, rim };  ///< rim: beside an invalid pixel
    /// Standard deviation of a depth from frame to frame, scene units. For a quantity that varies about a
    /// constant value, successive differences d, d' have the mean product -variance; for steady motion d d' >
    /// 0. So zero if most pixels move, and if nothing changes. Zero for unrelated pictures, too.
    DepthLength noise(Place place) const;
    /// Deviation of a depth from the plane of its eight neighbours, RMS over flat places, scene units.
    DepthLength roughness() const { return roughness_of(&Window::bends); }
    /// The same of the eight pixels two away, in the first picture: of white noise as much, of relief more.
    DepthLength wide_roughness() const { return roughness_of(&Window::wide_bends); }
    /// Share of flat places that are a tenth as rough, against a pixel's width, as they are on average, or
    /// less; of noise 0.08 to 0.2.
    double smooth() const;
    /// Share of flat places whose depth is another in one of three frames; 0 for fewer.
    double changing() const {
        return flat_ > 0 ? static_cast<double>(changed_) / static_cast<double>(flat_) : 0;
    }
    /// Share of the pixels valid in a frame and in the one after the next that are invalid in between. 0 for
    /// unrelated pictures.
    double dropouts() const {
        return kept_ > 0 && film() ? static_cast<double>(dropped_) / static_cast<double>(kept_) : 0;
    }
    /// Share of the pixels that are invalid with at least six of their eight neighbours valid.
    double tiny_holes() const { return share(tiny_holes_); }
    /// Share of the pixels that hang between two surfaces, at edges (landed, flying_pixels.hpp).
    double flying() const { return share(flying_); }
    /// Share of the pixels that are at least a quarter of the way from both: none at a rounded rim is.
    double midway() const { return share(midway_); }
    /// Share of the pixels, at edges, from which depth goes from one surface to another in one step, to the
    /// right or down.
    double clean_edges() const { return share(clean_edges_); }

private:
    struct Window {
        double depth = 0, step = 0;  ///< depth of its middle, and of one code there, scene units
        ClippedSums bends, wide_bends;
    };
    /// How much pixels change, by window and place.
    struct Changes {
        std::vector<std::array<ClippedSums, 3>> of;
        /// Pixels with a distant partner: their codes, and how much both change, by themselves and together.
        std::int64_t pairs = 0, code = 0, square = 0, product = 0, change = 0;

        explicit Changes(std::size_t windows = 0) : of(windows) {}
        /// Codes of a pixel and of its partner in three frames, and the changes that both windows have in
        /// common, to the middle frame and from it on.
        void add(std::size_t window, Place place, const std::array<int, 3>& codes,
                 const std::array<int, 3>& there, const std::array<int, 2>& common,
                 const std::array<int, 2>& common_there);
    };
    using Triple = std::array<const CodePicture*, 3>;

    double share(std::int64_t pixels) const {
        return pixels_ > 0 ? static_cast<double>(pixels) / static_cast<double>(pixels_) : 0;
    }
    Place place_of(const CodePicture& picture, int x, int y) const;
    /// Codes at a pixel's depth that differ by no more than this are one surface.
    int flat_codes(const Window& window) const;
    void look_at_edge(const CodePicture& picture, int x, int y);
    bool is_clean_edge(const CodePicture& picture, int x, int y) const;
    void look_at_pixel(const CodePicture& picture, int x, int y);
    DepthLength roughness_of(ClippedSums Window::*bends) const;
    void add_wide_bend(const CodePicture& picture, int x, int y);
    /// Visits each pixel that is measured and valid in the first and last of three pictures.
    template <class Visit>
    void each_kept(const Triple& pictures, const Visit& visit) const;
    /// The median change of a code in each window, to the middle one of three pictures and from it on.
    std::vector<std::array<int, 2>> common_changes(const Triple& pictures) const;
    void look_at_changes(const Triple& pictures);
    /// False for unrelated pictures. Their depths change like noise, too, but distant pixels change together,
    /// by about as much as depth varies over a picture. Distant pixels share none of a camera's noise.
    static bool is_film(const Changes& changes);
    /// The changes that tell noise: without those that pixels of one depth have in common, if a frame's gain
    /// or offset changes more than noise does. Null: unrelated pictures.
    const Changes* film() const;
    const Window& window_of(int code) const {
        return windows_[window_of_code_[static_cast<std::size_t>(code)]];
    }

    std::vector<Window> windows_;
    std::vector<std::uint8_t> window_of_code_;
    std::vector<CodePicture> last_;  // two at most
    int row_step_ = 1;               // of the rows that are measured, in these pictures
    std::int64_t kept_ = 0, dropped_ = 0, pixels_ = 0, tiny_holes_ = 0, flying_ = 0, midway_ = 0,
                 clean_edges_ = 0, flat_ = 0, changed_ = 0;
    Changes changes_, own_changes_;  // as they are, and less the common ones
};

/// Places of a recording whose surface is smooth, so that it is known better than from a single pixel: a
/// paraboloid of 1/depth fitted to 32x32 pixels. With 16 pixels around them, as far as filters reach, they
/// are put side by side into one small picture, a mosaic, on which filters are tried quickly. Integers and +
/// - x / sqrt alone: the same on every machine.
class SmoothPatches {
public:
    /// Chooses places in the last of some pictures of one size: in each of its 8x8 parts the smoothest place
    /// that is not all of one code; of these, those about as smooth as the best, without those that have a
    /// low relief if there are enough others. The pictures may be `cropped`. What is far rougher than `noise`
    /// from frame to frame and `levels` explain has relief of its own, even if that leaves too few places;
    /// without noise, which is not known then, none is.
    SmoothPatches(const Scene& scene, const std::deque<CodePicture>& pictures, const DepthLength& noise = {},
                  const DepthLength& levels = {});
    /// The columns and rows in which a place can lie: 1536 at most of each side.
    static CodePicture cropped(const CodePicture& picture);
    static constexpr int core = 32, side = 64, most_across = 8;
    /// Pixels along each side of a core whose faces are ignored, as the fit is less sure there.
    static constexpr int margin = 8;
    /// Fewer patches say nothing about a recording.
    static constexpr int fewest = 6;
    /// Useful number of pictures: the temporal filter has settled with the last one.
    static constexpr int frames = 8;

    bool enough() const { return patches_.size() >= fewest; }

    /// One per picture, with the scene's coding.
    const std::vector<RawFrame>& mosaics() const { return mosaics_; }
    /// The scene of the mosaics, without filters.
    const Scene& mosaic_scene() const { return mosaic_scene_; }

    /// A mosaic with a pen before each core: `wide` columns from `first` on, `height` scene units nearer.
    RawFrame with_pens(const RawFrame& mosaic, int first, int wide, double height) const;

    struct Place {
        int x, y;
    };
    /// First pixel of each patch's core, in the picture and in the mosaic.
    std::vector<std::pair<Place, Place>> places() const;
    /// Median depth of the places' middles, those with relief included: which have some may change with the
    /// noise that neighbours share.
    double median_depth() const { return median_depth_; }
    /// Deviation of the last picture's depths from their smooth surfaces, RMS, scene units: noise, levels and
    /// whatever else is no surface.
    DepthLength roughness() const;
    /// Deviation of the faces of a surface built from the last mosaic from these surfaces, RMS, degrees. A
    /// deviation of more than 60 degrees counts as 60.
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

    /// Calls visit(x, y, 1/depth as stored, w) for each pixel of a core that has a depth.
    template <class Visit>
    void each_depth(Pictures pictures, int left, int top, const Visit& visit) const;
    /// Fits to the same core in one picture, or several.
    Fit fitted(Pictures pictures, int left, int top) const;
    bool has_relief(Pictures pictures, const Patch& patch) const;
    const int* row_of(const CodePicture& picture, int x, int y) const;
    void choose(const CodePicture& picture);
    void drop_relief(const DepthLength& noise, const DepthLength& levels);
    void fit_to_all(Pictures pictures);
    RawFrame mosaic(const CodePicture& picture) const;

    const Scene scene_;
    std::vector<double> inverse_of_code_;
    Scene mosaic_scene_;
    int no_depth_ = 0;  // an invalid code
    std::vector<Patch> patches_;
    double median_depth_ = 0;
    std::vector<RawFrame> mosaics_;
};

/// Filters that were tried on a recording, and their result.
struct TriedFilters {
    bool temporal = false;  ///< with the measured noise
    int median = 0;         ///< 0, 3 or 5 pixels
    bool terraces = false;  ///< whether they are removed
    DepthLength levels;     ///< distance of levels for the removal
    double harshness = 0;   ///< the larger, the less is kept of edges and relief
    double left_deg = 0;    ///< deviation of faces from the smooth surface around them, RMS

    /// These filters in place of a scene's own. `noise`: from frame to frame, as measured.
    void apply(const DepthLength& noise, FilterSettings& filter) const;
};

/// The temporal filter's noise for a measured one: larger, so that two adjacent levels are averaged, too
/// (docs/measurements.md).
DepthLength stated_noise(const DepthLength& measured, int median);

/// Tries every median, without terrace removal and with it, for these levels, for levels as far apart as
/// depths are rough, and somewhat nearer and farther; all of them without the temporal filter and with it.
/// From the mildest to the harshest. Empty if too few places are smooth. `noise`: from frame to frame; zero:
/// there is nothing to average. Tries no more after a stop request.
std::vector<TriedFilters> tried_filters(const SmoothPatches& patches, const DepthLength& levels,
                                        const DepthLength& noise);

/// Tries no filter, and terrace removal of these levels alone; zero: every code is one.
std::vector<TriedFilters> tried_removal(const SmoothPatches& patches, const DepthLength& levels);

/// The tried filters, with the temporal filter or without it, from those that keep most on, each of which
/// leaves less than the one before: a detail of 1 is the first, of 0 the last. The mildest of the best is
/// one.
std::vector<const TriedFilters*> frontier(const std::vector<TriedFilters>& tried, bool temporal);
/// Height of the least pen, five pixels wide, of which filters keep 80 %, on the patches, at their median
/// depth, scene units; 0: any, as nothing is filtered; infinity: none.
double least_relief(const SmoothPatches& patches, const TriedFilters& filters, const DepthLength& noise);

/// The entry with this median, removal and averaging; null: it was not tried.
const TriedFilters* found_among(const std::vector<TriedFilters>& tried, const FilterSettings& filter);
/// The mildest entry, with the temporal filter or without it, that leaves hardly more than the best; null:
/// there is none.
const TriedFilters* mildest_of_the_best(const std::vector<TriedFilters>& tried, bool temporal);

}  // namespace touchable
