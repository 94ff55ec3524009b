#include "player/window/touch_screens.hpp"

#include <linux/input-event-codes.h>

#include <fstream>
#include <string>
#include <system_error>
#include <vector>

namespace touchable {
namespace {

/// Of a set of bits as the kernel prints one: words of a `long` each in hexadecimal, the highest first.
bool has_bit(const std::filesystem::path& file, std::size_t bit) {
    std::ifstream in(file);
    std::vector<unsigned long> words;
    for (unsigned long word = 0; in >> std::hex >> word;) words.push_back(word);
    constexpr std::size_t bits = 8 * sizeof(unsigned long);
    const std::size_t number = bit / bits;
    return number < words.size() && (words[words.size() - 1 - number] >> (bit % bits) & 1U) != 0;
}

}  // namespace

bool has_touch_screen(const std::filesystem::path& inputs) {
    std::error_code failed;
    for (std::filesystem::directory_iterator at(inputs, failed), end; !failed && at != end;
         at.increment(failed))
        if (has_bit(at->path() / "properties", INPUT_PROP_DIRECT) &&
            has_bit(at->path() / "capabilities/abs", ABS_MT_POSITION_X))
            return true;
    return false;
}

}  // namespace touchable
