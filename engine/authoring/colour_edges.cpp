#include "engine/authoring/colour_edges.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "engine/surface/code_picture.hpp"

namespace touchable {
namespace {

constexpr float silhouette = 0.05F;  // a step by more of the depth is one
constexpr float same_surface = 0.02F;
constexpr int widest_shadow = 3 * 8;  // steps without depth beside a near surface that a camera leaves
constexpr std::int64_t fewest = 200;  // edges that say something
constexpr int least_contrast = 60;    // of 765

using Rgb = std::array<int, 3>;

}  // namespace

/// One row or column of a frame.
struct ColourEdges::Line {
    const PlaneView* colour;
    const float* depths;  // of all pixels, 0 where invalid
    int width, length, fixed;
    bool is_row;

    std::size_t index(int i) const {
        return is_row ? static_cast<std::size_t>(fixed) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(i)
                      : static_cast<std::size_t>(i) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(fixed);
    }
    bool has(int i) const { return i >= 0 && i < length; }
    float depth(int i) const { return depths[index(i)]; }
    Rgb rgb(int i) const {
        Rgb rgb;
        for (int c = 0; c < 3; ++c)
            rgb[static_cast<std::size_t>(c)] = colour->sample(is_row ? i : fixed, is_row ? fixed : i, c);
        return rgb;
    }
};

ColourEdges::ColourEdges(const Scene& scene) : coding_(scene.depth), step_(std::max(1, scene.width / 640)) {}

void ColourEdges::add(const RawFrame& frame, std::vector<std::uint8_t>* where) {
    const CodePicture codes = code_picture(frame.depth, coding_);
    depths_.resize(codes.codes.size());
    std::transform(codes.codes.begin(), codes.codes.end(), depths_.begin(), [&](int code) {
        return code == CodePicture::invalid
                   ? 0.0F
                   : static_cast<float>(coding_.depth(static_cast<std::uint16_t>(code)));
    });
    for (const bool is_row : {true, false}) {
        const int lines = is_row ? codes.height : codes.width, length = is_row ? codes.width : codes.height;
        for (int fixed = 0; fixed < lines; fixed += step_) {
            const Line line{&frame.colour, depths_.data(), codes.width, length, fixed, is_row};
            for (int i = 1; i + 1 < length; ++i) {
                const float here = line.depth(i);
                if (here == 0.0F) continue;
                for (const int side : {1, -1}) {
                    const float beside = line.depth(i + side);
                    if (beside == 0.0F || beside > here * (1 + silhouette))
                        look(line, i, is_row ? (side > 0 ? to_right : to_left) : (side > 0 ? down : up),
                             where);
                }
            }
        }
    }
}

/// Whether a surface that is even as far as is looked ends at `at`, `out` being the step away from it, before
/// another one that is even, too. That may begin beyond a shadow without depth.
bool ColourEdges::is_silhouette(const Line& line, int at, int out) {
    const float near = line.depth(at);
    for (int k = 1; k <= reach; ++k)
        if (std::abs(line.depth(at - k * out) - near) > near * same_surface) return false;
    float far = 0;
    for (int k = 1; k <= widest_shadow && line.has(at + k * out); ++k) {
        const float depth = line.depth(at + k * out);
        if (depth == 0.0F) continue;
        if (far == 0.0F) far = depth;
        if (far <= near * (1 + silhouette)) return false;
        if (k <= reach + 1 && std::abs(depth - far) > far * same_surface) return false;
    }
    return far != 0.0F;
}

/// How many steps beyond `at` the surface's colour ends; nothing: it cannot be told.
std::optional<int> ColourEdges::offset_of_colour(const Line& line, int at, int out) {
    const auto mean = [&](int first, int last) {
        Rgb sum{};
        for (int k = first; k <= last; ++k) {
            const Rgb rgb = line.rgb(at + k * out);
            for (std::size_t c = 0; c < 3; ++c) sum[c] += rgb[c];
        }
        for (int& value : sum) value /= last - first + 1;
        return sum;
    };
    const Rgb inside = mean(-reach, 3 - reach), outside = mean(reach - 2, reach + 1);
    int contrast = 0, square = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        contrast += std::abs(outside[c] - inside[c]);
        square += (outside[c] - inside[c]) * (outside[c] - inside[c]);
    }
    if (contrast < least_contrast) return std::nullopt;
    // Pixels that are more of the near colour than of the far one; they must be on one side.
    int near_pixels = 0, changes = 0;
    bool was_near = true;
    for (int k = -reach; k <= reach + 1; ++k) {
        const Rgb rgb = line.rgb(at + k * out);
        int along = 0;
        for (std::size_t c = 0; c < 3; ++c) along += (rgb[c] - inside[c]) * (outside[c] - inside[c]);
        const bool is_near = 2 * along < square;
        near_pixels += is_near ? 1 : 0;
        changes += is_near != was_near ? 1 : 0;
        was_near = is_near;
    }
    const int offset = near_pixels - (reach + 1);  // 0: the last near pixel is the surface's last
    if (changes != 1 || offset < -reach || offset > reach) return std::nullopt;
    return offset;
}

