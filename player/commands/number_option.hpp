#pragma once

#include <CLI/CLI.hpp>
#include <limits>
#include <string>

#include "player/commands/typed_numbers.hpp"

namespace touchable {

/// An option that takes a finite number, `least` to `most`, or several where `number` is a list of them. (To
/// CLI11's own CLI::Range NaN lies in every range.)
template <class Option>
CLI::Option* add_number_option(CLI::App& sub, const std::string& name, Option& number,
                               const std::string& what, double least = std::numeric_limits<double>::lowest(),
                               double most = std::numeric_limits<double>::max()) {
    const CLI::Validator finite(
        [=](std::string& text) {
            const auto read = read_number("", text, least, most);
            return read.ok() ? std::string() : read.error().message;
        },
        "");
    return sub.add_option(name, number, what)->check(finite);
}

}  // namespace touchable
