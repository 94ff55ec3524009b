// SPDX-License-Identifier: Apache-2.0
#include "player/view/view.hpp"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <set>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/view/drawn_surface.hpp"
#include "shaders/cut_rule.h"

// The camera of a viewpoint, and ray casting. A ray is also straight in lattice space (x, y, q), so it is
// followed from one lattice line to the next.

namespace touchable {
namespace {

constexpr double degree = pi / 180.0;

/// Near plane's distance as a share of the orbit's distance. As small as the clip's own view's, so that near
/// surfaces are not clipped as soon as the view turns; the precision of z does not depend on it.
constexpr double near_share = 1e-3;

/// A matrix from its rows; GLM stores columns.
glm::dmat4 from_rows(const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& z, const glm::dvec4& w) {
    return glm::transpose(glm::dmat4(x, y, z, w));
}

/// (x, y, 1, q) -> homogeneous world point ((x - cx)/fx, -(y - cy)/fy, -1, q).
glm::dmat4 world_from_lattice(const Camera& camera) {
    return from_rows({1.0 / camera.fx, 0, -camera.cx / camera.fx, 0},
                     {0, -1.0 / camera.fy, camera.cy / camera.fy, 0}, {0, 0, -1, 0}, {0, 0, 0, 1});
}

/// Projection matrix of a lens; focal lengths and centre in the picture's pixels.
glm::dmat4 lens(glm::dvec2 focal, glm::dvec2 centre, int width, int height, double near) {
    const glm::dvec2 half(width / 2.0, height / 2.0);
    return from_rows({focal.x / half.x, 0, 1.0 - centre.x / half.x, 0},
                     {0, -focal.y / half.y, 1.0 - centre.y / half.y, 0}, {0, 0, 0, near}, {0, 0, -1, 0});
}

double fit(const Scene& scene, int width, int height) {
    return std::min(static_cast<double>(width) / scene.width, static_cast<double>(height) / scene.height);
}

/// The clip camera's principal point in the clip's own view, pixels.
glm::dvec2 axis_of(const Scene& scene, int width, int height) {
    const double scale = fit(scene, width, height);
    const glm::dvec2 margin((width - scale * scene.width) / 2.0, (height - scale * scene.height) / 2.0);
    return margin + scale * glm::dvec2(scene.camera.cx + 0.5, scene.camera.cy + 0.5);
}

/// An eye and its lens; points with z < 0 in `eye_from_world` space are in front of it.
struct Sight {
    glm::dmat4 eye_from_world{1.0};
    glm::dvec3 eye{0.0};
    glm::dvec2 focal, centre;  // pixels
    double near;               // scene units
};

ViewCamera view_of(const Sight& sight, const Scene& scene, int width, int height) {
    ViewCamera view;
    view.clip_from_world = lens(sight.focal, sight.centre, width, height, sight.near) * sight.eye_from_world;
    view.clip_from_lattice = view.clip_from_world * world_from_lattice(scene.camera);
    view.eye = sight.eye;
    view.width = width;
    view.height = height;
    view.near = sight.near;
    view.focal = std::max(sight.focal.x, sight.focal.y);
    return view;
}

/// The axes of an orbit's eye: unit vectors to the right, up, and back to the eye from what it looks at.
struct Axes {
    glm::dvec3 right, up, back;
};

Axes orbit_axes(const Viewpoint& viewpoint) {
    const double az = viewpoint.azimuth * degree, el = viewpoint.elevation * degree;
    const glm::dvec3 back(sine(az) * cosine(el), sine(el), cosine(az) * cosine(el));
    const glm::dvec3 right(cosine(az), 0, -sine(az));
    return {right, glm::cross(back, right), back};
}

/// The orbit's focal lengths, pixels.
glm::dvec2 orbit_focal(const Viewpoint& viewpoint, const Scene& scene, int width, int height) {
    if (!viewpoint.fov) return glm::dvec2(scene.camera.fx, scene.camera.fy) * fit(scene, width, height);
    const double half = *viewpoint.fov * 0.5 * degree;
    return glm::dvec2(height / 2.0 * cosine(half) / sine(half));
}

ViewCamera orbit_view(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre, int width,
                      int height) {
    const auto [right, up, back] = orbit_axes(viewpoint);
    const double distance = -centre.z / viewpoint.zoom.value_or(1.0);
    const glm::dvec3 eye = centre + distance * back;
    const glm::dmat4 eye_from_world = from_rows({right, -glm::dot(right, eye)}, {up, -glm::dot(up, eye)},
                                                {back, -glm::dot(back, eye)}, {0, 0, 0, 1});
    const glm::dvec2 focal = orbit_focal(viewpoint, scene, width, height);
    const glm::dvec2 middle =
        viewpoint.keeps_axis ? axis_of(scene, width, height) : glm::dvec2(width / 2.0, height / 2.0);
    return view_of({eye_from_world, eye, focal, middle, near_share * distance}, scene, width, height);
}

/// Parses "key=value" of an orbit; returns the fault, nullopt if it is valid. `read`: the keys before it.
std::optional<std::string> read_orbit(std::string_view word, Viewpoint& viewpoint,
                                      std::set<std::string_view>& read) {
    const struct {
        std::string_view key;
        double least, most;
        std::function<void(double)> set;
    } keys[] = {{"az", -180, 180, [&](double value) { viewpoint.azimuth = value; }},
                {"el", -89, 89, [&](double value) { viewpoint.elevation = value; }},
                {"zoom", 0.1, 20, [&](double value) { viewpoint.zoom = value; }},
                {"fov", 5, 120, [&](double value) { viewpoint.fov = value; }}};
    const std::size_t equals = word.find('=');
    for (const auto& key : keys) {
        if (equals == std::string_view::npos || word.substr(0, equals) != key.key) continue;
        if (!read.insert(key.key).second) return std::string(key.key) + " is given twice; give it once";
        const auto value = parsed_number(word.substr(equals + 1));
        if (!value || *value < key.least || *value > key.most)
            return std::string(key.key) + formatted(" must be a number from %g to %g", key.least, key.most);
        key.set(*value);
        return std::nullopt;
    }
    return std::string("'").append(word).append("' is none of az=, el=, zoom=, fov=");
}

constexpr double never = std::numeric_limits<double>::infinity();

/// A line of sight in lattice space (x, y, q), where it is straight too: the part within the picture, between
/// the planes in front of and behind all surfaces.
struct LatticeWay {
    glm::dvec3 begin, end;
    glm::dvec3 at(double s) const { return begin + s * (end - begin); }
};

/// Narrows [t0, t1] to the part with `from` + t `change` >= 0; t0 > t1 if there is none.
void keep_positive(double from, double change, double& t0, double& t1) {
    if (change > 0)
        t0 = std::max(t0, -from / change);
    else if (change < 0)
        t1 = std::min(t1, -from / change);
    else if (from < 0)
        t1 = -1;
}

/// The greatest ratio of coded to planar depth within a rectangle of the picture.
double longest_ray(const HeightField& field, double left, double top, double right, double bottom) {
    if (field.scene().depth.semantics == DepthSemantics::planar) return 1;
    const Camera& camera = field.scene().camera;
    return std::max({camera.ray_length(left, top), camera.ray_length(right, top),
                     camera.ray_length(left, bottom), camera.ray_length(right, bottom)});
}

/// Upper bounds of q over cells, cached for the last tile.
class NearestDrawn {
public:
    explicit NearestDrawn(const HeightField& field) : field_(field) {}
    /// No surface over the cell has a greater q.
    double greatest_q(int i, int j) {
        const TileGrid tiles = field_.tiles();
        const int x = tiles.column_of_cell(i), y = tiles.row_of_cell(j);
        if (x == x_ && y == y_) return q_;
        x_ = x;
        y_ = y;
        const double nearest = field_.nearest_depth(x, y);
        constexpr int side = TileGrid::cells;
        q_ = nearest > 0 ? longest_ray(field_, side * x, side * y, side * (x + 1), side * (y + 1)) / nearest
                         : never;
        return q_;
    }

private:
    const HeightField& field_;
    int x_ = -1, y_ = -1;  // the tile of q_
    double q_ = never;
};

/// The part of a line of sight between two distances from the eye; nullopt if it is beside all surfaces.
std::optional<LatticeWay> way_of(const glm::dvec3& eye, const glm::dvec3& direction, double near,
                                 double farthest, const HeightField& field) {
    const Camera& camera = field.scene().camera;
    const double width = field.width() - 1, height = field.height() - 1;
    // Planar depth k, and k x and k y, along the ray: linear in t.
    const auto lattice = [&](const glm::dvec3& p) {
        return glm::dvec3(camera.fx * p.x - camera.cx * p.z, -camera.fy * p.y - camera.cy * p.z, -p.z);
    };
    const glm::dvec3 from = lattice(eye), change = lattice(direction);
    const double least = 0.5 * field.nearest_depth_anywhere() / longest_ray(field, 0, 0, width, height),
                 most = 1.001 * field.scene().depth.far;
    double t0 = near, t1 = farthest;
    keep_positive(from.z - least, change.z, t0, t1);
    keep_positive(most - from.z, -change.z, t0, t1);
    keep_positive(from.x, change.x, t0, t1);
    keep_positive(width * from.z - from.x, width * change.z - change.x, t0, t1);
    keep_positive(from.y, change.y, t0, t1);
    keep_positive(height * from.z - from.y, height * change.z - change.y, t0, t1);
    if (!(t0 <= t1) || !std::isfinite(t1)) return std::nullopt;
    const auto seen = [&](double t) {
        const glm::dvec3 p = from + t * change;
        // Clamps rounding errors at the picture's border.
        return glm::dvec3(std::clamp(p.x / p.z, 0.0, width), std::clamp(p.y / p.z, 0.0, height), 1 / p.z);
    };
    return LatticeWay{seen(t0), seen(t1)};
}

/// Where a ray crosses the lines of one family (x, y, or x - y integer), in order.
class Crossings {
public:
    Crossings(double begin, double end)
        : begin_(begin), change_(end - begin), line_(change_ > 0 ? std::floor(begin) : std::ceil(begin)) {
        advance();
    }
    double next() const { return next_; }
    void advance() {
        line_ += change_ > 0 ? 1 : -1;
        next_ = change_ == 0 ? never : (line_ - begin_) / change_;
    }

private:
    double begin_, change_, line_, next_ = never;
};

/// A triangle of the lattice, in the picture.
struct Triangle {
    std::array<glm::dvec3, 3> corners;  // (x, y, q)
    bool has_hole;