/// The last pixel of a surface is at `at`.
void ColourEdges::look(const Line& line, int at, Facing facing, std::vector<std::uint8_t>* where) {
    const int out = facing == to_right || facing == down ? step_ : -step_;
    if (!line.has(at - reach * out) || !line.has(at + (reach + 1) * out)) return;
    if (!is_silhouette(line, at, out)) return;
    const auto offset = offset_of_colour(line, at, out);
    if (!offset) return;
    ++counts_[facing][static_cast<std::size_t>(*offset + reach)];
    if (where != nullptr && std::abs(*offset) >= 2) (*where)[line.index(at)] = 1;
}

std::int64_t ColourEdges::count(Facing facing) const {
    std::int64_t sum = 0;
    for (const std::int64_t n : counts_[facing]) sum += n;
    return sum;
}

/// Between whole numbers as far as the ones beside it are uneven.
double ColourEdges::median(Facing facing) const {
    const double half = static_cast<double>(count(facing)) / 2;
    double below = 0;
    for (int k = 0; k < offsets; ++k) {
        const auto n = static_cast<double>(counts_[facing][static_cast<std::size_t>(k)]);
        if (n > 0 && below + n >= half) return (k - reach - 0.5 + (half - below) / n) * step_;
        below += n;
    }
    return 0;
}

/// Those that are no more than two samples away from it.
std::int64_t ColourEdges::near_median(Facing facing) const {
    const int middle = static_cast<int>(std::lround(median(facing) / step_)) + reach;
    std::int64_t sum = 0;
    for (int k = std::max(0, middle - 2); k <= std::min(offsets - 1, middle + 2); ++k)
        sum += counts_[facing][static_cast<std::size_t>(k)];
    return sum;
}

/// 1 where too few edges face either way.
double ColourEdges::agreement(Facing a, Facing b) const {
    const std::int64_t edges = count(a) + count(b);
    if (edges < fewest / 2) return 1;
    return static_cast<double>(near_median(a) + near_median(b)) / static_cast<double>(edges);
}

std::optional<ColourEdges::Fit> ColourEdges::fit() const {
    Fit fit;
    double rims = 0;
    for (const Facing facing : {to_right, to_left, down, up}) {
        fit.edges += count(facing);
        rims -= median(facing) * static_cast<double>(count(facing));
    }
    if (fit.edges < fewest) return std::nullopt;
    fit.rim = rims / static_cast<double>(fit.edges);
    fit.agreement = std::min(agreement(to_right, to_left), agreement(down, up));
    const auto shift = [&](Facing a, Facing b) -> std::optional<double> {
        if (std::min(count(a), count(b)) < fewest / 4) return std::nullopt;
        return (median(a) - median(b)) / 2;
    };
    fit.right = shift(to_right, to_left);
    fit.below = shift(down, up);
    // Edges that face one way only cannot tell a shift from a rim.
    if (fit.right && fit.below)
        fit.rim = -(median(to_right) + median(to_left) + median(down) + median(up)) / 4;
    else if (fit.right)
        fit.rim = -(median(to_right) + median(to_left)) / 2;
    else if (fit.below)
        fit.rim = -(median(down) + median(up)) / 2;
    return fit;
}

}  // namespace touchable
