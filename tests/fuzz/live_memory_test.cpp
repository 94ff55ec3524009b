// The count of an input's memory.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "engine/scene/plane_memory.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

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
