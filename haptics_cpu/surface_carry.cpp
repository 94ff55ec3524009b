#include "haptics_cpu/surface_carry.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <type_traits>

#include "haptics_cpu/nearest_place.hpp"
#include "haptics_cpu/pixel_space.hpp"
#include "haptics_cpu/surface_lattice.hpp"
#include "haptics_cpu/world_space.hpp"

namespace touchable {

namespace {

using glm::dvec3;

// A slope of up to 60 degrees that rises along the ray comes no nearer than this share of the way: there the
// ray is right. The sides of objects come far nearer.
constexpr double much_nearer = 0.5;

/// Onto a surface that rose past a free proxy, on its ray. False where it did not.
template <class Space>
bool lift(const Space& space, Proxy& proxy) {
    const auto at = space.chart(proxy.point);
    if (!at) return false;
    const Place under = face_under(at->x, at->y);
    if (!(at->w < surface_w(space, under))) return false;
    proxy = {under, surface_point(space, under)};
    return true;
}

/// False where it went another way than on its ray.
bool carry_suddenly(const WorldSpace& space, Proxy& proxy, const dvec3& was, double distance) {
    if (proxy.point.z < was.z) {
        proxy = {{}, was};
        return false;
    }
    const auto aside = nearest_place(space, proxy, was, much_nearer * distance);
    if (!aside) return true;
    proxy = {*aside, surface_point(space, *aside), proxy.sliding};
    return false;
}

}  // namespace

template <class Space>
bool carry(const Space& space, Proxy& proxy, double sudden) {
    const dvec3 was = proxy.point;
    if (proxy.on_surface())
        proxy.point = surface_point(space, proxy);
    else if (!lift(space, proxy))
        return true;
    if constexpr (std::is_same_v<Space, WorldSpace>) {
        const dvec3 way = proxy.point - was;
        const double squared = glm::dot(way, way);
        if (squared > sudden * sudden) return carry_suddenly(space, proxy, was, std::sqrt(squared));
    }
    return true;
}

template bool carry(const WorldSpace&, Proxy&, double);
template bool carry(const PixelSpace&, Proxy&, double);

}  // namespace touchable
