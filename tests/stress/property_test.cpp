// SPDX-License-Identifier: Apache-2.0
// Properties of any touch: RapidCheck picks fields, cameras, codings, hands and changes of frames,
// and makes what fails as small as it can. The seed is fixed, so that a build passes or not;
// RC_PARAMS="seed=..." tries others, and a failure prints the RC_PARAMS that repeat it (docs/paper.md).

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <ostream>
#include <vector>

#include "haptics_cpu/touch_step.hpp"
#include "tests/reference/solver.hpp"
#include "tests/stress/drawn_scene.hpp"
#include "tests/stress/golden_runs.hpp"
#include "tests/stress/suites.hpp"
#include "tests/stress/watch.hpp"

namespace touchable::stress {

/// A goal and a moment, in steps that shrink well.
struct PickedTick {
    int x = 0, y = 0;  ///< eighths of a pixel
    int depth = 0;     ///< hundredths of the way from the camera to beyond the far plane
    int moment = 0;    ///< eighths from the first frame to the second, 0 to 7
};

/// A touch picked by RapidCheck: small enough to print, and to be made smaller where it fails.
struct PickedTouch {
    int width = 1, height = 1;
    DepthCodingKind kind = DepthCodingKind::linear;
    DepthSemantics semantics = DepthSemantics::planar;
    bool near_is_high = true, hold = false;
    int focal = 1, off_axis = 0;                       ///< eighths of the picture's width; pixels
    int friction = 0;                                  ///< tenths
    int height_share = 0;                              ///< of the nearest depth, hundredths, at the highest
    std::vector<std::uint8_t> first, second, heights;  ///< pictures; code 7 is invalid
    std::vector<PickedTick> ticks;

    Scene scene(double unit = 1) const;  ///< `unit`: how many scene units one of the picked is
};

namespace {

constexpr double near = 40, far = 160;

class PickedRun final : public StressRun {
public:
    PickedRun(const PickedTouch& touch, double unit)
        : StressRun(touch.scene(unit)), touch_(touch), unit_(unit) {
        FrameMaker maker(scene_);
        maker.build(planes(touch.first), first_);
        maker.build(planes(touch.second), second_);
    }
    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) override {
        const PickedTick& picked = touch_.ticks[static_cast<std::size_t>(tick)];
        // Frames come and go as the picked moments say; time itself only goes on.
        pair.prev = {2 * tick, tick * tick_ns, &first_};
        pair.next = {2 * tick + 1, tick * tick_ns + 8 * tick_ns, &second_};
        pair.blend = picked.moment / 8.0;
        goals[0] = unproject(scene_.camera, picked.x / 8.0, picked.y / 8.0,
                             unit_ * far * 1.1 * picked.depth / 100.0);
    }

private:
    DrawnPlanes planes(const std::vector<std::uint8_t>& picture) const {
        DrawnPlanes planes;
        planes.codes.assign(picture.begin(), picture.end());
        if (touch_.height_share > 0) planes.heights.assign(touch_.heights.begin(), touch_.heights.end());
        return planes;
    }
    PickedTouch touch_;
    double unit_;
    SurfaceFrame first_, second_;
};

}  // namespace

Scene PickedTouch::scene(double unit) const {
    Scene scene;
    scene.width = width;
    scene.height = height;
    const double f = width * focal / 8.0;
    scene.camera = {f, f, width / 2.0 + off_axis, height / 2.0 - off_axis};
    scene.depth.semantics = semantics;
    scene.depth.near_is_high = near_is_high || kind == DepthCodingKind::metric;
    scene.depth.invalid_codes[0] = 7;
    scene.depth.invalid_code_count = 1;
    set_planes(scene, kind, unit * near, unit * far, 8);
    scene.height_coding.units = HeightUnits::world;
    scene.height_coding.max_height = unit * near * height_share / 100.0;
    scene.interpolation = hold ? FrameInterpolation::hold : FrameInterpolation::linear;
    scene.device_metres_per_unit = 0.001 / unit;
    scene.default_properties = {1000, friction / 10.0, friction / 15.0};
    return scene;
}

