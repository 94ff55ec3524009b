#include "engine/base/words.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace touchable::test {
namespace {

TEST(NearestWord, IsTheOneWithTheFewestLettersBetween) {
    const std::vector<std::string> words{"touch", "play", "plot", "info"};
    EXPECT_EQ(nearest_word("tuoch", words), "touch");
    EXPECT_EQ(nearest_word("plat", words), "play") << "the first of two";
    EXPECT_EQ(nearest_word("plott", words), "plot");
    EXPECT_EQ(nearest_word("nfo", words), "info");
}

TEST(NearestWord, IsNoneWhereNoneIsNear) {
    const std::vector<std::string> words{"touch", "play"};
    EXPECT_EQ(nearest_word("convert", words), "");
    EXPECT_EQ(nearest_word("", words), "");
    EXPECT_EQ(nearest_word("p", words), "");
    EXPECT_EQ(nearest_word(std::string(1'000'000, 'x'), words), "");
    EXPECT_EQ(nearest_word("touch", {}), "");
}

}  // namespace
}  // namespace touchable::test
