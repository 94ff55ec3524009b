// SPDX-License-Identifier: Apache-2.0
// Every target over its seeds: whole, cut at many lengths, and changed a few hundred times. `./run fuzz` does
// the same for minutes, led by what code is reached.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "engine/scene/plane_memory.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {

/// For messages of GoogleTest.
void PrintTo(const Target& target, std::ostream* out) {
    *out << target.name;
}

namespace {

class Parsers : public ::testing::TestWithParam<Target> {
protected:
    /// Whether the bytes were taken; a test that fails otherwise.
    static bool stands(std::string_view bytes, const std::string& what) {
        try {
            return parse_in_memory(GetParam(), bytes);
        } catch (const Fault& fault) {
            ADD_FAILURE() << what << ": " << fault.what;
        } catch (const std::exception& escaped) {
            ADD_FAILURE() << what << ": an exception left the parser: " << escaped.what();
        }
        return false;
    }
};

/// All of them where there are few, else those at the beginning, at the end, and some between.
bool is_cut_here(std::size_t length, std::size_t whole) {
    constexpr std::size_t near_an_end = 24, between = 61;
    return length < near_an_end || length + near_an_end > whole || length % (1 + whole / between) == 0;
}

TEST_P(Parsers, SurviveSeedsCutAnywhere) {
    int taken = 0;
    for (const Seed& seed : seeds_of(GetParam())) {
        const bool is_taken_whole = stands(seed.bytes, seed.name);
        taken += is_taken_whole ? 1 : 0;
        for (std::size_t length = 0; length < seed.bytes.size(); ++length) {
            if (!is_cut_here(length, seed.bytes.size())) continue;
            const std::string what = seed.name + " cut to " + std::to_string(length) + " bytes";
            const bool is_cut_taken = stands(std::string_view(seed.bytes).substr(0, length), what);
            const bool may_be = !is_taken_whole || !GetParam().refuses_cut(length, seed.bytes.size());
            EXPECT_TRUE(may_be || !is_cut_taken) << what;
        }
    }
    EXPECT_GT(taken, 0) << "no seed is what the parser reads";
}

TEST_P(Parsers, SurviveChanges) {
    const auto seeds = seeds_of(GetParam());
    std::minstd_rand random(7);
    const auto below = [&](std::size_t limit) { return static_cast<std::size_t>(random()) % limit; };
    for (int trial = 0; trial < GetParam().changes; ++trial) {
        const Seed& seed = seeds[static_cast<std::size_t>(trial) % seeds.size()];
        std::string changed = seed.bytes;
        for (std::size_t k = below(4) + 1; k > 0 && !changed.empty(); --k)
            changed[below(changed.size())] = static_cast<char>(below(256));
        if (trial % 5 == 0 && !changed.empty()) changed.erase(below(changed.size()), below(9));
        (void)stands(changed, seed.name + ", change " + std::to_string(trial));
    }
}

INSTANTIATE_TEST_SUITE_P(All, Parsers, ::testing::ValuesIn(all_targets()),
                         [](const auto& target) { return std::string(target.param.name); });

// The count of an input's memory.

/// A parser that allocates 1 KiB so many times, one after the other.
bool take_kibibytes(std::string_view bytes) {
    std::vector<std::vector<char>> taken;
    for (std::size_t k = 0; k < 1024 * bytes.size(); ++k) taken.emplace_back(1024);
    return !taken.empty();
}

TEST(InputMemory, CountsLiveAllocations) {
    const Target target{.name = "kibibytes", .parse = take_kibibytes, .most_live_mebibytes = 4};
    for (int again = 0; again < 8; ++again)
        EXPECT_TRUE(parse_in_memory(target, "abc")) << "what was given back does not count";
    EXPECT_THROW((void)parse_in_memory(target, "abcde"), Fault);
    EXPECT_TRUE(parse_in_memory(target, "abc"));
}

/// Planes of a MiB that are all kept.
bool take_planes(std::string_view bytes) {
    std::vector<std::shared_ptr<std::uint8_t>> taken;
    for (std::size_t k = 0; k < bytes.size(); ++k) taken.push_back(take_plane_memory(std::size_t{1} << 20));
    return taken.back() != nullptr;
}

TEST(InputMemory, CountsPlanes) {
    const Target target{.name = "planes", .parse = take_planes, .most_live_mebibytes = 4};
    for (int again = 0; again < 8; ++again) EXPECT_TRUE(parse_in_memory(target, "abc"));
    EXPECT_THROW((void)parse_in_memory(target, "abcde"), Fault);
    EXPECT_TRUE(parse_in_memory(target, "abc"));
}

}  // namespace
}  // namespace touchable::fuzz
