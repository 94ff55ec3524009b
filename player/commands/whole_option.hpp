#pragma once

#include <CLI/CLI.hpp>
#include <limits>
#include <string>

#include "player/commands/typed_numbers.hpp"

namespace touchable {

/// An option that takes a whole number, `least` to `most`, in decimal as people write it: 010 is ten.
template <class Option>
CLI::Option* add_whole_option(CLI::App& sub, const std::string& name, Option& number, const std::string& what,
                              int least = std::numeric_limits<int>::min(),
                              int most = std::numeric_limits<int>::max()) {
    const CLI::Validator decimal(
        [=](std::string& text) {
            const auto read = read_whole_number<int>("", text, least, most);
            if (!read.ok()) return read.error().message;
            text = std::to_string(*read);
            return std::string();
        },
        "");
    return sub.add_option(name, number, what)->transform(decimal)->type_name("N");
}

}  // namespace touchable
