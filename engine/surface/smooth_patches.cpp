// SPDX-License-Identifier: Apache-2.0
// Smooth places of a recording, and filters tried on them.
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/code_rows.hpp"
#include "engine/surface/estimators.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

constexpr int border = (SmoothPatches::side - SmoothPatches::core) / 2;
constexpr int parts = 8;      // of the picture, across and down
constexpr int fit_terms = 6;  // of a paraboloid
constexpr double pixels_of_a_unit = 16;
/// Patches that are rougher than this times the lower quartile, relative to their pixels' width, have an edge
/// or a relief of their own.
constexpr double rough_per_quartile = 2.5;
/// Share of the core's pixels that may have no depth, or lie somewhere else altogether.
constexpr double most_left_out = 0.1;
constexpr int rounds_without_outliers = 3;
constexpr double outlier_per_residual = 4;
/// A place that is as rough in all pictures together as in one has not moved.
constexpr double moves_per_residual = 1.1;
/// Over 8x8 pixels of all pictures noise and levels hardly leave a mean: relative to the residual, 0.08 to
/// 0.3 was measured where nothing stands out, 0.35 to 2 beside relief (docs/measurements.md, Low relief).
constexpr double relief_per_residual = 1.0 / 3;
/// Blotches that stay make places 1.2 times as rough as noise and levels, in models of cameras.
constexpr double relief_per_explained = 1.5;
constexpr int relief_block = 8, relief_blocks = SmoothPatches::core / relief_block;

using Terms = std::array<double, fit_terms>;

Terms terms_at(double x, double y) {
    return {1, x, y, x * x, x * y, y * y};
}

double sum_of(const Terms& of, const Terms& terms) {
    double sum = 0;
    for (int n = 0; n < fit_terms; ++n)
        sum += of[static_cast<std::size_t>(n)] * terms[static_cast<std::size_t>(n)];
    return sum;
}

/// Sums of least squares, and their solution by elimination with the largest pivot.
struct LeastSquares {
    std::array<Terms, fit_terms> products{};
    Terms values{};

    void add(const Terms& terms, double value) {
        for (std::size_t r = 0; r < fit_terms; ++r) {
            for (std::size_t c = r; c < fit_terms; ++c) products[r][c] += terms[r] * terms[c];
            values[r] += terms[r] * value;
        }
    }
    std::optional<Terms> solved() {
        for (std::size_t r = 1; r < fit_terms; ++r)
            for (std::size_t c = 0; c < r; ++c) products[r][c] = products[c][r];
        for (std::size_t k = 0; k < fit_terms; ++k) {
            std::size_t pivot = k;
            for (std::size_t r = k + 1; r < fit_terms; ++r)
                if (std::fabs(products[r][k]) > std::fabs(products[pivot][k])) pivot = r;
            if (std::fabs(products[pivot][k]) < 1e-9) return std::nullopt;
            std::swap(products[k], products[pivot]);
            std::swap(values[k], values[pivot]);
            for (std::size_t r = 0; r < fit_terms; ++r) {
                if (r == k) continue;
                const double share = products[r][k] / products[k][k];
                for (std::size_t c = k; c < fit_terms; ++c) products[r][c] -= share * products[k][c];
                values[r] -= share * values[k];
            }
        }
        Terms found{};
        for (std::size_t k = 0; k < fit_terms; ++k) found[k] = values[k] / products[k][k];
        return found;
    }
};

/// Begin of the n-th place of 64 pixels along a side.
constexpr int places_of_a_side = 3 * parts;
int begin_of_place(int n, int length) {
    return (length - SmoothPatches::side) * n / (places_of_a_side - 1);
}

/// Number of pixels before `at` that lie in a place.
int kept_before(int at, int length) {
    if (length <= places_of_a_side * SmoothPatches::side) return at;
    int kept = 0, end = 0;
    for (int n = 0; n < places_of_a_side; ++n) {
        const int begin = begin_of_place(n, length);
        kept += std::max(0, std::min(begin + SmoothPatches::side, at) - std::max(begin, end));
        end = begin + SmoothPatches::side;
    }
    return kept;
}

