#include "device/hand_script.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

/// SplitMix64: small, and the same sequence everywhere.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    /// In [0, 1).
    double next() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

double finger_phase(int finger, int fingers) {
    return 2 * pi * finger / fingers;
}

/// The pixel step of `metres` of device space in direction (x right, y up).
glm::dvec2 pixel_step(const glm::dvec2& direction, double metres, const Ground& ground) {
    return glm::dvec2(direction.x, -direction.y) * metres / ground.metres_per_pixel;
}

/// The penetration of a hand that glides along: it breathes about its mean, each finger in its own phase, so
/// that the force keeps changing and stays above zero.
double breathing(double mean, double seconds, double phase) {
    constexpr double hertz = 0.9;
    constexpr double share = 3.0 / 7.0;
    return mean * (1 + share * sine(2 * pi * hertz * seconds + phase));
}

class Wander final : public HandScript {
public:
    Wander(const WanderSettings& settings, int fingers, const PixelBox& box, const SurfaceProbe& probe)
        : settings_(settings), fingers_(fingers), box_(box) {
        const glm::dvec2 centre = 0.5 * (box.least + box.greatest);
        const std::optional<SurfacePoint> start = nearest_surface(probe, centre, box);
        pixel_ = home_ = start ? start->pixel : centre;
        Random random(settings.seed);
        heading_ = 2 * pi * random.next();
        turn_phase_ = 2 * pi * random.next();
    }

    glm::dvec2 pixel() const override { return pixel_; }
    bool moves() const override { return true; }

    void advance(const Ground& ground, const SurfaceProbe&) override {
        keep_near_the_surface(ground);
        const double turn = 0.9 * sine(2 * pi * 0.37 * seconds_ + turn_phase_) + 0.4;  // rad/s
        heading_ += turn * tick_s;
        pixel_ += pixel_step({cosine(heading_), sine(heading_)}, settings_.speed * tick_s, ground);
        if (reflect(pixel_.x, box_.least.x, box_.greatest.x)) heading_ = pi - heading_;
        if (reflect(pixel_.y, box_.least.y, box_.greatest.y)) heading_ = -heading_;
        seconds_ = static_cast<double>(++tick_) * tick_s;
    }

    double penetration(int finger) const override {
        return breathing(settings_.depth, seconds_, finger_phase(finger, fingers_));
    }

private:
    static constexpr double shortest_leash = 0.01;  // device metres

    /// A clip may have no surface over nearly half of its picture, in a few large holes: without this a hand
    /// would feel nothing for seconds. The leash grows with every turn, so that a hand whose surface has
    /// moved away finds it again.
    void keep_near_the_surface(const Ground& ground) {
        if (ground.surface) {
            home_ = pixel_;
            leash_ = shortest_leash;
            strayed_ = 0;
            return;
        }
        strayed_ += settings_.speed * tick_s;
        if (strayed_ < leash_) return;
        const glm::dvec2 way = (home_ - pixel_) * ground.metres_per_pixel;
        heading_ = arctangent2(-way.y, way.x);
        leash_ = 2 * leash_;
        strayed_ = 0;
    }

    static bool reflect(double& x, double least, double greatest) {
        if (x >= least && x <= greatest) return false;
        const double mirrored = x < least ? least + (least - x) : greatest - (x - greatest);
        x = std::clamp(mirrored, least, greatest);
        return true;
    }

    WanderSettings settings_;
    int fingers_;
    PixelBox box_;
    glm::dvec2 pixel_{0, 0};
    glm::dvec2 home_{0, 0};  // where there last was a surface
    double heading_ = 0;     // radians counter-clockwise from the right
    double turn_phase_ = 0;
    double leash_ = shortest_leash;
    double strayed_ = 0;  // device metres since home, or since the last turn
    std::int64_t tick_ = 0;
    double seconds_ = 0;
};

class Stroke final : public HandScript {
public:
    Stroke(const StrokeSettings& settings, int fingers, const PixelBox& box)
        : settings_(settings),
          fingers_(fingers),
          box_(box),
          pixel_(0.5 * (box.least + box.greatest)),
          direction_(cosine(settings.angle), sine(settings.angle)) {}

    glm::dvec2 pixel() const override { return pixel_; }
    bool moves() const override { return true; }

    void advance(const Ground& ground, const SurfaceProbe&) override {
        glm::dvec2 step = pixel_step(direction_, settings_.speed * tick_s, ground);
        if (!box_.contains(pixel_ + step)) {
            direction_ = -direction_;
            step = -step;
        }
        if (box_.contains(pixel_ + step)) pixel_ += step;
        seconds_ = static_cast<double>(++tick_) * tick_s;
    }

