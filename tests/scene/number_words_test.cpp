#include "engine/base/words.hpp"

#include <gtest/gtest.h>

#include <string>

namespace touchable {
namespace {

TEST(Formatted, IsWhatPrintfWritesOfAnyLength) {
    EXPECT_EQ(formatted("nothing"), "nothing");
    EXPECT_EQ(formatted("%d x %.2f %% of %s", 3, 0.125, "it"), "3 x 0.12 % of it");
    const std::string many(100'000, 'x');
    EXPECT_EQ(formatted("<%s>", many.c_str()), "<" + many + ">");
}

TEST(ExactNumber, HasTheFewestDigitsThatAreReadAsIt) {
    EXPECT_EQ(exact_number(0.1), "0.1");
    EXPECT_EQ(exact_number(0.1F), "0.1");
    EXPECT_EQ(exact_number(static_cast<double>(0.1F)), "0.10000000149011612");
    EXPECT_EQ(exact_number(100000.0), "1e+05");
    EXPECT_EQ(exact_number(100000.0, std::chars_format::general), "100000");
    EXPECT_EQ(exact_number(-12), "-12");
}

TEST(DecimalOf, AFloatIsTheNumberThatWasWritten) {
    EXPECT_EQ(decimal_of(0.001F), 0.001);
    EXPECT_EQ(decimal_of(-3.0F), -3.0);
}

TEST(ShortNumber, KeepsAllDigitsOfALargeOne) {
    EXPECT_EQ(short_number(0.00123456), "0.001235");
    EXPECT_EQ(short_number(123456.4), "123456");
    EXPECT_EQ(short_number(1e-9, 2), "1e-09");
    EXPECT_EQ(short_number(-0.0), "0");
}

TEST(TrimmedNumber, EndsInNoZeros) {
    EXPECT_EQ(trimmed_number(12.5), "12.5");
    EXPECT_EQ(trimmed_number(100), "100");
    EXPECT_EQ(trimmed_number(0.0000004), "0");
}

}  // namespace
}  // namespace touchable
