#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace touchable {

/// Text from outside as a message quotes it: on one line, control characters escaped (\n, \x1b), cut after
/// `most` bytes, which "..." tells.
std::string printable(std::string_view foreign, std::size_t most = 80);
/// The same between double quotes.
std::string in_quotes(std::string_view foreign);
/// A file's name as a command in a message has it: a shell reads it as this one word, whole, and a command
/// not as an option.
std::string shell_word(std::string_view file);

}  // namespace touchable
