#include "engine/scene/plane_memory.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <set>
#include <thread>
#include <vector>

namespace touchable::test {
namespace {

using Lease = std::shared_ptr<std::uint8_t>;

constexpr std::size_t page = 4096;
/// Free memory that the pool keeps, at most.
constexpr std::size_t bound = std::size_t{256} << 20;

std::uint64_t id_of(const Lease& lease) {
    const auto block = plane_block_of(lease.get(), 1);
    return block ? block->id() : 0;
}

/// Takes and lets go of so many other leases that a size is forgotten which is not among them.
void forget_other_sizes() {
    for (int n = 0; n < 200; ++n) take_plane_memory(page);
}

TEST(PlaneMemory, IsWholePages) {
    for (const std::size_t bytes : {std::size_t{0}, page, page + 1, 3 * page - 1, std::size_t{1} << 20}) {
        const Lease lease = take_plane_memory(bytes);
        ASSERT_NE(lease, nullptr);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lease.get()) % page, 0U);
        const auto block = plane_block_of(lease.get(), bytes);
        ASSERT_NE(block, nullptr);
        EXPECT_EQ(block->data(), lease.get());
        EXPECT_GE(block->bytes(), bytes);
        EXPECT_LT(block->bytes(), bytes + 65536);  // the largest pages of any processor here
        EXPECT_EQ(block->bytes() % page, 0U);
        std::fill_n(lease.get(), bytes, std::uint8_t{1});
    }
}

TEST(PlaneMemory, IsNullWithoutMemory) {
    EXPECT_EQ(take_plane_memory(SIZE_MAX / 2), nullptr);
    EXPECT_EQ(take_plane_memory(SIZE_MAX), nullptr);
}

TEST(PlaneMemory, UsesABlockAgain) {
    Lease lease = take_plane_memory(100'000), copy = lease;
    const std::uint64_t id = id_of(lease);
    lease.reset();
    EXPECT_EQ(id_of(copy), id);
    copy.reset();
    lease = take_plane_memory(100'001);  // as many pages
    EXPECT_EQ(id_of(lease), id);
    const Lease other = take_plane_memory(100'000);
    EXPECT_NE(id_of(other), id);
    EXPECT_NE(other.get(), lease.get());
}

TEST(PlaneMemory, BeginsWithZerosOnRequest) {
    constexpr std::size_t bytes = 5 * page - 7;
    const auto is_zero = [](std::uint8_t byte) { return byte == 0; };
    forget_other_sizes();
    std::uint64_t first = 0;
    for (int n = 0; n < 2; ++n) {
        const Lease lease = take_plane_memory(bytes, PlaneContent::zero);
        if (n == 0) first = id_of(lease);
        EXPECT_EQ(id_of(lease), first);
        EXPECT_TRUE(std::all_of(lease.get(), lease.get() + bytes, is_zero));
        std::fill_n(lease.get(), bytes, std::uint8_t{1});
    }
    EXPECT_EQ(take_plane_memory(bytes).get()[bytes - 1], 1);
}

TEST(PlaneMemory, ForgetsSizesNotAskedFor) {
    Lease lease = take_plane_memory(9 * page);
    const std::uint64_t id = id_of(lease);
    lease.reset();
    forget_other_sizes();
    EXPECT_GT(id_of(take_plane_memory(9 * page)), id);
    // Nor is one kept that comes back when its size is forgotten.
    lease = take_plane_memory(9 * page);
    const std::uint64_t late = id_of(lease);
    forget_other_sizes();
    lease.reset();
    EXPECT_GT(id_of(take_plane_memory(9 * page)), late);
}

TEST(PlaneMemory, KeepsABoundedAmountFree) {
    forget_other_sizes();
    constexpr std::size_t bytes = bound / 4;
    std::vector<Lease> leases;
    std::set<std::uint64_t> before, again;
    for (int n = 0; n < 6; ++n) before.insert(id_of(leases.emplace_back(take_plane_memory(bytes))));
    leases.clear();
    for (int n = 0; n < 6; ++n) {
        const std::uint64_t id = id_of(leases.emplace_back(take_plane_memory(bytes)));
        if (before.contains(id)) again.insert(id);
    }
    // The smallest pages of the test's other leases may be free, too.
    EXPECT_GE(again.size(), 3U);
    EXPECT_LE(again.size(), 4U);
    leases.clear();
    forget_other_sizes();
}

TEST(PlaneMemory, KnowsTheBlockOfAPlane) {
    const Lease lease = take_plane_memory(4 * page);
    const auto block = plane_block_of(lease.get(), 4 * page);
    ASSERT_NE(block, nullptr);
    const std::uint8_t *const begin = block->data(), *const end = begin + block->bytes();
    EXPECT_EQ(plane_block_of(begin + page, page), block);
    EXPECT_EQ(plane_block_of(end - 1, 1), block);
    EXPECT_EQ(plane_block_of(end - 1, 2), nullptr);
    EXPECT_EQ(plane_block_of(begin, block->bytes() + 1), nullptr);
    EXPECT_EQ(plane_block_of(begin, SIZE_MAX), nullptr);
    EXPECT_NE(plane_block_of(begin - 1, 2), block);
    EXPECT_NE(plane_block_of(end, 1), block);
    const std::vector<std::uint8_t> other(4 * page);
    EXPECT_EQ(plane_block_of(other.data(), other.size()), nullptr);
    EXPECT_EQ(plane_block_of(nullptr, 1), nullptr);
}

TEST(PlaneMemory, StaysMappedWhileItsBlockIsHeld) {
    Lease lease = take_plane_memory(7 * page);
    auto block = plane_block_of(lease.get(), 7 * page);
    std::uint8_t* const data = lease.get();
    const auto is_mapped = [&] { return msync(data, 7 * page, MS_ASYNC) == 0; };
    lease.reset();
    EXPECT_EQ(plane_block_of(data, 1), nullptr) << "no plane lies there";
    lease = take_plane_memory(7 * page);
    EXPECT_EQ(id_of(lease), block->id()) << "a block that is held is lent all the same";
    lease.reset();
    forget_other_sizes();
    EXPECT_TRUE(is_mapped());
    block.reset();
    EXPECT_FALSE(is_mapped());
}

TEST(PlaneMemory, IsOneThreadsAtATime) {
    constexpr int threads = 4, rounds = 2000, held = 3;
    const auto work = [](int number, bool& is_own) {
        const auto mark = static_cast<std::uint8_t>(number + 1);
        std::vector<Lease> leases(held);
        for (int n = 0; n < rounds; ++n) {
            // Other threads have these sizes, too.
            const std::size_t bytes = (1 + static_cast<std::size_t>(n % 3)) * page;
            Lease& lease = leases[static_cast<std::size_t>(n % held)];
            lease = take_plane_memory(bytes);
            std::fill_n(lease.get(), bytes, mark);
            for (const Lease& kept : leases)
                is_own = is_own && (!kept || (kept.get()[0] == mark && kept.get()[page - 1] == mark));
            const auto block = plane_block_of(lease.get(), bytes);
            is_own = is_own && block && block->data() == lease.get();
        }
    };
    bool own[threads] = {true, true, true, true};
    std::vector<std::thread> all;
    for (int n = 0; n < threads; ++n) all.emplace_back(work, n, std::ref(own[n]));
    for (std::thread& thread : all) thread.join();
    for (const bool is_own : own) EXPECT_TRUE(is_own);
}

}  // namespace
}  // namespace touchable::test
