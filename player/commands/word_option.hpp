#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

namespace touchable {

template <class Value>
using Words = std::vector<std::pair<std::string, Value>>;

/// An option whose value, an enumerator, is said by one of some words. `what` says which.
template <class Value, class Option>
CLI::Option* add_word_option(CLI::App& sub, const std::string& name, Option& option, const std::string& what,
                             const Words<Value>& words) {
    const CLI::Validator to_number(
        [words](std::string& text) {
            std::string known;
            for (const auto& [word, value] : words) {
                if (word == text) {
                    text = std::to_string(static_cast<int>(value));
                    return std::string();
                }
                known += (known.empty() ? "" : ", ") + word;
            }
            return std::string("'").append(text).append("' is none of ").append(known);
        },
        "");
    return sub.add_option(name, option, what)->transform(to_number)->type_name("WORD");
}

}  // namespace touchable
