// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/cast.hpp"

namespace touchable {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The lines of one family (x, y, or x - y integer) that a way start + s delta crosses, in order. Lines
/// beyond the ring do not bend the surface and are left out.
class LatticeLines {
public:
    LatticeLines(double start, double delta, double first, double last)
        : start_(start), delta_(delta), first_(first), last_(last) {
        seek(0.0);
    }
    /// Makes the first line after parameter s the next one.
    void seek(double s) {
        const double at = start_ + s * delta_;
        next_from(std::floor(at), at == std::floor(at));
    }
    /// The start is known exactly, as line `base` plus a fraction in [-1, 1]: a line through the start is not
    /// crossed.
    void start_at(std::int64_t base, double fraction) {
        const double whole = std::floor(fraction);
        next_from(static_cast<double>(base) + whole, fraction == whole);
    }
    double line() const { return line_; }
    /// Parameter of the next line; infinite after the last one.
    double parameter() const {
        if (delta_ == 0 || line_ < first_ || line_ > last_) return infinity;
        return (line_ - start_) / delta_;
    }
    void advance() { line_ += delta_ > 0 ? 1 : -1; }

private:
    void next_from(double below, bool on_line) {
        if (delta_ > 0) {
            line_ = std::max(below + 1, first_);
        } else {
            line_ = std::min(on_line ? below - 1 : below, last_);
        }
    }

    double start_, delta_, first_, last_, line_ = 0;
};

/// Walks tiles along one axis: index of the tile, and the parameter at which the way leaves it.
class TileSteps {
public:
    TileSteps(double start, double delta, int tile, int tiles)
        : start_(start), delta_(delta), tile_(tile), tiles_(tiles) {}
    int tile() const { return tile_; }
    double exit() const {
        if (delta_ > 0 && tile_ + 1 < tiles_) return ((tile_ + 1) * TileGrid::cells - start_) / delta_;
        if (delta_ < 0 && tile_ > 0) return (tile_ * TileGrid::cells - start_) / delta_;
        return infinity;
    }
    void advance() { tile_ += delta_ > 0 ? 1 : -1; }

private:
    double start_, delta_;
    int tile_, tiles_;
};

int tile_of(double coordinate, int tiles) {
    const double tile = std::floor(coordinate / TileGrid::cells);
    return static_cast<int>(std::clamp(tile, 0.0, static_cast<double>(tiles - 1)));
}

/// One straight way through the chart, and its height above the surface.
template <class Space>
class Way {
public:
    Way(const Space& space, const ChartPoint& from, const ChartPoint& to)
        : space_(space), from_(from), to_(to) {}

    double dx() const { return to_.x - from_.x; }
    double dy() const { return to_.y - from_.y; }
    double x(double s) const { return s >= 1 ? to_.x : from_.x + s * dx(); }
    double y(double s) const { return s >= 1 ? to_.y : from_.y + s * dy(); }
    double w(double s) const { return s >= 1 ? to_.w : from_.w + s * (to_.w - from_.w); }
    ChartPoint at(double s) const { return {x(s), y(s), w(s)}; }

    double above_surface(double s) const { return w(s) - surface_w(space_, face_under(x(s), y(s))); }
    double above_vertical(double s, double line) const {
        const double at = y(s), j = std::floor(at);
        return above_edge(s, line, j, line, j + 1, at - j);
    }
    double above_horizontal(double s, double line) const {
        const double at = x(s), i = std::floor(at);
        return above_edge(s, i, line, i + 1, line, at - i);
    }
    double above_diagonal(double s, double line) const {
        const double at = y(s), j = std::floor(at), i = j + line;
        return above_edge(s, i, j, i + 1, j + 1, at - j);
    }

private:
    double above_edge(double s, double i0, double j0, double i1, double j1, double fraction) const {
        auto vertex_w = [this](double i, double j) {
            return space_.vertex(static_cast<std::int64_t>(i), static_cast<std::int64_t>(j)).w;
        };
        return w(s) - along_edge(vertex_w(i0, j0), vertex_w(i1, j1), fraction);
    }
    const Space& space_;
    ChartPoint from_, to_;
};

/// Cast between two points of the chart: tiles whose bound lies below the way are skipped; in the others
/// every line that bends the surface is tested.
template <class Space>
class SurfaceCast {
public:
    SurfaceCast(const Space& space, const ChartPoint& from, const ChartPoint& to, int& lines, int line_limit)
        : space_(space),
          way_(space, from, to),
          vertical_(from.x, way_.dx(), -1, space.field().width()),
          horizontal_(from.y, way_.dy(), -1, space.field().height()),
          diagonal_(from.x - from.y, way_.dx() - way_.dy(), -1.0 - space.field().height(),
                    space.field().width() + 1.0),
          lines_(lines),
          line_limit_(line_limit) {}

