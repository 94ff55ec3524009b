// Properties of any touch whatever: RapidCheck picks fields, cameras, codings, hands and changes of frames,
// and makes what fails as small as it can. The seed is fixed, so that a build passes or not;
// RC_PARAMS="seed=..." tries others, and a failure prints the RC_PARAMS that repeat it (docs/proof.md).
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdlib>

#include "tests/stress/picked_run.hpp"
#include "tests/stress/tick_states.hpp"
#include "tests/stress/watch.hpp"

namespace rc {

/// From low to below high, whatever the size of the case.
inline Gen<int> anywhere(int low, int high) {
    return gen::resize(kNominalSize, gen::inRange(low, high));
}

template <>
struct Arbitrary<touchable::stress::PickedTick> {
    static Gen<touchable::stress::PickedTick> arbitrary() {
        using touchable::stress::PickedTick;
        return gen::build<PickedTick>(
            gen::set(&PickedTick::x, anywhere(-8, 56)), gen::set(&PickedTick::y, anywhere(-8, 56)),
            gen::set(&PickedTick::depth, anywhere(-2, 101)), gen::set(&PickedTick::moment, anywhere(0, 8)));
    }
};

template <>
struct Arbitrary<touchable::stress::PickedTouch> {
    static Gen<touchable::stress::PickedTouch> arbitrary() {
        using touchable::stress::PickedTouch;
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
                gen::set(&PickedTouch::kind,
                         gen::element(touchable::DepthCodingKind::linear, touchable::DepthCodingKind::inverse,
                                      touchable::DepthCodingKind::metric)),
                gen::set(&PickedTouch::semantics,
                         gen::element(touchable::DepthSemantics::planar, touchable::DepthSemantics::range)),
                gen::set(&PickedTouch::near_is_high), gen::set(&PickedTouch::hold),
                gen::set(&PickedTouch::focal, anywhere(4, 64)),
                gen::set(&PickedTouch::off_axis, anywhere(-3, 4)),
                gen::set(&PickedTouch::friction, gen::element(0, 0, 0, 3, 6, 9)),
                gen::set(&PickedTouch::height_share, gen::element(0, 0, 10, 90)),
                gen::set(&PickedTouch::first, codes), gen::set(&PickedTouch::second, codes),
                gen::set(&PickedTouch::heights, codes),
                gen::set(&PickedTouch::ticks, gen::container<std::vector<touchable::stress::PickedTick>>(
                                                  gen::arbitrary<touchable::stress::PickedTick>())));
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

Watched watched(const PickedTouch& touch, int compare_every = 0) {
    return watch(*run_of(touch), {ticks_of(touch), 1, compare_every});
}

TEST(Property, EveryInvariantHolds) {
    ASSERT_EQ(seeded, 0);
    Coverage coverage;
    EXPECT_TRUE(rc::check([&](const PickedTouch& touch) {
        const Watched result = watched(touch);
        coverage.add(result.coverage);
        for (const std::string& violation : result.violations) RC_FAIL(violation);
    }));
    EXPECT_EQ(coverage.missing({0.1, true}), "") << "hardly a test";
    std::cout << coverage.in_words() << '\n';
}

TEST(Property, EveryProxyIsAsNearAsTheReferences) {
    Coverage coverage;
    EXPECT_TRUE(rc::check([&](const PickedTouch& touch) {
        const Watched result = watched(touch, 1);
        coverage.add(result.coverage);
        for (const std::string& violation : result.violations) RC_FAIL(violation);
    }));
    EXPECT_GT(coverage.compared, 1000);
    EXPECT_LE(coverage.other_basins * 100, coverage.compared) << "more than ties explain";
    std::cout << coverage.in_words() << '\n';
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

TEST(Property, OtherUnitsGiveTheSameTouchToTheBit) {
    EXPECT_TRUE(rc::check([](const PickedTouch& touch) {
        Forces once, twice;
        watch(*run_of(touch), {ticks_of(touch), 0, 0}, &once);
        watch(*run_of(touch, 4), {ticks_of(touch), 0, 0}, &twice);
        for (std::size_t k = 0; k < once.forces.size(); ++k) {
            RC_ASSERT(twice.proxies[k] == 4.0 * once.proxies[k]);
            RC_ASSERT(twice.forces[k] == once.forces[k]);
        }
    }));
}

TEST(Property, WhatComesLaterChangesNothingBefore) {
    EXPECT_TRUE(rc::check([](PickedTouch touch) {
        Forces whole, part;
        watch(*run_of(touch), {ticks_of(touch), 0, 0}, &whole);
        touch.ticks.resize(touch.ticks.size() / 2);
        watch(*run_of(touch), {ticks_of(touch), 0, 0}, &part);
        for (std::size_t k = 0; k < part.forces.size(); ++k) RC_ASSERT(part.forces[k] == whole.forces[k]);
    }));
}

}  // namespace
}  // namespace touchable::stress
