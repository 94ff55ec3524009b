#include "engine/content/displaced_sphere.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

/// The root of `gap` in [outside, inside], where it is above 0 outside and at most 0 inside, by false
/// position; an end that stays twice counts half (Illinois).
template <class Gap>
double crossing(double outside, double gap_outside, double inside, double gap_inside, Gap&& gap) {
    int stayed = 0;  // +: the inside, -: the outside
    for (int round = 0; round < 100 && gap_inside < 0 && inside - outside > 1e-15; ++round) {
        const double share = round < 30 ? gap_outside / (gap_outside - gap_inside) : 0.5;
        const double middle = outside + (inside - outside) * share;
        if (middle == outside || middle == inside) return middle;
        const double gap_middle = gap(middle);
        if (gap_middle > 0) {
            outside = middle;
            gap_outside = gap_middle;
            if (stayed > 0) gap_inside *= 0.5;
            stayed = 1;
        } else {
            inside = middle;
            gap_inside = gap_middle;
            if (stayed < 0) gap_outside *= 0.5;
            stayed = -1;
        }
    }
    return inside;
}

}  // namespace

DisplacedSphere::DisplacedSphere(CubeGrid grid, std::vector<float> rise, RowBands& rows)
    : grid_(std::move(grid)), rise_(std::move(rise)) {
    for (const float value : rise_) highest_ = std::max<double>(highest_, value);
    const int coarse_side = grid_.cells() / 16;
    coarse_ = tiles_of(coarse_side, rows);
    fine_ = tiles_of(coarse_side / 8, rows);
    const Tiles unwidened = coarse_;
    widen(fine_, unwidened, rows);
    widen(coarse_, unwidened, rows);
}

double DisplacedSphere::rise(const glm::dvec3& direction) const {
    return rise_at(grid_.place(direction));
}

DisplacedSphere::Bound DisplacedSphere::bound_of_cells(int face, int column, int row, int side) const {
    const auto at = [&](int i, int j) { return rise_[grid_.index(face, i, j)]; };
    Bound bound{};
    for (int j = row * side; j < (row + 1) * side; ++j)
        for (int i = column * side; i < (column + 1) * side; ++i) {
            const float a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
            const double across = std::max(std::fabs(b - a), std::fabs(d - c)),
                         down = std::max(std::fabs(c - a), std::fabs(d - b));
            const double steepness = std::sqrt(across * across + down * down) / grid_.least_spacing();
            bound.highest = std::max({bound.highest, a, b, c, d});
            bound.steepest = std::max(bound.steepest, static_cast<float>(1.000001 * steepness));
        }
    return bound;
}

DisplacedSphere::Tiles DisplacedSphere::tiles_of(int side, RowBands& rows) const {
    const int count = grid_.cells() / side;
    Tiles tiles{side, count, side * grid_.least_spacing()};
    const std::size_t all = tiles.index(6, 0, 0);
    tiles.middles.resize(all);
    tiles.radii.resize(all);
    tiles.bounds.resize(all);
    rows.for_each_band(6 * count, 1, [&](const RowBand& band) {
        for (int line = band.first; line < band.last; ++line)
            for (int column = 0; column < count; ++column) {
                const int face = line / count, row = line % count;
                const std::size_t tile = tiles.index(face, column, row);
                tiles.bounds[tile] = bound_of_cells(face, column, row, side);
                const int left = column * side, top = row * side;
                const glm::dvec3 middle = grid_.direction(face, left + side / 2, top + side / 2);
                double least = 1;
                for (const int i : {left, left + side})
                    for (const int j : {top, top + side})
                        least = std::min(least, glm::dot(middle, grid_.direction(face, i, j)));
                tiles.middles[tile] = middle;
                tiles.radii[tile] = 0.5 * pi - arcsine(least);
            }
    });
    return tiles;
}