    /// `start`: the surface point at which the way begins, if it begins on the surface.
    Cast run(const ChartPoint& from, const Place* start) {
        if (start) {
            vertical_.start_at(start->i, start->a);
            horizontal_.start_at(start->j, start->b);
            diagonal_.start_at(start->i - start->j, start->a - start->b);
        }
        const TileGrid tiles = space_.field().tiles();
        TileSteps column(from.x, way_.dx(), tile_of(from.x, tiles.tiles_x), tiles.tiles_x);
        TileSteps row(from.y, way_.dy(), tile_of(from.y, tiles.tiles_y), tiles.tiles_y);
        double begin = 0;
        bool known = start != nullptr;  // above_ holds the height at `begin`
        above_ = 0;
        while (true) {
            const double column_exit = column.exit(), row_exit = row.exit();
            const double end = std::max(begin, std::min({1.0, column_exit, row_exit}));
            if (std::min(way_.w(begin), way_.w(end)) > space_.largest_w(column.tile(), row.tile())) {
                seek(end);
                known = false;
            } else {
                if (!known) above_ = std::max(0.0, way_.above_surface(begin));
                if (walk(begin, end)) return found_;
                known = true;
            }
            if (end >= 1.0) return found_;
            (column_exit <= row_exit ? column : row).advance();
            begin = end;
        }
    }

private:
    void seek(double s) {
        vertical_.seek(s);
        horizontal_.seek(s);
        diagonal_.seek(s);
    }

    /// True if the search has ended.
    bool walk(double begin, double end) {
        double s = begin;
        while (true) {
            if (lines_ >= line_limit_) {
                found_.cut = space_.position(way_.at(s));
                return true;
            }
            const double sv = vertical_.parameter(), sh = horizontal_.parameter(), sd = diagonal_.parameter();
            const double next = std::min({sv, sh, sd});
            if (!(next < end)) break;
            double above;
            if (sv == next) {
                above = way_.above_vertical(next, vertical_.line());
                vertical_.advance();
            } else if (sh == next) {
                above = way_.above_horizontal(next, horizontal_.line());
                horizontal_.advance();
            } else {
                above = way_.above_diagonal(next, diagonal_.line());
                diagonal_.advance();
            }
            if (look(s, std::max(s, next), above)) return true;
            s = std::max(s, next);
        }
        return look(s, end, way_.above_surface(end));
    }

    /// Between two looks the height above the surface is linear; below at the second: a hit in between.
    bool look(double s0, double s1, double above) {
        ++lines_;
        if (above >= 0) {
            above_ = above;
            return false;
        }
        const double s = s0 + (s1 - s0) * (above_ / (above_ - above));
        const double x = way_.x(s), y = way_.y(s);
        // The face is the one in which the interval lies, whatever rounding says of the hit itself.
        const double middle = s0 + 0.5 * (s1 - s0);
        Place face = face_under(way_.x(middle), way_.y(middle));
        // Beyond the ring, where no line bends the surface, the interval runs through many faces.
        const HeightField& field = space_.field();
        const bool in_ring =
            face.i >= -1 && face.i < field.width() && face.j >= -1 && face.j < field.height();
        if (!in_ring) face = face_under(x, y);
        found_.hit = face_or_rim_place(face.feature, face.i, face.j, x - static_cast<double>(face.i),
                                       y - static_cast<double>(face.j));
        return true;
    }