    double q_at(double x, double y) const {
        const glm::dvec3 a = corners[1] - corners[0], b = corners[2] - corners[0];
        const double area = a.x * b.y - a.y * b.x, px = x - corners[0].x, py = y - corners[0].y;
        return corners[0].z + ((px * b.y - py * b.x) * a.z + (a.x * py - a.y * px) * b.z) / area;
    }
};

/// The cell that a place of the picture is in.
std::array<int, 2> cell_at(int width, int height, double x, double y) {
    return {static_cast<int>(std::clamp(std::floor(x), 0.0, width - 2.0)),
            static_cast<int>(std::clamp(std::floor(y), 0.0, height - 2.0))};
}

/// The triangle at a picture location, of the vertices that `vertex_of` has.
template <class VertexOf>
Triangle triangle_at(const HeightField& field, double x, double y, const VertexOf& vertex_of) {
    const auto [i, j] = cell_at(field.width(), field.height(), x, y);
    const bool lower = x - i >= y - j;
    const std::array<std::array<int, 2>, 3> at{
        {{i, j}, {i + 1, lower ? j : j + 1}, {lower ? i + 1 : i, j + 1}}};
    const Scene& scene = field.scene();
    Triangle out{};
    for (std::size_t k = 0; k < 3; ++k) {
        const FieldVertex vertex = vertex_of(at[k][0], at[k][1]);
        out.has_hole = out.has_hole || !vertex.valid;
        out.corners[k] = {
            at[k][0], at[k][1],
            1 / planar_depth(scene.camera, scene.depth.semantics, at[k][0], at[k][1], vertex.depth)};
    }
    return out;
}

/// Where the ray crosses the plane of a triangle between s0 and s1, the stretch over this triangle. `front`:
/// the ray comes from in front of the surface.
struct Meeting {
    double s;
    bool front;
};
std::optional<Meeting> meeting(const LatticeWay& way, const Triangle& triangle, double s0, double s1) {
    const auto before = [&](double s) {
        const glm::dvec3 at = way.at(s);
        return at.z - triangle.q_at(at.x, at.y);
    };
    const double first = before(s0), last = before(s1);
    if (first == last || (first >= 0) == (last >= 0)) return std::nullopt;
    return Meeting{s0 + (s1 - s0) * (first / (first - last)), first >= 0};
}

/// Calls `take(place, s0, s1)` for every triangle under the ray, in order, until it returns false; `place`
/// lies in that triangle.
template <class Take>
void for_each_place(const LatticeWay& way, const Take& take) {
    Crossings columns(way.begin.x, way.end.x), rows(way.begin.y, way.end.y),
        diagonals(way.begin.x - way.begin.y, way.end.x - way.end.y);
    for (double s = 0; s < 1;) {
        const double next = std::min({1.0, columns.next(), rows.next(), diagonals.next()});
        for (Crossings* family : {&columns, &rows, &diagonals})
            if (family->next() <= next) family->advance();
        const double end = std::max(s, next);
        if (!take(way.at(0.5 * (s + end)), s, end)) return;
        s = end;
    }
}

/// Height subtracted from the drawn depth of a valid pixel.
double height_at(const HeightField& field, const FramePair& pair, int x, int y) {
    const double per_code = height_per_code(field.scene());
    const auto of = [&](const SurfaceFrame& frame) {
        return frame.heights.empty() ? 0.0 : per_code * frame.heights[frame.index(x, y)];
    };
    const SurfaceFrame &prev = *pair.prev.frame, &next = *pair.next.frame;
    if (!(field.blend() > 0)) return of(prev);
    const auto [before, after] = field.vertices_of_frames(x, y);
    if (!are_mixed(field, before, after)) return of(field.blend() >= 0.5 ? next : prev);
    return of(prev) + (of(next) - of(prev)) * field.blend();
}

}  // namespace

Result<Viewpoint> parse_viewpoint(const std::string& words) {
    Viewpoint viewpoint;
    if (words == "own") {
        viewpoint.own = true;
        return viewpoint;
    }
    std::string_view rest = words;
    if (!rest.starts_with("orbit") || (rest.size() > 5 && rest[5] != ':'))
        return usage_error(
            "view '" + words + "' is not allowed; must be own, or orbit such as " + usual_viewpoint,
            {{Setting::view}});
    rest.remove_prefix(std::min<std::size_t>(rest.size(), 6));
    std::set<std::string_view> read;
    while (!rest.empty()) {
        const std::size_t comma = std::min(rest.find(','), rest.size());
        if (const auto fault = read_orbit(rest.substr(0, comma), viewpoint, read))
            return usage_error("view " + words + ": " + *fault, {{Setting::view}});
        rest.remove_prefix(std::min(rest.size(), comma + 1));
    }
    return viewpoint;
}

std::optional<glm::dvec3> ViewCamera::project(const glm::dvec3& world) const {
    const glm::dvec4 clip = clip_from_world * glm::dvec4(world, 1.0);
    if (!(clip.z <= clip.w)) return std::nullopt;
    return glm::dvec3((clip.x / clip.w + 1.0) * width / 2.0, (clip.y / clip.w + 1.0) * height / 2.0,
                      clip.z / clip.w);
}

glm::dvec3 ViewCamera::unproject(double x, double y, double z) const {
    const glm::dvec4 ndc(2.0 * x / width - 1.0, 2.0 * y / height - 1.0, z, 1.0);
    const glm::dvec4 world = glm::inverse(clip_from_world) * ndc;
    return glm::dvec3(world) / world.w;
}

glm::dvec3 ViewCamera::direction(double x, double y) const {
    return glm::normalize(unproject(x, y, 0.5) - eye);
}

ViewCamera own_view(const Scene& scene, int width, int height, double nearest) {
    const Camera& camera = scene.camera;
    const double scale = fit(scene, width, height);
    return view_of({glm::dmat4(1.0), glm::dvec3(0.0), scale * glm::dvec2(camera.fx, camera.fy),
                    axis_of(scene, width, height), nearest},
                   scene, width, height);
}

double whole_zoom(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre,
                  std::span<const glm::dvec3> points, int width, int height) {
    constexpr double margin = 0.93;     // share of the picture
    constexpr double outliers = 0.002;  // share of the points
    if (points.empty()) return 1;
    const auto [right, up, back] = orbit_axes(viewpoint);
    const glm::dvec2 reach =
        orbit_focal(viewpoint, scene, width, height) / (margin * 0.5 * glm::dvec2(width, height));
    // The distance at which each point is just in the picture: focal |right| / (distance - back) is at most
    // half of it.
    std::vector<double> distances;
    distances.reserve(points.size());
    for (const glm::dvec3& point : points) {
        const glm::dvec3 from = point - centre;
        distances.push_back(glm::dot(from, back) + std::max(reach.x * std::abs(glm::dot(from, right)),
                                                            reach.y * std::abs(glm::dot(from, up))));
    }
    const std::size_t beyond = static_cast<std::size_t>(outliers * static_cast<double>(distances.size()));
    const double farthest = sorted_element(distances, distances.size() - 1 - beyond);
    return std::clamp(-centre.z / std::max(farthest, -centre.z), 0.1, 1.0);
}

ViewCamera make_view(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre, int width,
                     int height) {
    // Near plane at a thousandth of the middle's depth: no clip has nearer surfaces.
    if (viewpoint.own) return own_view(scene, width, height, -centre.z * 1e-3);
    return orbit_view(viewpoint, scene, centre, width, height);
}

Viewpoint::Subject subject_of(const HeightField& field) {
    Viewpoint::Subject subject{{0, 0, -field.scene().depth.far}, {}};
    // At most 512 points a side give the same middle as all pixels.
    const int step = 1 + std::max(field.width(), field.height()) / 512;
    const Scene& scene = field.scene();
    for (int y = 0; y < field.height(); y += step)
        for (int x = 0; x < field.width(); x += step) {
            const FieldVertex vertex = drawn_vertex(field, x, y);
            if (!vertex.valid || vertex.depth >= 0.999 * scene.depth.far) continue;
            const double depth = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
            subject.points.push_back(unproject(scene.camera, x, y, depth));
        }
    if (subject.points.empty()) return subject;
    std::vector<double> values(subject.points.size());
    for (int axis = 0; axis < 3; ++axis) {
        std::transform(subject.points.begin(), subject.points.end(), values.begin(),
                       [axis](const glm::dvec3& point) { return point[axis]; });
        subject.middle[axis] = sorted_element(values, (values.size() - 1) / 2);
    }
    return subject;
}

std::optional<ViewCamera::Pick> pick(const HeightField& field, const ViewCamera& camera, double x, double y,
                                     double farthest) {
    if (field.width() < 2 || field.height() < 2) return std::nullopt;
    const glm::dvec3 direction = camera.direction(x, y);
    // The near plane is perpendicular to the view axis; unproject(.., 1) lies on it.
    const double near = glm::length(camera.unproject(x, y, 1) - camera.eye);
    const auto way = way_of(camera.eye, direction, near, farthest, field);
    if (!way) return std::nullopt;
    const bool is_turned = !is_own_view(camera);
    NearestDrawn nearest(field);
    std::optional<ViewCamera::Pick> found;  // a wall at first, if the ray meets one
    for_each_place(*way, [&](const glm::dvec3& at, double s, double end) {
        if (!(end > s)) return true;
        const auto [i, j] = cell_at(field.width(), field.height(), at.x, at.y);
        // Most of a ray runs in front of all surfaces.
        if (std::min(way->at(s).z, way->at(end).z) > nearest.greatest_q(i, j)) return true;
        const Triangle triangle = triangle_at(
            field, at.x, at.y, [&](int column, int row) { return drawn_vertex(field, column, row); });
        const auto q = [&](std::size_t corner) { return static_cast<float>(triangle.corners[corner].z); };
        const bool drawn = !triangle.has_hole && !(is_turned && triangle_is_cut(q(0), q(1), q(2)));
        if (const auto met = meeting(*way, triangle, s, end); met && (!found || drawn)) {
            const glm::dvec3 p = way->at(met->s);
            const glm::dvec3 point = unproject(field.scene().camera, p.x, p.y, 1 / p.z);
            found = {point, p.x, p.y, 1 / p.z, direction, met->front, drawn};
        }
        return !found || !found->drawn;
    });
    return found;
}

std::optional<SurfaceOnWay> surface_on_way(const HeightField& field, const glm::dvec3& from,
                                           const glm::dvec3& to) {
    if (field.width() < 2 || field.height() < 2) return std::nullopt;
    const Camera& camera = field.scene().camera;
    const auto begin = project(camera, from), end = project(camera, to);
    if (!begin || !end) return std::nullopt;
    LatticeWay way{{begin->x, begin->y, 1 / begin->planar_depth}, {end->x, end->y, 1 / end->planar_depth}};
    const glm::dvec3 change = way.end - way.begin;
    double s0 = 0, s1 = 1;
    keep_positive(way.begin.x, change.x, s0, s1);
    keep_positive(field.width() - 1 - way.begin.x, -change.x, s0, s1);
    keep_positive(way.begin.y, change.y, s0, s1);
    keep_positive(field.height() - 1 - way.begin.y, -change.y, s0, s1);
    if (!(s0 <= s1)) return std::nullopt;
    way = {way.at(s0), way.at(s1)};
    SurfaceOnWay found{-never, never};
    const auto look = [&](const Triangle& triangle, double s) {
        const glm::dvec3 at = way.at(s);
        const double surface = 1 / triangle.q_at(at.x, at.y);
        found.behind = std::max(found.behind, 1 / at.z - surface);
        found.nearest = std::min(found.nearest, surface);
    };
    for_each_place(way, [&](const glm::dvec3& place, double from_s, double to_s) {
        const Triangle triangle = triangle_at(field, place.x, place.y,
                                              [&](int column, int row) { return field.vertex(column, row); });
        look(triangle, from_s);
        look(triangle, to_s);
        return true;
    });
    return found;
}

PixelValues values_at(const HeightField& field, const FramePair& pair, int x, int y) {
    const Scene& scene = field.scene();
    const FieldVertex vertex = drawn_vertex(field, x, y);
    const double z = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
    const double height = vertex.valid ? height_at(field, pair, x, y) : 0;
    const double millimetres = height * (scene.metres_per_unit * 1000);
    return {vertex.valid, vertex.depth, z, height, millimetres, field.properties(x, y, 0, 0)};
}

}  // namespace touchable