std::ostream& operator<<(std::ostream& out, const PickedTouch& t) {
    auto picture = [&](const char* name, const std::vector<std::uint8_t>& codes) {
        out << ", " << name;
        for (const int code : codes) out << ' ' << code;
    };
    out << t.width << 'x' << t.height << ", coding " << static_cast<int>(t.kind)
        << (t.semantics == DepthSemantics::range ? " range" : " planar")
        << (t.near_is_high ? "" : " far is high") << (t.hold ? " hold" : "") << ", focal " << t.focal
        << "/8, off axis " << t.off_axis << ", friction 0." << t.friction << ", heights " << t.height_share;
    picture("first", t.first);
    picture("second", t.second);
    picture("heights", t.heights);
    for (const PickedTick& tick : t.ticks)
        out << ", (" << tick.x << "/8 " << tick.y << "/8 at " << tick.depth << " %, " << tick.moment << "/8)";
    return out;
}

/// The touch, once or (`unit`) in other units.
std::unique_ptr<StressRun> run_of(const PickedTouch& touch, double unit = 1) {
    return std::make_unique<PickedRun>(touch, unit);
}

}  // namespace touchable::stress

namespace rc {

using touchable::stress::PickedTick;
using touchable::stress::PickedTouch;

/// From low to below high, whatever the size of the case.
inline Gen<int> anywhere(int low, int high) {
    return gen::resize(kNominalSize, gen::inRange(low, high));
}

template <>
struct Arbitrary<PickedTick> {
    static Gen<PickedTick> arbitrary() {
        return gen::build<PickedTick>(
            gen::set(&PickedTick::x, anywhere(-8, 56)), gen::set(&PickedTick::y, anywhere(-8, 56)),
            gen::set(&PickedTick::depth, anywhere(-2, 101)), gen::set(&PickedTick::moment, anywhere(0, 8)));
    }
};

template <>
struct Arbitrary<PickedTouch> {
    static Gen<PickedTouch> arbitrary() {
        using touchable::DepthCodingKind, touchable::DepthSemantics;
        return gen::mapcat(gen::pair(anywhere(1, 7), anywhere(1, 7)), [](std::pair<int, int> size) {
            const auto pixels = static_cast<std::size_t>(size.first * size.second);
            // Metric codes below the near plane are invalid; so is 7.
            const auto codes = gen::container<std::vector<std::uint8_t>>(
                pixels,
                gen::weightedOneOf<std::uint8_t>({{6, gen::cast<std::uint8_t>(anywhere(0, 256))},
                                                  {2, gen::element(std::uint8_t{0}, std::uint8_t{255})},
                                                  {1, gen::just(std::uint8_t{7})}}));
            return gen::build<PickedTouch>(
                gen::set(&PickedTouch::width, gen::just(size.first)),
                gen::set(&PickedTouch::height, gen::just(size.second)),
                gen::set(&PickedTouch::kind, gen::element(DepthCodingKind::linear, DepthCodingKind::inverse,
                                                          DepthCodingKind::metric)),
                gen::set(&PickedTouch::semantics,
                         gen::element(DepthSemantics::planar, DepthSemantics::range)),
                gen::set(&PickedTouch::near_is_high), gen::set(&PickedTouch::hold),
                gen::set(&PickedTouch::focal, anywhere(4, 64)),
                gen::set(&PickedTouch::off_axis, anywhere(-3, 4)),
                gen::set(&PickedTouch::friction, gen::element(0, 0, 0, 3, 6, 9)),
                gen::set(&PickedTouch::height_share, gen::element(0, 0, 10, 90)),
                gen::set(&PickedTouch::first, codes), gen::set(&PickedTouch::second, codes),
                gen::set(&PickedTouch::heights, codes),
                gen::set(&PickedTouch::ticks,
                         gen::container<std::vector<PickedTick>>(gen::arbitrary<PickedTick>())));
        });
    }
};

}  // namespace rc