double middle_of(int pixel) {
    return (pixel - (SmoothPatches::core - 1) / 2.0) / pixels_of_a_unit;
}

/// Normal of a face of inverse depth w at (x, y) that grows by `right` and `down` from pixel to pixel.
glm::dvec3 face_normal(const Camera& camera, double x, double y, double w, double right, double down) {
    return {-right * camera.fx, down * camera.fy, w + right * (camera.cx - x) + down * (camera.cy - y)};
}

/// The square of the chord of the angle between two directions, at most 1: that of 60 degrees.
double chord_square(const glm::dvec3& a, const glm::dvec3& b) {
    const double lengths = glm::dot(a, a) * glm::dot(b, b);
    if (!(lengths > 0)) return 1;
    return std::clamp(2 - 2 * glm::dot(a, b) / std::sqrt(lengths), 0.0, 1.0);  // rounding may go below 0
}

Scene scene_of_mosaic(const Scene& scene) {
    Scene mosaic;
    mosaic.width = mosaic.height = SmoothPatches::side;
    mosaic.camera = scene.camera;
    mosaic.depth_bits = 16;
    mosaic.depth = scene.depth;
    mosaic.metres_per_unit = scene.metres_per_unit;
    mosaic.filter = {};
    if (mosaic.depth.kind == DepthCodingKind::hue) {  // its codes are even steps of depth
        mosaic.depth.kind = DepthCodingKind::linear;
        mosaic.depth.least_sum = 0;
    }
    return mosaic;
}

/// Distances of levels for the removal, relative to the sensor's least step, and the largest one after each
/// median: chosen so that a step of four of these stays sharp, and a pen of that height is kept
/// (docs/measurements.md).
constexpr double per_least_step[] = {0, 0.2, 0.3, 0.45, 0.7, 1, 1.2, 1.4, 2, 2.8};
constexpr double most_after_median[] = {1.4, 0, 0, 1, 0, 0.7};
/// If these leave more, levels up to twice as far apart are tried: relief so low is lost in such noise.
constexpr double much_deg = 3;
/// The least step is a level, or a step that would be as rough as depths are: levels l apart are l/sqrt(12)
/// rough. Levels count if they are visible, even in noise that is somewhat rougher; codes count if little
/// else is rough.
constexpr double level_per_roughness = 3.4641, seen_levels_from = 0.75, codes_from = 0.75;
/// The temporal filter's noise setting over the measured noise, by the median before it.
constexpr double stated_per_measured[] = {0.9, 0, 0, 1.4, 0, 1.5};
/// Filters are as good as the best if they leave up to this factor of it, or at most these degrees.
constexpr double as_good = 1.10, good_deg = 0.7;
/// A point of the frontier leaves at most this share of what the one before leaves.
constexpr double of_point_before = 0.99;
/// Cost of a median in a low pen's relief, as the least steps by which levels would be wider
/// (docs/measurements.md, Low relief).
constexpr double harshness_of_median[] = {0, 0, 0, 0.17, 0, 0.37};

DepthLength least_step(const DepthLength& levels, const DepthLength& codes, const DepthLength& roughness,
                       double depth) {
    const DepthLength rough = roughness.times(level_per_roughness);
    const auto counts = [&](const DepthLength& of, double from) {
        return !(of == DepthLength{}) && of.at(depth) >= from * rough.at(depth);
    };
    if (counts(levels, seen_levels_from)) return levels;
    return counts(codes, codes_from) ? codes : rough;
}

/// The surface of the last mosaic, with the scene's filters.
void build(const Scene& scene, const std::vector<RawFrame>& mosaics, SurfaceFrame& built) {
    const FilterPlan plan(scene);
    const auto filters = make_code_filters(plan, usable_vector_units().front());
    RowBands alone(1);
    if (plan.remembers())
        for (std::size_t n = 0; n + 1 < mosaics.size(); ++n) filters->remember(mosaics[n], alone, built);
    filters->make_all(mosaics.back(), alone, built);
    built.coding = plan.coding();
}