    const Space& space_;
    Way<Space> way_;
    LatticeLines vertical_, horizontal_, diagonal_;
    double above_ = 0;
    int& lines_;
    const int line_limit_;
    Cast found_;
};

}  // namespace

double PixelSpace::level_of(double depth) const {
    const DepthCoding& coding = field_.scene().depth;
    return kappa_ * (255.0 * (coding.far - depth) / (coding.far - coding.near));
}

std::optional<glm::dvec3> PixelSpace::from_world(const glm::dvec3& point) const {
    if (!(point.z < 0)) return std::nullopt;
    const Scene& scene = field_.scene();
    const auto image = project(scene.camera, point);
    if (!image || !(std::abs(image->x) < farthest_pixel) || !(std::abs(image->y) < farthest_pixel))
        return std::nullopt;
    double depth = image->planar_depth;
    if (scene.depth.semantics == DepthSemantics::range) depth *= scene.camera.ray_length(image->x, image->y);
    const double level = level_of(depth);
    if (!std::isfinite(level)) return std::nullopt;
    return glm::dvec3{image->x, -image->y, level};
}

glm::dvec3 PixelSpace::to_world(const glm::dvec3& point) const {
    const Scene& scene = field_.scene();
    const double x = point.x, y = -point.y;
    const double depth = scene.depth.far - point.z / kappa_ * scene.depth.level();
    return unproject(scene.camera, x, y, planar_depth(scene.camera, scene.depth.semantics, x, y, depth));
}

SpaceVertex PixelSpace::compute_vertex(std::int64_t i, std::int64_t j) const {
    const FieldVertex vertex = field_.vertex(i, j);
    const double level = level_of(vertex.depth);
    return {{static_cast<double>(i), -static_cast<double>(j), level}, level, vertex.valid};
}

double PixelSpace::largest_w(int tile_x, int tile_y) const {
    const double level = level_of(field_.nearest_depth(tile_x, tile_y));
    return level + 1e-12 * std::abs(level);
}

double kappa_at(const Scene& scene, const glm::dvec3& point) {
    constexpr double nearest = 1e-15;  // nearer than the surface of any scene
    return scene.depth.level() * scene.camera.fx / std::max(-point.z, nearest);
}

template <class Space>
Cast cast(const Space& space, const glm::dvec3& from, const Place* from_surface, const glm::dvec3& to,
          int& cells, int cell_limit) {
    auto way = space.way(from, to);
    if (!way) return {};
    const Place* start = way->from_the_start ? from_surface : nullptr;
    if (start) way->begin = {start->x(), start->y(), surface_w(space, *start)};
    return SurfaceCast<Space>(space, way->begin, way->end, cells, cell_limit).run(way->begin, start);
}

bool is_clear(const auto& space, const glm::dvec3& from, const glm::dvec3& to) {
    const auto begin = space.chart(from), end = space.chart(to);
    if (!begin || !end) return false;
    const TileGrid tiles = space.field().tiles();
    const int column = tile_of(begin->x, tiles.tiles_x), row = tile_of(begin->y, tiles.tiles_y);
    return column == tile_of(end->x, tiles.tiles_x) && row == tile_of(end->y, tiles.tiles_y) &&
           std::min(begin->w, end->w) > space.largest_w(column, row);
}

template bool is_clear(const WorldSpace&, const glm::dvec3&, const glm::dvec3&);
template bool is_clear(const PixelSpace&, const glm::dvec3&, const glm::dvec3&);

template Cast cast(const WorldSpace&, const glm::dvec3&, const Place*, const glm::dvec3&, int&, int);
template Cast cast(const PixelSpace&, const glm::dvec3&, const Place*, const glm::dvec3&, int&, int);

}  // namespace touchable