namespace touchable::stress {

namespace {

// Read by RapidCheck when its first property is checked; what the caller has set stands.
const int seeded = setenv("RC_PARAMS", "seed=20081 max_success=400 max_size=40", 0);

std::int64_t ticks_of(const PickedTouch& touch) {
    return static_cast<std::int64_t>(touch.ticks.size());
}

/// Expects that no touch breaks an invariant.
Coverage check_touches(int compare_every) {
    Coverage coverage;
    EXPECT_TRUE(rc::check([&](const PickedTouch& touch) {
        const Watched result = watch(*run_of(touch), {ticks_of(touch), 1, compare_every});
        coverage.add(result.coverage);
        for (const std::string& violation : result.violations) RC_FAIL(violation);
    }));
    std::cout << coverage.in_words() << '\n';
    return coverage;
}

TEST(Property, EveryInvariantHolds) {
    ASSERT_EQ(seeded, 0);
    const Coverage coverage = check_touches(0);
    EXPECT_EQ(coverage.missing({0.1, true}), "") << "hardly a test";
}

TEST(Property, ProxiesAreNearAsReference) {
    const Coverage coverage = check_touches(1);
    EXPECT_GT(coverage.compared, 1000);
    EXPECT_LE(coverage.other_basins * 100, coverage.compared) << "more than ties explain";
}

/// Keeps what every tick gave.
class Forces final : public TickSink {
public:
    void take(const TouchTick& tick, std::span<const FingerState>) override {
        proxies.push_back(tick.contacts[0].proxy);
        forces.push_back(tick.contacts[0].force);
    }
    std::vector<glm::dvec3> proxies, forces;
};

Forces forces_of(const PickedTouch& touch, double unit = 1) {
    Forces forces;
    watch(*run_of(touch, unit), {ticks_of(touch), 0, 0}, &forces);
    return forces;
}

TEST(Property, UnitsLeaveTouchUnchanged) {
    EXPECT_TRUE(rc::check([](const PickedTouch& touch) {
        const Forces plain = forces_of(touch), scaled = forces_of(touch, 4);
        for (std::size_t k = 0; k < plain.forces.size(); ++k) {
            RC_ASSERT(scaled.proxies[k] == 4.0 * plain.proxies[k]);
            RC_ASSERT(scaled.forces[k] == plain.forces[k]);
        }
    }));
}

TEST(Property, LaterTicksChangeNothingBefore) {
    EXPECT_TRUE(rc::check([](PickedTouch touch) {
        const Forces whole = forces_of(touch);
        touch.ticks.resize(touch.ticks.size() / 2);
        const Forces part = forces_of(touch);
        for (std::size_t k = 0; k < part.forces.size(); ++k) RC_ASSERT(part.forces[k] == whole.forces[k]);
    }));
}

// The slow twin and the certificates against what is known without any solver, and against proxies that are
// wrong.

using reference::Finger;
using reference::Real;
using reference::Surface;
using reference::Vec;

double hundred(int, int) {
    return 100;
}

/// A picture of planar depths in whole units; focal length 16 pixels, axis through pixel (8, 8).
class Ground {
public:
    template <class Depth>
    explicit Ground(Depth depth) : scene(whole_unit_scene(17, 1, 1000)) {
        FrameMaker(scene).build(shaped(scene, depth), frame);
    }
    FramePair pair() const { return {{0, 0, &frame}, {0, 0, &frame}, 0}; }
    Surface surface() const { return {scene, pair()}; }

