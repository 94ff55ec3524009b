#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>

#include "device/surface_search.hpp"

namespace touchable {

inline constexpr double tick_s = 0.001;  ///< seconds from one tick to the next

/// What a script is told of the ground under the hand's centre at the tick before.
struct Ground {
    glm::dvec2 metres_per_pixel;  ///< device metres that one pixel spans there, across and down
    bool surface;                 ///< whether there is a surface under that pixel
};

/// A scripted motion: a path of the hand's centre over the picture, and how deep each finger reaches.
class HandScript {
public:
    virtual ~HandScript() = default;
    /// Where the hand's centre is, pixels.
    virtual glm::dvec2 pixel() const = 0;
    /// Moves on by one tick.
    virtual void advance(const Ground& ground, const SurfaceProbe& probe) = 0;
    /// Whether it is on its way; if not, it stays over its pixel.
    virtual bool moves() const = 0;
    /// Device metres under the surface; negative: above it.
    virtual double penetration(int finger) const = 0;
};

struct WanderSettings {
    double speed;  ///< m/s
    double depth;  ///< mean, device metres
    std::uint64_t seed;
};
/// Follows a heading that turns smoothly, from the surface nearest to the picture's centre, reflected at the
/// box. Having strayed too far over pixels without a surface it turns back to where it last had one.
std::unique_ptr<HandScript> make_wander(const WanderSettings& settings, int fingers, const PixelBox& box,
                                        const SurfaceProbe& probe);

struct StrokeSettings {
    double speed;  ///< m/s
    double depth;  ///< mean, device metres
    double angle;  ///< radians counter-clockwise from the picture's right
};
/// Goes back and forth in a straight line through the box's centre, turning at the box.
std::unique_ptr<HandScript> make_stroke(const StrokeSettings& settings, int fingers, const PixelBox& box);

struct PressSettings {
    glm::dvec2 pixel;
    double depth;   ///< greatest, device metres
    double lift;    ///< greatest height above the surface, device metres
    double period;  ///< seconds
};
/// Stays over one pixel, swinging between `lift` above and `depth` under the surface.
std::unique_ptr<HandScript> make_press(const PressSettings& settings, int fingers);

struct PokeSettings {
    double speed;   ///< between pokes, m/s
    double depth;   ///< greatest, device metres
    double lift;    ///< height above the surface between pokes, device metres
    double period;  ///< of one poke in and out, seconds
    std::uint64_t seed;
};
/// Pokes at random pixels of the box that have a surface, the fingers shortly after one another, and travels
/// straight from one to the next above the surface.
std::unique_ptr<HandScript> make_poke(const PokeSettings& settings, int fingers, const PixelBox& box,
                                      const SurfaceProbe& probe);

}  // namespace touchable
