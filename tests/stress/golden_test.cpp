// SPDX-License-Identifier: Apache-2.0
// Forces that are known to the bit, straight from the solver: no clip, no hand file, no program between.
#include <gtest/gtest.h>

#include "tests/stress/golden_runs.hpp"
#include "tests/stress/watch.hpp"

namespace touchable::stress {
namespace {

class GoldenForces : public testing::TestWithParam<GoldenRun> {};

TEST_P(GoldenForces, MatchToTheBit) {
    for (const GoldenBuilder builder : {GoldenBuilder::cpu, GoldenBuilder::lazy}) {
        const auto run = GetParam().make(builder);
        ASSERT_NE(run, nullptr);
        const bool holes = GetParam().hole_stiffness > 0;
        const Watched watched = watch(*run, {GoldenRun::ticks, holes ? 1 : 0, 0});
        EXPECT_EQ(watched.force_hash, GetParam().force_hash)
            << (builder == GoldenBuilder::cpu ? "cpu" : "lazy") << " builder; touchable-soak --scene "
            << GetParam().name << " --states and --compare find where";
        EXPECT_GT(watched.coverage.contact_share(), 0.3) << "hardly a test of forces";
        if (holes) {
            EXPECT_GT(watched.coverage.in_holes, 100) << "hardly a test of holes";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, GoldenForces, testing::ValuesIn(golden_runs().begin(), golden_runs().end()),
                         [](const auto& run) { return name_of_test(run.param.name); });

}  // namespace
}  // namespace touchable::stress