    Scene scene;
    SurfaceFrame frame;
};

Finger at(const Vec& point) {
    Finger finger;
    finger.point = point;
    return finger;
}

Vec solved(const Ground& ground, const Vec& from, const Vec& goal, int substeps = 1) {
    return reference::solve(ground.surface(), at(from), from, goal, substeps).finger.point;
}

void expect_near(const Vec& a, const Vec& b, Real most) {
    EXPECT_LE(std::sqrt(glm::dot(a - b, a - b)), most)
        << "(" << a.x << ", " << a.y << ", " << a.z << ") is not (" << b.x << ", " << b.y << ", " << b.z
        << ")";
}

TEST(ReferenceSolver, FlatWallProxyFacesGoal) {
    const Ground wall(hundred);
    expect_near(solved(wall, {0, 0, -50}, {7, -3, -120}), {7, -3, -100}, 1e-15L);
    expect_near(solved(wall, {0, 0, -50}, {7, -3, -99}), {7, -3, -99}, 0);
}

TEST(ReferenceSolver, TiltedPlaneProxyIsFoot) {
    // 1 / depth linear over the picture is a plane: x = (i - 8) d / 16, d = 1 / (0.01 + 0.0001 (i - 8)), so
    // that 0.01 d + 0.0016 x = 1.
    Ground plane(hundred);
    std::vector<double> depths;
    for (int y = 0; y < 17; ++y)
        for (int x = 0; x < 17; ++x) depths.push_back(1 / (0.01 + 0.0001 * (x - 8)));
    plane.frame.codes.clear();
    plane.frame.vertices = std::make_unique<ExactVertices>(17, 17, depths);
    const Vec goal{4, 2, -115};
    const Vec normal{-0.0016L, 0, 0.01L};  // of 0.01 z - 0.0016 x + 1 = 0
    const Vec foot = goal - normal * ((glm::dot(normal, goal) + 1) / glm::dot(normal, normal));
    expect_near(solved(plane, {0, 0, -40}, goal), foot, 1e-12L);
}

TEST(ReferenceSolver, FindsValleyFloorLeavesRoof) {
    const Ground valley([](int x, int) { return 100.0 - 8 * std::abs(x - 8); });
    expect_near(solved(valley, {0, 0, -20}, {0.5L, 1, -110}), {0, 1, -100}, 1e-15L);
    const Ground roof([](int x, int) { return 100.0 + 8 * std::abs(x - 8); });
    EXPECT_GT(solved(roof, {0.5L, 0, -50}, {0.5L, 0, -110}).x, 1);
    EXPECT_LT(solved(roof, {-0.5L, 0, -50}, {-0.5L, 0, -110}).x, -1);
}

TEST(ReferenceSolver, HitsThinSpike) {
    const Ground spike([](int x, int y) { return x == 8 && y == 8 ? 20.0 : 100.0; });
    // From one side of it to the other, in front of the ground.
    const Vec from{-10, 0, -60}, to{10, 0, -60};
    const auto hit = reference::first_hit(spike.surface(), from, nullptr, to);
    ASSERT_TRUE(hit);
    EXPECT_LT(reference::point_of(spike.surface(), *hit).x, 0);
    EXPECT_FALSE(reference::first_hit(spike.surface(), from, nullptr, {-10, 5, -60}));
}

TEST(ReferenceSolver, FrictionKeepsBothCones) {
    Ground wall(hundred);
    wall.scene.default_properties = {1000, 0.5, 0.3};
    const Surface surface = wall.surface();
    const Finger landed = reference::solve(surface, at({0, 0, -50}), {0, 0, -50}, {0, 0, -101}).finger;
    expect_near(reference::solve(surface, landed, {}, {0.49L, 0, -101}).finger.point, {0, 0, -100}, 1e-15L);
    expect_near(reference::solve(surface, landed, {}, {0.51L, 0, -101}).finger.point, {0.51L - 0.3L, 0, -100},
                1e-8L);
}

TEST(ReferenceSolver, SubstepsReachSameMinimum) {
    const Ground bowl([](int x, int y) { return 100.0 - (x - 8) * (x - 8) / 4 - (y - 8) * (y - 8) / 8; });
    expect_near(solved(bowl, {0, 0, -40}, {3, 2, -120}), solved(bowl, {0, 0, -40}, {3, 2, -120}, 64), 1e-12L);
}

Proxy on_face(int i, int j, double a, double b) {
    Proxy proxy;
    proxy.feature = Feature::face_lower;
    proxy.i = i;
    proxy.j = j;
    proxy.a = a;
    proxy.b = b;
    return proxy;
}
Vec point_of(const Surface& surface, const Proxy& proxy) {
    return reference::point_of(surface, reference::place_of(surface, proxy));
}

/// A proxy where the fast solver puts it on a drawn field, to be tampered with.
class Certificates : public testing::Test {
protected:
    template <class Judge>
    int for_proxies(Judge judge) {
        SplitMix64 random(5);
        int judged = 0;
        for (int picture = 0; picture < 20; ++picture) {
            Scene scene = draw_scene(random, 24);
            scene.default_properties = {1000, 0, 0};
            scene.haptic.static_friction = scene.haptic.dynamic_friction = {0, 0};
            SurfaceFrame frame;
            FrameMaker(scene).build(draw_noise(scene, random), frame);
            const FramePair pair{{0, 0, &frame}, {0, 0, &frame}, 0};
            const auto solver = TouchSolver::create(scene, {});
            TouchStep step(*solver, {}, 1);
            Walk walk(scene, random.next());
            for (int tick = 0; tick < 50; ++tick) {
                step.goals()[0] = walk.next();
                const TouchTick done = step.run(tick, 0, scene, pair);
                const Proxy& proxy = step.states()[0].proxy;
                if (!proxy.on_surface() || done.contacts[0].counts.capped) continue;
                judge(Surface(scene, pair), proxy, done.contacts[0].goal);
                ++judged;
            }
        }
        return judged;
    }
};

TEST_F(Certificates, PassWhereTheSolverRests) {
    const int judged = for_proxies([](const Surface& surface, const Proxy& proxy, const glm::dvec3& goal) {
        EXPECT_LT(reference::way_left(surface, proxy, goal), 1e-6L);
        EXPECT_LT(reference::excess_over_minimum(surface, proxy, goal), 1e-9L);
        EXPECT_LT(reference::depth_behind(surface, proxy.point), 1e-12L);
    });
    EXPECT_GT(judged, 300);
}

TEST_F(Certificates, CatchProxyAside) {
    int tampered = 0;
    for_proxies([&](const Surface& surface, Proxy proxy, const glm::dvec3& goal) {
        if (proxy.feature != Feature::face_lower || proxy.a > 0.99 || proxy.b < 0.01) return;
        if (glm::dot(goal - proxy.point, goal - proxy.point) < 1e-6) return;
        proxy.a += 1e-3;
        proxy.point = glm::dvec3(point_of(surface, proxy));
        EXPECT_GT(reference::way_left(surface, proxy, goal), 1e-7L);
        ++tampered;
    });
    EXPECT_GT(tampered, 20);
}

TEST_F(Certificates, CatchProxyBehind) {
    for_proxies([](const Surface& surface, const Proxy& proxy, const glm::dvec3&) {
        EXPECT_GT(reference::depth_behind(surface, proxy.point * (1 + 2e-9)), 1e-9L);
    });
}

TEST_F(Certificates, CatchProxyThatShouldLeave) {
    int asked = 0;
    for_proxies([&](const Surface& surface, const Proxy& proxy, const glm::dvec3& goal) {
        const glm::dvec3 in_front = proxy.point * 0.9;
        EXPECT_GT(reference::way_left(surface, proxy, in_front), 1e-3L);
        asked += goal != in_front;
    });
    EXPECT_GT(asked, 300);
}

TEST_F(Certificates, FrictionHoldsOnlySoFar) {
    Ground wall(hundred);
    wall.scene.default_properties = {1000, 0.5, 0.3};
    Proxy proxy = on_face(8, 8, 0.5, 0.25);
    proxy.point = glm::dvec3(point_of(wall.surface(), proxy));
    const glm::dvec3 held = proxy.point + glm::dvec3(0.49, 0, -1),
                     slips = proxy.point + glm::dvec3(0.6, 0, -1);
    EXPECT_EQ(reference::way_left(wall.surface(), proxy, held), 0);
    EXPECT_NEAR(static_cast<double>(reference::way_left(wall.surface(), proxy, slips)), 0.1, 1e-6);
    proxy.sliding = true;
    EXPECT_NEAR(static_cast<double>(reference::way_left(wall.surface(), proxy, held)), 0.19, 1e-6);
}

TEST(ReferenceComparison, CatchesWrongForceAndBasin) {
    const Ground wall(hundred);
    Proxy before, after = on_face(8, 7, 0.75, 0.5);
    before.point = {0, 0, -50};
    const glm::dvec3 there(point_of(wall.surface(), after));
    Contact contact;
    contact.touching = true;
    contact.proxy = there;
    contact.goal = there - glm::dvec3(0, 0, 1);
    auto compared = [&] { return reference::compare(wall.surface(), before, after, contact); };
    EXPECT_TRUE(compared().same_basin);
    EXPECT_LT(compared().angle_degrees, 1e-9L);
    EXPECT_LE(compared().farther, 0);
    contact.proxy.x += 1e-6;
    EXPECT_TRUE(compared().same_basin);
    EXPECT_NEAR(static_cast<double>(compared().angle_degrees), 1e-6 * 180 / 3.14159265, 1e-8);
    contact.proxy.x += 3;
    after.i = 9;
    EXPECT_FALSE(compared().same_basin);
    EXPECT_GT(compared().distance_ratio, 2);
    contact.proxy.z = 100;
    EXPECT_GT(compared().farther, 0.1L);
}

}  // namespace
}  // namespace touchable::stress
