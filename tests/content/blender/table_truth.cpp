#include "tests/content/blender/table_truth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

namespace touchable::test {
namespace {

using Vec = glm::dvec3;

// As table.py has them, in metres.
const Vec camera_place(0.0, -0.44, 0.36), camera_target(-0.01, -0.008, 0.018);
const Vec ball_centre(-0.075, 0.035, 0.045), egg_centre(-0.035, -0.062, 0.0235),
    egg_radii(0.032, 0.0235, 0.0235);
const Vec can_foot(0.075, 0.055, 0), sponge_foot(0.068, -0.052, 0), sponge_size(0.105, 0.066, 0.034);
const Vec coaster_foot(-0.14, -0.075, 0);
constexpr double can_radius = 0.034, can_height = 0.085, can_wall = 0.0012, can_lid = 0.082;
constexpr double coaster_radius = 0.042, coaster_height = 0.004, sponge_bevel = 0.004, sponge_turn = -17.0;

/// A ray whose direction is 1 long along the camera's axis.
struct Ray {
    Vec from, along;
    Vec at(double t) const { return from + t * along; }
};

void keep(TableHit& hit, double depth, OnTable thing, bool is_plain = true) {
    if (depth > 0 && depth < hit.depth) hit = {depth, thing, is_plain};
}

/// The nearer of two roots of a t^2 - 2 b t + c.
std::optional<double> nearer_root(double a, double b, double c) {
    const double root = b * b - a * c;
    if (root < 0) return std::nullopt;
    return (b - std::sqrt(root)) / a;
}

void meet_ellipsoid(const Ray& ray, const Vec& centre, const Vec& radii, OnTable thing, TableHit& hit) {
    const Vec from = (ray.from - centre) / radii, along = ray.along / radii;
    if (const auto t = nearer_root(glm::dot(along, along), -glm::dot(from, along), glm::dot(from, from) - 1))
        keep(hit, *t, thing);
}

/// Upright, its side alone.
void meet_side(const Ray& ray, const Vec& foot, double radius, double height, OnTable thing, bool is_plain,
               TableHit& hit) {
    const Vec from = ray.from - foot;
    const double a = ray.along.x * ray.along.x + ray.along.y * ray.along.y;
    const double b = -(from.x * ray.along.x + from.y * ray.along.y);
    const auto t = nearer_root(a, b, from.x * from.x + from.y * from.y - radius * radius);
    if (t && ray.at(*t).z > 0 && ray.at(*t).z < height) keep(hit, *t, thing, is_plain);
}

/// Level, from one radius to another.
void meet_disc(const Ray& ray, const Vec& foot, double least, double most, double height, OnTable thing,
               bool is_plain, TableHit& hit) {
    const double t = (height - ray.from.z) / ray.along.z;
    const Vec at = ray.at(t) - foot;
    const double radius = std::sqrt(at.x * at.x + at.y * at.y);
    if (radius >= least && radius <= most) keep(hit, t, thing, is_plain);
}

void meet_sponge(const Ray& ray, TableHit& hit) {
    const double turn = sponge_turn * 3.14159265358979323846 / 180, c = std::cos(turn), s = std::sin(turn);
    const auto turned = [&](const Vec& v) { return Vec(c * v.x + s * v.y, -s * v.x + c * v.y, v.z); };
    const Vec from = turned(ray.from - sponge_foot), along = turned(ray.along);
    const Vec least(-sponge_size.x / 2, -sponge_size.y / 2, 0),
        most(sponge_size.x / 2, sponge_size.y / 2, sponge_size.z);
    double enter = -1e9, leave = 1e9;
    int face = 0;
    for (int k = 0; k < 3; ++k) {
        const double first = (least[k] - from[k]) / along[k], second = (most[k] - from[k]) / along[k];
        if (std::min(first, second) > enter) enter = std::min(first, second), face = k;
        leave = std::min(leave, std::max(first, second));
    }
    if (enter > leave) return;
    const Vec at = from + enter * along;
    bool is_plain = true;
    for (int k = 0; k < 3; ++k) {
        const double to_edge = k == 2 ? most[2] - at[2] : most[k] - std::abs(at[k]);
        if (k != face && to_edge < sponge_bevel * 1.05) is_plain = false;
    }
    keep(hit, enter, OnTable::sponge, is_plain);
}

}  // namespace

TableHit table_hit(const Camera& camera, double x, double y) {
    const Vec forward = glm::normalize(camera_target - camera_place);
    const Vec right = glm::normalize(glm::cross(forward, Vec(0, 0, 1))), up = glm::cross(right, forward);
    const Ray ray{camera_place, forward + camera.u(x) * right + camera.v(y) * up};
    TableHit hit;
    keep(hit, -ray.from.z / ray.along.z, OnTable::table);
    meet_ellipsoid(ray, ball_centre, Vec(ball_centre.z), OnTable::ball, hit);
    meet_ellipsoid(ray, egg_centre, egg_radii, OnTable::egg, hit);
    meet_sponge(ray, hit);
    meet_side(ray, coaster_foot, coaster_radius, coaster_height, OnTable::coaster, false, hit);
    meet_disc(ray, coaster_foot, 0, coaster_radius, coaster_height, OnTable::coaster, true, hit);
    meet_side(ray, can_foot, can_radius, can_height, OnTable::can, true, hit);
    meet_disc(ray, can_foot, can_radius - can_wall, can_radius, can_height, OnTable::can, true, hit);
    // Through its mouth onto the lid, or the wall around that.
    TableHit mouth;
    meet_disc(ray, can_foot, 0, can_radius - can_wall, can_height, OnTable::can, true, mouth);
    if (mouth.depth < hit.depth) {
        TableHit lid{1e9, OnTable::can, true};
        meet_disc(ray, can_foot, 0, can_radius - can_wall, can_lid, OnTable::can, true, lid);
        hit = lid.depth < 1e9 ? lid : TableHit{mouth.depth, OnTable::can, false};
    }
    return hit;
}

}  // namespace touchable::test