/// Each bound becomes that of all tiles that something within the window of its tile may lie in. Only those
/// in coarse tiles that are near enough are looked at.
void DisplacedSphere::widen(Tiles& tiles, const Tiles& coarse, RowBands& rows) const {
    const std::vector<Bound> own = tiles.bounds;
    const double widest = *std::max_element(tiles.radii.begin(), tiles.radii.end()),
                 widest_coarse = *std::max_element(coarse.radii.begin(), coarse.radii.end());
    const auto cosine_within = [](double angle) { return angle < pi ? cosine(1.01 * angle) : -1.0; };
    const int inside = coarse.side / tiles.side;  // tiles along a coarse one
    const auto each_in = [&](std::size_t coarse_tile, auto&& visit) {
        const int n = static_cast<int>(coarse_tile), face = n / (coarse.count * coarse.count),
                  row = n / coarse.count % coarse.count, column = n % coarse.count;
        for (int j = 0; j < inside; ++j)
            for (int i = 0; i < inside; ++i) visit(tiles.index(face, column * inside + i, row * inside + j));
    };
    rows.for_each_band(static_cast<int>(coarse.middles.size()), 1, [&](const RowBand& band) {
        for (int n = band.first; n < band.last; ++n) {
            const auto here = static_cast<std::size_t>(n);
            const double near = cosine_within(coarse.radii[here] + tiles.window + widest_coarse);
            for (std::size_t there = 0; there < coarse.middles.size(); ++there) {
                if (glm::dot(coarse.middles[here], coarse.middles[there]) < near) continue;
                each_in(here, [&](std::size_t tile) {
                    const double nearest = cosine_within(tiles.radii[tile] + tiles.window + widest);
                    each_in(there, [&](std::size_t other) {
                        if (glm::dot(tiles.middles[tile], tiles.middles[other]) < nearest) return;
                        Bound& bound = tiles.bounds[tile];
                        bound.highest = std::max(bound.highest, own[other].highest);
                        bound.steepest = std::max(bound.steepest, own[other].steepest);
                    });
                });
            }
        }
    });
}

/// Along the ray, s from where it is nearest to the middle (at distance q): its own distance is sqrt(q^2 +
/// s^2), which is convex, and the angle that it turns is at most q ds, as long as it is outside of the unit
/// sphere. So the bounds say how far it may go without passing the surface.
std::optional<double> DisplacedSphere::first_hit(const glm::dvec3& from, const glm::dvec3& ray) const {
    const double to_nearest = -glm::dot(from, ray);
    const glm::dvec3 nearest = from + to_nearest * ray;
    const double q_square = glm::dot(nearest, nearest), q = std::sqrt(q_square);
    const double outermost = 1 + highest_;
    if (q >= outermost) return std::nullopt;
    // Where it enters the sphere of this radius, which it meets.
    const auto entry = [&](double radius) { return -std::sqrt(radius * radius - q_square); };
    const auto distance_at = [&](double s) { return std::sqrt(q_square + s * s); };
    const auto gap_at = [&](double s) { return distance_at(s) - 1 - rise(nearest + s * ray); };
    const bool meets_inner = q < 1;
    const double end = meets_inner ? entry(1) : -entry(outermost);

    constexpr double unknown = -1;
    double s = entry(outermost), before = s, gap_before = unknown;
    const auto root_up_to = [&](double inside, double gap) {
        if (gap_before == unknown) gap_before = gap_at(before);
        return to_nearest + (gap_before > 0 ? crossing(before, gap_before, inside, gap, gap_at) : before);
    };
    while (s < end) {
        const double distance = distance_at(s);
        const CubePlace place = grid_.place(nearest + s * ray);
        const Bound& far_bound = coarse_.at(place);
        const bool is_far = distance > 1.0 + far_bound.highest;
        const Bound& bound = is_far ? far_bound : fine_.at(place);
        const double top = 1.0 + bound.highest;
        double next = s + (is_far ? coarse_ : fine_).window / std::max(q, 1e-9);
        double gap = unknown;
        if (const double enters = s < 0 && q < top ? entry(top) : end; distance > top && enters > s) {
            next = std::min(next, enters);
        } else {
            gap = distance - 1 - rise_at(place);
            if (gap <= 0) return s == before ? to_nearest + s : root_up_to(s, gap);
            const double climbing = bound.steepest * q, falling = -s / distance;
            // Over level ground it would meet the surface there; a little beyond may be inside.
            const double beyond = falling > 0 ? s + 1.25 * gap / falling : end;
            if (beyond < std::min(next, end) && -beyond / distance_at(beyond) > climbing)
                if (const double inside = gap_at(beyond); inside <= 0)  // there is one crossing at most
                    return to_nearest + crossing(s, gap, beyond, inside, gap_at);
            if (climbing + falling > 0) next = std::min(next, s + gap / (climbing + falling));
        }
        before = s;
        gap_before = gap;
        s = std::max(next, s + least_step);
    }
    if (!meets_inner) return std::nullopt;
    const double inside = -rise(nearest + end * ray);
    return inside == 0 ? to_nearest + end : root_up_to(end, inside);
}

}  // namespace touchable