double left_by(const Scene& scene, const SmoothPatches& patches) {
    SurfaceFrame built;
    build(scene, patches.mosaics(), built);
    return patches.faces_off_deg(built);
}

}  // namespace

SmoothPatches::SmoothPatches(const Scene& scene, const std::deque<CodePicture>& pictures,
                             const DepthLength& noise, const DepthLength& levels)
    : scene_(scene), inverse_of_code_(65536), mosaic_scene_(scene_of_mosaic(scene)) {
    for (int code = scene.depth.valid_min; code <= scene.depth.valid_max; ++code)
        inverse_of_code_[static_cast<std::size_t>(code)] =
            1 / scene.depth.depth(static_cast<std::uint16_t>(code));
    while (no_depth_ < 65535 && mosaic_scene_.depth.is_valid(static_cast<std::uint16_t>(no_depth_)))
        ++no_depth_;
    if (!pictures.empty()) choose(pictures.back());
    if (!(noise == DepthLength{})) drop_relief(noise, levels);
    if (!enough()) return;
    std::vector<const CodePicture*> all;
    for (const CodePicture& picture : pictures) all.push_back(&picture);
    fit_to_all(all);
    const int count = static_cast<int>(patches_.size()), across = std::min(count, most_across);
    mosaic_scene_.width = across * side;
    mosaic_scene_.height = (count + across - 1) / across * side;
    for (const CodePicture& picture : pictures) {
        mosaics_.push_back(mosaic(picture));
        mosaics_.back().number = static_cast<std::int64_t>(mosaics_.size());
    }
}

CodePicture SmoothPatches::cropped(const CodePicture& picture) {
    const int width = picture.width, height = picture.height;
    if (width < side || height < side) return picture;
    CodePicture kept{kept_before(width, width), kept_before(height, height), {}};
    if (kept.width == width && kept.height == height) return picture;
    kept.codes.reserve(pixel_count(kept.width, kept.height));
    for (int y = 0; y < height; ++y) {
        if (kept_before(y + 1, height) == kept_before(y, height)) continue;
        int end = 0;
        for (int n = 0; n < places_of_a_side; ++n) {
            const int begin = begin_of_place(n, width);
            const int* const row = picture.row(y);
            kept.codes.insert(kept.codes.end(), row + std::max(begin, end), row + begin + side);
            end = begin + side;
        }
    }
    return kept;
}

/// The codes from a pixel of a place on, in the cropped picture.
const int* SmoothPatches::row_of(const CodePicture& picture, int x, int y) const {
    return picture.row(kept_before(y, scene_.height)) + kept_before(x, scene_.width);
}

template <class Visit>
void SmoothPatches::each_depth(Pictures pictures, int left, int top, const Visit& visit) const {
    const bool is_range = scene_.depth.semantics == DepthSemantics::range;
    for (const CodePicture* const picture : pictures)
        for (int y = 0; y < core; ++y) {
            const int* const row = row_of(*picture, left, top + y);
            for (int x = 0; x < core; ++x) {
                if (row[x] == CodePicture::invalid) continue;
                const double inverse = inverse_of_code_[static_cast<std::size_t>(row[x])];
                visit(x, y, inverse,
                      is_range ? inverse * scene_.camera.ray_length(left + x, top + y) : inverse);
            }
        }
}

SmoothPatches::Fit SmoothPatches::fitted(Pictures pictures, int left, int top) const {
    const double all = core * core * static_cast<double>(pictures.size());
    // Visits every pixel that has a depth, and lies within the limit of the previous fit.
    Fit fit;
    double limit = std::numeric_limits<double>::infinity();
    double least = 0, most = 0;  // of the last visit
    const auto each = [&](const auto& visit) {
        least = std::numeric_limits<double>::infinity();
        most = 0;
        each_depth(pictures, left, top, [&](int x, int y, double inverse, double w) {
            const Terms terms = terms_at(middle_of(x), middle_of(y));
            if (std::fabs(w - sum_of(fit.of, terms)) > limit) return;
            least = std::min(least, inverse);
            most = std::max(most, inverse);
            visit(terms, w);
        });
    };
    for (int round = 0; round < rounds_without_outliers; ++round) {
        LeastSquares sums;
        int count = 0;
        each([&](const Terms& terms, double w) {
            sums.add(terms, w);
            ++count;
        });
        const auto found = count >= (1 - most_left_out) * all ? sums.solved() : std::nullopt;
        // A place of one code, such as a background, says nothing about levels or noise.
        if (!found || least == most) return {};
        double squares = 0, farthest = 0;
        each([&](const Terms& terms, double w) {
            const double off = w - sum_of(*found, terms);
            squares += off * off;
            farthest = std::max(farthest, std::fabs(off));
        });
        fit = {*found, std::sqrt(squares / count), true};
        limit = outlier_per_residual * fit.residual;
        if (round == 0 && farthest <= limit) break;  // nothing is left out, so all rounds are equal
    }
    return fit;
}

