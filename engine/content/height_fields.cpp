// Height fields.
#include "engine/content/height_fields.hpp"

#include "engine/base/same_bits.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

/// amplitude sin(2 pi (kx x + ky y)/period + phase); lengths in scene units (millimetres).
struct Wave {
    double amplitude, period, kx, ky, phase;
};
using Waves = std::array<Wave, 4>;

constexpr Waves bumps{{{5, 100, 1, 0, 0}, {4, 80, 0, 1, 0.7}, {0.8, 30, 1, 1, 1.3}, {0.015, 6, 1, -2, 0.2}}};
constexpr Waves rough{{{4, 60, 1, 0, 0}, {3, 45, 0, 1, 0.7}, {1.5, 20, 1, 1, 1.3}, {0.4, 7, 1, -2, 0.2}}};

const Waves& waves_of(Relief relief) {
    return relief == Relief::rough ? rough : bumps;
}

double lift(Relief relief, double t) {
    return relief == Relief::moving ? 20 * sine(2 * pi * 0.5 * t) : 0;
}

double angle(const Wave& wave, double x, double y) {
    return 2 * pi * (wave.kx * x + wave.ky * y) / wave.period + wave.phase;
}

/// Height over the plane at 1000 and its slopes; Newton's method for a pixel needs no more.
struct Slope {
    double b, bx, by;
};
Slope slope_at(const Waves& waves, double x, double y) {
    Slope sum{0, 0, 0};
    for (const Wave& wave : waves) {
        const double phi = angle(wave, x, y), k = 2 * pi / wave.period;
        const double slope = wave.amplitude * k * cosine(phi);
        sum.b += wave.amplitude * sine(phi);
        sum.bx += slope * wave.kx;
        sum.by += slope * wave.ky;
    }
    return sum;
}

class HeightFieldScene final : public AnalyticScene {
public:
    HeightFieldScene(Scene scene, Relief relief) : AnalyticScene(std::move(scene)), relief_(relief) {}

    /// d = 1000 - b(d u, d v): the left side less the right grows with d as long as |slope| |(u, v)| < 1, so
    /// there is one root and Newton finds it.
    double depth(double x, double y, double t) const override {
        const Waves& waves = waves_of(relief_);
        const double u = scene().camera.u(x), v = scene().camera.v(y),
                     base = tabletop_distance - lift(relief_, t);
        double d = base;
        for (int round = 0; round < 32; ++round) {
            const Slope s = slope_at(waves, d * u, d * v);
            const double step = (d - base + s.b) / (1 + u * s.bx + v * s.by);
            d -= step;
            if (std::fabs(step) <= 1e-12) break;
        }
        return d;
    }

private:
    bool moves() const override { return relief_ == Relief::moving; }
    Relief relief_;
};

}  // namespace

ReliefPoint relief_at(Relief relief, double x, double y, double t) {
    ReliefPoint sum{lift(relief, t) - tabletop_distance, 0, 0, 0, 0, 0};
    for (const Wave& wave : waves_of(relief)) {
        const double phi = angle(wave, x, y), k = 2 * pi / wave.period, s = sine(phi);
        const double slope = wave.amplitude * k * cosine(phi), bend = -wave.amplitude * k * k * s;
        sum.z += wave.amplitude * s;
        sum.zx += slope * wave.kx;
        sum.zy += slope * wave.ky;
        sum.zxx += bend * wave.kx * wave.kx;
        sum.zxy += bend * wave.kx * wave.ky;
        sum.zyy += bend * wave.ky * wave.ky;
    }
    return sum;
}

MadeScene make_height_field(std::string_view name, const SceneOptions& options) {
    // The steepest slope is 1.6 along Y: in a picture more than four times as high as wide, a ray could meet
    // the surface twice.
    if (options.height > 4 * options.width)
        return refuse_scene(name, "a picture of " + size_text(options.width, options.height) +
                                      " is too tall; its height must be at most 4 widths");
    const Relief relief = name == "rough" ? Relief::rough : name == "moving" ? Relief::moving : Relief::bumps;
    const double reach = relief == Relief::moving ? 40 : 20;
    Scene scene = tabletop_scene(name, options, tabletop_distance - reach, tabletop_distance + reach);
    return std::make_unique<HeightFieldScene>(std::move(scene), relief);
}

}  // namespace touchable
