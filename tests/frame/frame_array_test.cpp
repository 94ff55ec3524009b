#include <gtest/gtest.h>

#include "engine/scene/frames.hpp"

namespace touchable::test {
namespace {

using Array = FrameArray<std::uint16_t>;

/// Somebody's memory, and whether it still lives.
struct Lent {
    std::shared_ptr<std::vector<std::uint16_t>> memory =
        std::make_shared<std::vector<std::uint16_t>>(std::vector<std::uint16_t>{7, 8, 9});
    std::weak_ptr<std::vector<std::uint16_t>> watched = memory;

    void give(Array& array) {
        array.adopt(*memory, memory);
        memory.reset();
    }
};

TEST(FrameArray, OwnsWhatItIsResizedTo) {
    Array array;
    EXPECT_TRUE(array.empty());
    array.resize(3);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{0, 0, 0}));
    array[1] = 5;
    array.resize(4);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{0, 5, 0, 0}));
    array.assign(2, 6);
    array.push_back(1);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{6, 6, 1}));
    EXPECT_FALSE(array.adopted());
    array.clear();
    EXPECT_EQ(array.size(), 0U);
}

TEST(FrameArray, ReadsAndWritesAdoptedMemoryWithoutACopyAndKeepsItAlive) {
    Lent lent;
    const std::uint16_t* where = lent.memory->data();
    Array array;
    array.assign(9, 1);
    lent.give(array);
    EXPECT_EQ(array.data(), where);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{7, 8, 9}));
    array[2] = 4;
    EXPECT_EQ((*lent.watched.lock())[2], 4);
    EXPECT_TRUE(array.adopted());
}

TEST(FrameArray, LetsGoOfAdoptedMemoryWhenItsSizeChanges) {
    const auto changes = {+[](Array& a) { a.resize(3); }, +[](Array& a) { a.assign(3, 0); },
                          +[](Array& a) { a.clear(), a.resize(3); }};
    for (const auto change : changes) {
        Lent lent;
        Array array;
        lent.give(array);
        change(array);
        EXPECT_TRUE(lent.watched.expired());
        EXPECT_FALSE(array.adopted());
        EXPECT_EQ(array, (std::vector<std::uint16_t>{0, 0, 0}));
    }
}

TEST(FrameArray, CopiesOwnTheirMemoryAndMovesTakeItAlong) {
    Lent lent;
    Array array;
    lent.give(array);
    Array copy = array;
    EXPECT_FALSE(copy.adopted());
    EXPECT_NE(copy.data(), array.data());
    EXPECT_EQ(copy, array);
    const std::uint16_t* where = array.data();
    Array moved = std::move(array);
    EXPECT_TRUE(moved.adopted());
    EXPECT_EQ(moved.data(), where);
    moved = copy;
    EXPECT_TRUE(lent.watched.expired());
    EXPECT_EQ(moved, (std::vector<std::uint16_t>{7, 8, 9}));
}

}  // namespace
}  // namespace touchable::test