void SmoothPatches::choose(const CodePicture& picture) {
    const int width = scene_.width, height = scene_.height;
    if (width < side || height < side) return;
    std::vector<std::pair<double, Patch>> best;
    for (int part_y = 0; part_y < parts; ++part_y)
        for (int part_x = 0; part_x < parts; ++part_x) {
            std::optional<std::pair<double, Patch>> found;
            for (int k = 0; k < 9; ++k) {
                const int left = border + begin_of_place(3 * part_x + k % 3, width),
                          top = border + begin_of_place(3 * part_y + k / 3, height);
                const CodePicture* const last[] = {&picture};
                const Fit fit = fitted(last, left, top);
                if (!fit.ok || !(fit.of[0] > 0)) continue;
                // Relative to a pixel's width: an error e of w is e/w^2 of depth, and a pixel is 1/(w fx).
                const double rough = fit.residual / fit.of[0];
                if (!found || rough < found->first) found = {rough, Patch{left, top, fit}};
            }
            if (found) best.push_back(*found);
        }
    if (best.empty()) return;
    std::vector<double> all;
    for (const auto& [rough, patch] : best) all.push_back(rough);
    const double limit = rough_per_quartile * quantile(all, 0.25);
    for (const auto& [rough, patch] : best)
        if (rough <= limit) patches_.push_back(patch);
}

/// Whether a block of the core is off the fit on average.
bool SmoothPatches::has_relief(Pictures pictures, const Patch& patch) const {
    std::array<double, relief_blocks * relief_blocks> sums{}, counts{};
    each_depth(pictures, patch.x, patch.y, [&](int x, int y, double, double w) {
        const auto block = static_cast<std::size_t>(y / relief_block * relief_blocks + x / relief_block);
        sums[block] += w - sum_of(patch.fit.of, terms_at(middle_of(x), middle_of(y)));
        ++counts[block];
    });
    for (std::size_t n = 0; n < sums.size(); ++n)
        if (std::fabs(sums[n]) > relief_per_residual * patch.fit.residual * counts[n]) return true;
    return false;
}

/// Drops what is rougher than noise and rounding to levels explain.
void SmoothPatches::drop_relief(const DepthLength& noise, const DepthLength& levels) {
    const DepthLength codes = code_step(scene_.depth);
    std::erase_if(patches_, [&](const Patch& patch) {
        const double depth = 1 / patch.fit.of[0], rough = patch.fit.residual * depth * depth,
                     level = std::max(levels.at(depth), codes.at(depth)), moving = noise.at(depth);
        constexpr double most = relief_per_explained * relief_per_explained;
        return rough * rough > most * (moving * moving + level * level / 12);
    });
}

/// Fits places that do not move to all pictures, which say more than one. Drops places with relief: if
/// filters keep it, it would count as noise that they leave.
void SmoothPatches::fit_to_all(Pictures pictures) {
    std::vector<double> depths;
    for (const Patch& patch : patches_) depths.push_back(1 / patch.fit.of[0]);
    median_depth_ = depths.empty() ? 0 : quantile(depths, 0.5);
    std::vector<Patch> flat;
    for (Patch& patch : patches_) {
        const Fit fit = fitted(pictures, patch.x, patch.y);
        const bool stands_still = fit.ok && fit.residual <= moves_per_residual * patch.fit.residual;
        if (stands_still) patch.fit.of = fit.of;
        if (!has_relief(stands_still ? pictures : pictures.last(1), patch)) flat.push_back(patch);
    }
    // One picture does not tell relief from noise that neighbours share; what most places have is noise.
    const std::size_t least =
        pictures.size() > 1 ? fewest : std::max<std::size_t>(fewest, patches_.size() / 2);
    if (flat.size() >= least) patches_ = std::move(flat);
}

