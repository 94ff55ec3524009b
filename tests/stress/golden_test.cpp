// Forces that are known to the bit, straight from the solver: no clip, no hand file, no program between.
#include <gtest/gtest.h>

#include "tests/stress/golden_runs.hpp"
#include "tests/stress/watch.hpp"

namespace touchable::stress {
namespace {

class Golden : public testing::TestWithParam<GoldenRun> {};

TEST_P(Golden, ForcesAreTheKnownOnesToTheBitWithEitherBuilder) {
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

INSTANTIATE_TEST_SUITE_P(Scenes, Golden, testing::ValuesIn(golden_runs().begin(), golden_runs().end()),
                         [](const auto& run) {
                             std::string name(run.param.name);
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

}  // namespace
}  // namespace touchable::stress
