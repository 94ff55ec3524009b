// What keys are called on keyboards of many languages. GLFW's numbers of letters and digits are those of
// ASCII.
#include <gtest/gtest.h>

#include "player/window/command_table.hpp"
#include "player/window/screen.hpp"
#include "player/window/window_command.hpp"

namespace touchable::test {
namespace {

TEST(Keys, AreLettersAsTheyArePrinted) {
    EXPECT_EQ(name_of_key('Q', "q"), "q");
    EXPECT_EQ(name_of_key('Q', "a"), "a") << "French";
    EXPECT_EQ(name_of_key('Y', "z"), "z") << "German";
    EXPECT_EQ(name_of_key(59, "m"), "m") << "French, where others have a semicolon";
    EXPECT_EQ(name_of_key('I', "\u0131"), "") << "Turkish, which has an i elsewhere";
    EXPECT_EQ(name_of_key('M', ","), "") << "French: comes as a sign";
}

TEST(Keys, AreThoseOfTheSamePlaceWhereNoLatinLetterIs) {
    EXPECT_EQ(name_of_key('F', "\u0430"), "f") << "Russian";
    EXPECT_EQ(name_of_key('F', "\u03c6"), "f") << "Greek";
    EXPECT_EQ(name_of_key('F', "\u05db"), "f") << "Hebrew";
    EXPECT_EQ(name_of_key('F', nullptr), "f");
    EXPECT_EQ(name_of_key(59, "\u0436"), "") << "Russian, where no letter is";
}

TEST(Keys, AreDigitsWhateverIsPrintedThere) {
    EXPECT_EQ(name_of_key('2', "2"), "2");
    EXPECT_EQ(name_of_key('2', "\u00e9"), "2") << "French";
    EXPECT_EQ(name_of_key('1', "&"), "1") << "French";
    EXPECT_EQ(name_of_key('1', "+"), "") << "Czech: the sign does something itself";
    EXPECT_EQ(name_of_key(321, "1"), "1") << "of the block of digits";
}

TEST(Keys, AreSignsByWhatWasTyped) {
    for (const KeyBinding& binding : key_bindings()) {
        const std::string key = binding.key;
        const bool is_sign = key.size() == 1 && !std::isalnum(static_cast<unsigned char>(key[0]));
        if (!is_sign) continue;
        EXPECT_EQ(name_of_sign(static_cast<unsigned char>(key[0])), key);
        EXPECT_EQ(name_of_key(key[0], binding.key), "") << key << " would count twice";
        EXPECT_FALSE(binding.shift) << key << " is typed with it or without";
    }
    EXPECT_EQ(name_of_sign(0x61F), "?") << "Arabic";
    for (const unsigned other :
         {unsigned{'a'}, unsigned{'Z'}, unsigned{'7'}, unsigned{' '}, 0x7FU, 0xDFU, 0x430U, 0x1F600U})
        EXPECT_EQ(name_of_sign(other), "");
}

}  // namespace
}  // namespace touchable::test