RawFrame SmoothPatches::mosaic(const CodePicture& picture) const {
    const int width = mosaic_scene_.width, height = mosaic_scene_.height, across = width / side;
    const auto place = [width](int x, int y) { return pixel_place(x, y, width); };
    const auto none = static_cast<std::uint16_t>(no_depth_);
    auto codes = std::make_shared<std::vector<std::uint16_t>>(place(0, height), none);
    for (int n = 0; n < static_cast<int>(patches_.size()); ++n) {
        const Patch& patch = patches_[static_cast<std::size_t>(n)];
        for (int y = 0; y < side; ++y) {
            const int* from = row_of(picture, patch.x - border, patch.y - border + y);
            std::uint16_t* to = codes->data() + place(n % across * side, n / across * side + y);
            for (int x = 0; x < side; ++x)
                to[x] = from[x] == CodePicture::invalid ? none : static_cast<std::uint16_t>(from[x]);
        }
    }
    RawFrame raw;
    raw.depth = plane_of_codes(codes->data(), width, height);
    raw.storage = std::move(codes);
    return raw;
}

RawFrame SmoothPatches::with_pens(const RawFrame& mosaic, int first, int wide, double height) const {
    const DepthCoding& coding = mosaic_scene_.depth;
    const int width = mosaic_scene_.width;
    auto codes = std::make_shared<std::vector<std::uint16_t>>(pixel_count(width, mosaic_scene_.height));
    for (int y = 0; y < mosaic_scene_.height; ++y)
        for (int x = 0; x < width; ++x) {
            std::uint16_t code = stored_code(mosaic.depth, coding, x, y);
            const int column = x % side - border - first, row = y % side - border;
            if (coding.is_valid(code) && column >= 0 && column < wide && row >= 0 && row < core)
                code = coding.code(coding.depth(code) - height);
            (*codes)[pixel_place(x, y, width)] = code;
        }
    RawFrame raw;
    raw.number = mosaic.number;
    raw.depth = plane_of_codes(codes->data(), width, mosaic_scene_.height);
    raw.storage = std::move(codes);
    return raw;
}

std::vector<std::pair<SmoothPatches::Place, SmoothPatches::Place>> SmoothPatches::places() const {
    const int across = mosaic_scene_.width / side;
    std::vector<std::pair<Place, Place>> places;
    for (int n = 0; n < static_cast<int>(patches_.size()); ++n)
        places.push_back({{patches_[static_cast<std::size_t>(n)].x, patches_[static_cast<std::size_t>(n)].y},
                          {n % across * side + border, n / across * side + border}});
    return places;
}

DepthLength SmoothPatches::roughness() const {
    std::vector<LengthAtDepth> lengths;
    for (const Patch& patch : patches_) {
        if (!patch.fit.ok || !(patch.fit.residual > 0)) continue;
        const double depth = 1 / patch.fit.of[0];
        lengths.push_back(
            {depth, patch.fit.residual * depth * depth, 1});  // an error e of w is e depth^2 of depth
    }
    return fitted_length(lengths);
}