    double penetration(int finger) const override {
        return breathing(settings_.depth, seconds_, finger_phase(finger, fingers_));
    }

private:
    StrokeSettings settings_;
    int fingers_;
    PixelBox box_;
    glm::dvec2 pixel_;
    glm::dvec2 direction_;
    std::int64_t tick_ = 0;
    double seconds_ = 0;
};

class Press final : public HandScript {
public:
    Press(const PressSettings& settings, int fingers) : settings_(settings), fingers_(fingers) {}

    glm::dvec2 pixel() const override { return settings_.pixel; }
    bool moves() const override { return false; }

    void advance(const Ground&, const SurfaceProbe&) override { ++tick_; }

    double penetration(int finger) const override {
        const double seconds = static_cast<double>(tick_) * tick_s;
        const double swing = cosine(2 * pi * seconds / settings_.period + finger_phase(finger, fingers_));
        return 0.5 * (settings_.depth - settings_.lift) - 0.5 * (settings_.depth + settings_.lift) * swing;
    }

private:
    PressSettings settings_;
    int fingers_;
    std::int64_t tick_ = 0;
};

class Poke final : public HandScript {
public:
    Poke(const PokeSettings& settings, int fingers, const PixelBox& box, const SurfaceProbe& probe)
        : settings_(settings), fingers_(fingers), box_(box), random_(settings.seed) {
        pixel_ = next_target(probe);
        target_ = pixel_;
    }

    glm::dvec2 pixel() const override { return pixel_; }
    bool moves() const override { return pixel_ != target_; }

    void advance(const Ground& ground, const SurfaceProbe& probe) override {
        if (pixel_ != target_) {
            travel(ground);
        } else if (++poking_ > poke_ticks()) {
            target_ = next_target(probe);
            poking_ = 0;
        }
    }

    double penetration(int finger) const override {
        const double begun = static_cast<double>(poking_) * tick_s - delay(finger);
        const double share = std::clamp(begun / settings_.period, 0.0, 1.0);
        return (settings_.depth + settings_.lift) * 0.5 * (1 - cosine(2 * pi * share)) - settings_.lift;
    }

private:
    /// Fingers poke within half a period of one another.
    double delay(int finger) const { return 0.5 * settings_.period * finger / fingers_; }

    std::int64_t poke_ticks() const {
        return static_cast<std::int64_t>(std::ceil((settings_.period + delay(fingers_ - 1)) / tick_s));
    }

    void travel(const Ground& ground) {
        const glm::dvec2 way = (target_ - pixel_) * ground.metres_per_pixel;
        const double left = glm::length(way);
        const double step = settings_.speed * tick_s;
        pixel_ = left <= step ? target_ : pixel_ + (target_ - pixel_) * (step / left);
    }

    /// A random pixel with a surface under it; any pixel once a good many had none.
    glm::dvec2 next_target(const SurfaceProbe& probe) {
        glm::dvec2 pixel{};
        for (int attempt = 0; attempt < 64; ++attempt) {
            const double across = random_.next();
            const double down = random_.next();
            pixel = box_.least + (box_.greatest - box_.least) * glm::dvec2(across, down);
            if (probe.depth_under(pixel.x, pixel.y)) break;
        }
        return pixel;
    }

    PokeSettings settings_;
    int fingers_;
    PixelBox box_;
    Random random_;
    glm::dvec2 pixel_{0, 0};
    glm::dvec2 target_{0, 0};
    std::int64_t poking_ = 0;  // ticks into the present poke; 0 while travelling
};

}  // namespace

std::unique_ptr<HandScript> make_wander(const WanderSettings& settings, int fingers, const PixelBox& box,
                                        const SurfaceProbe& probe) {
    return std::make_unique<Wander>(settings, fingers, box, probe);
}

std::unique_ptr<HandScript> make_stroke(const StrokeSettings& settings, int fingers, const PixelBox& box) {
    return std::make_unique<Stroke>(settings, fingers, box);
}

std::unique_ptr<HandScript> make_press(const PressSettings& settings, int fingers) {
    return std::make_unique<Press>(settings, fingers);
}

std::unique_ptr<HandScript> make_poke(const PokeSettings& settings, int fingers, const PixelBox& box,
                                      const SurfaceProbe& probe) {
    return std::make_unique<Poke>(settings, fingers, box, probe);
}

}  // namespace touchable