double SmoothPatches::faces_off_deg(const SurfaceFrame& built) const {
    const Camera& camera = scene_.camera;
    const bool is_range = scene_.depth.semantics == DepthSemantics::range;
    const std::vector<std::pair<Place, Place>> all = places();
    double squares = 0;
    std::int64_t faces = 0;
    for (std::size_t n = 0; n < patches_.size(); ++n) {
        const Patch& patch = patches_[n];
        if (!patch.fit.ok) continue;
        const int left = all[n].second.x, top = all[n].second.y;
        // w of a vertex of the core; 0 without depth.
        const auto w = [&](int x, int y) {
            if (!built.is_valid(left + x, top + y)) return 0.0;
            const double depth = built.coding.depth(built.codes[built.index(left + x, top + y)]);
            return is_range ? camera.ray_length(patch.x + x, patch.y + y) / depth : 1 / depth;
        };
        for (int y = margin; y < core - margin; ++y)
            for (int x = margin; x < core - margin; ++x) {
                const double w00 = w(x, y), w10 = w(x + 1, y), w01 = w(x, y + 1), w11 = w(x + 1, y + 1);
                if (!(w00 > 0 && w10 > 0 && w01 > 0 && w11 > 0)) continue;
                const double u = middle_of(x) + 0.5 / pixels_of_a_unit,
                             v = middle_of(y) + 0.5 / pixels_of_a_unit;
                const auto& of = patch.fit.of;
                const double at = sum_of(of, terms_at(u, v));
                const double right = (of[1] + 2 * of[3] * u + of[4] * v) / pixels_of_a_unit,
                             down = (of[2] + of[4] * u + 2 * of[5] * v) / pixels_of_a_unit;
                const double px = patch.x + x + 0.5, py = patch.y + y + 0.5;
                const glm::dvec3 smooth = face_normal(camera, px, py, at, right, down);
                squares += chord_square(smooth, face_normal(camera, px, py, at, w10 - w00, w11 - w10)) +
                           chord_square(smooth, face_normal(camera, px, py, at, w11 - w01, w01 - w00));
                faces += 2;
            }
    }
    return faces == 0 ? 60 : std::sqrt(squares / static_cast<double>(faces)) * 180 / pi;
}

DepthLength stated_noise(const DepthLength& measured, int median) {
    return measured.times(stated_per_measured[median]);
}

std::vector<TriedFilters> tried_filters(const SmoothPatches& patches, const DepthLength& levels,
                                        const DepthLength& noise) {
    std::vector<TriedFilters> tried;
    if (!patches.enough()) return tried;
    const double depth = patches.median_depth();
    const DepthLength codes = code_step(patches.mosaic_scene().depth),
                      least = least_step(levels, codes, patches.roughness(), depth);
    const auto with = [&](Scene scene, double harshness) {
        if (stop_requested()) return;
        const auto keep = [&] {
            const FilterSettings& filter = scene.filter;
            tried.push_back({filter.temporal, filter.median, filter.terraces == TerraceRemoval::on,
                             filter.levels, harshness, left_by(scene, patches)});
        };
        keep();
        if (noise == DepthLength{}) return;
        scene.filter.temporal = true;
        scene.filter.temporal_noise = stated_noise(noise, scene.filter.median);
        keep();
    };
    // Levels between these multiples of the largest ones after each median.
    const auto with_levels = [&](double above, double up_to) {
        for (const int median : {0, 3, 5})
            for (const double factor : per_least_step) {
                if (factor <= above * most_after_median[median] || factor > up_to * most_after_median[median])
                    continue;
                Scene scene = patches.mosaic_scene();
                scene.filter.median = median;
                scene.filter.terraces = factor > 0 ? TerraceRemoval::on : TerraceRemoval::off;
                scene.filter.levels = least.times(factor);
                if (factor == 0 ||
                    (has_working_codes(scene) &&
                     scene.filter.levels.at(depth) >= std::max(levels.at(depth), codes.at(depth))))
                    with(scene, harshness_of_median[median] + factor);
            }
    };
    with_levels(-1, 1);
    const auto best = std::ranges::min_element(tried, {}, &TriedFilters::left_deg);
    if (best != tried.end() && best->left_deg > much_deg) with_levels(1, 2);
    std::ranges::stable_sort(tried, {}, &TriedFilters::harshness);
    return tried;
}

std::vector<TriedFilters> tried_removal(const SmoothPatches& patches, const DepthLength& levels) {
    Scene scene = patches.mosaic_scene();
    if (!patches.enough()) return {};
    std::vector<TriedFilters> tried(1);
    tried[0].left_deg = left_by(scene, patches);
    scene.filter.terraces = TerraceRemoval::on;
    scene.filter.levels = levels;
    if (has_working_codes(scene)) tried.push_back({false, 0, true, levels, 1, left_by(scene, patches)});
    return tried;
}

void TriedFilters::apply(const DepthLength& noise, FilterSettings& filter) const {
    filter.median = median;
    filter.terraces = terraces ? TerraceRemoval::on : TerraceRemoval::off;
    filter.levels = levels;
    filter.temporal = temporal;
    if (temporal) filter.temporal_noise = stated_noise(noise, median);
}

std::vector<const TriedFilters*> frontier(const std::vector<TriedFilters>& tried, bool temporal) {
    const TriedFilters* const usual = mildest_of_the_best(tried, temporal);
    std::vector<const TriedFilters*> points;
    for (const TriedFilters& one : tried) {
        const double enough =
            points.empty() ? 180 : (&one == usual ? 1 : of_point_before) * points.back()->left_deg;
        const bool may_be = points.empty() ? !one.temporal : one.temporal == temporal;
        if (may_be && one.left_deg < enough) points.push_back(&one);
    }
    return points;
}

double least_relief(const SmoothPatches& patches, const TriedFilters& filters, const DepthLength& noise) {
    constexpr int first = SmoothPatches::core / 2 - 3, wide = 5, rows = SmoothPatches::core;
    constexpr double kept_share = 0.8, finest = 0.25, coarsest = 64;
    Scene scene = patches.mosaic_scene();
    filters.apply(noise, scene.filter);
    if (!filters.terraces && filters.median == 0 && !filters.temporal) return 0;
    SurfaceFrame without, with;
    build(scene, patches.mosaics(), without);
    const double depth = patches.median_depth();
    // The share of a pen's height that is left of it, in the three columns in its middle.
    const std::span<const RawFrame> all = patches.mosaics();
    const auto kept = [&](double height) {
        if (stop_requested()) return 1.0;
        std::vector<RawFrame> mosaics;
        for (const RawFrame& mosaic : filters.temporal ? all : all.last(1))
            mosaics.push_back(patches.with_pens(mosaic, first, wide, height));
        build(scene, mosaics, with);
        double sum = 0, count = 0;
        for (const auto& [from, to] : patches.places())
            for (int y = to.y; y < to.y + rows; ++y)
                for (int x = to.x + first + 1; x < to.x + first + wide - 1; ++x) {
                    if (!with.is_valid(x, y) || !without.is_valid(x, y)) continue;
                    sum += without.coding.depth(without.codes[without.index(x, y)]) -
                           with.coding.depth(with.codes[with.index(x, y)]);
                    ++count;
                }
        return count > 0 ? sum / count / height : 0;
    };
    const double unit = std::max(filters.levels.at(depth), code_step(scene.depth).at(depth));
    double height = finest * unit;
    while (kept(height) < kept_share) {
        if (height >= coarsest * unit) return std::numeric_limits<double>::infinity();
        height *= 2;
    }
    for (double factor = std::sqrt(0.5); factor < 0.95; factor = std::sqrt(factor))
        if (kept(height * factor) >= kept_share) height *= factor;
    return height;
}

const TriedFilters* found_among(const std::vector<TriedFilters>& tried, const FilterSettings& filter) {
    const bool removed = filter.terraces == TerraceRemoval::on;
    if (removed && filter.terrace_reach != least_terrace_reach) return nullptr;
    for (const TriedFilters& one : tried)
        if (one.temporal == filter.temporal && one.median == filter.median && one.terraces == removed &&
            (!removed || one.levels == filter.levels))
            return &one;
    return nullptr;
}

const TriedFilters* mildest_of_the_best(const std::vector<TriedFilters>& tried, bool temporal) {
    double best = 180;
    for (const TriedFilters& one : tried)
        if (one.temporal == temporal) best = std::min(best, one.left_deg);
    const double enough = std::max(good_deg, as_good * best);
    for (const TriedFilters& one : tried)
        if (one.temporal == temporal && one.left_deg <= enough) return &one;
    return nullptr;
}

}  // namespace touchable
