// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON from outside, read member by member with checks.
//
// parse reads a whole text, within limits of size and depth. A Node is one value with its path: its functions
// return the value as the required type, or throw a Refusal, which names the member by its path, its value
// and what would be right. Node::allow_only refuses unknown members.
//
// Exceptions pass through the functions of a parser: read_checked, or `checked` around what reads, turns
// a Refusal, or an exception of the library, into an Error, so that none leaves a module. Include this header
// only to read JSON: it includes nlohmann/json.
//
// A Node refers to its Json, which must outlive it.
// Threads: any; pure functions.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable::checked_json {

using Json = nlohmann::json;

/// Bytes; larger than any text of this project.
inline constexpr std::size_t largest_text = 1 << 20;

/// What is wrong, at which member or byte, and what would be right.
struct Refusal {
    std::string message;
};

/// Parses one value from a text of up to `largest` bytes, with no member twice, and no deeper nesting than a
/// library that recurses can stand; otherwise throws a Refusal with line and byte (from the start). All JSON
/// that was not written by this very run goes through here.
Json parse(std::string_view text, std::size_t largest = largest_text);

/// A value and its path, such as depth.invalid[1]; the empty path is the whole text.
class Node {
public:
    Node(const Json& value, std::string path) : value_(value), path_(std::move(path)) {}

    /// Throws "<path> is <value>: must be <right>".
    [[noreturn]] void refuse(const std::string& right) const;

    /// Refuses a value that is not an object, and members other than these.
    void allow_only(const std::vector<std::string>& legal) const;
    bool is_object() const { return value_.is_object(); }
    bool is_list() const { return value_.is_array(); }
    bool has(const char* member) const { return value_.contains(member); }  ///< false if this is no object
    /// Names of an object's members.
    std::vector<std::string> members() const;
    Node operator[](const char* member) const;  ///< a required member
    /// Refuses a text whose format's version, which this member states, is not 1.
    void check_version(const char* member) const;

    double number() const;
    double within(double least, double most, const char* right) const;  ///< refuses a number beyond these
    std::int64_t integer(std::int64_t least, std::int64_t most) const;
    int whole(int least = 0, int most = std::numeric_limits<int>::max()) const {
        return static_cast<int>(integer(least, most));
    }
    std::string text() const;
    bool boolean() const;
    std::string json() const { return value_.dump(); }  ///< any value, as JSON text
    std::size_t size() const { return value_.size(); }
    /// The element of a list with this index; nullopt beyond its end.
    std::optional<Node> element(std::size_t number) const;
    std::vector<Node> elements(std::size_t least, std::size_t most, const std::string& right) const;

    /// Returns the index of this string in `names`.
    std::size_t one_of(const std::vector<const char*>& names) const;
    /// The choice whose name this string is.
    template <class Choice, std::size_t n>
    Choice one_of(const std::pair<const char*, Choice> (&choices)[n]) const {
        std::vector<const char*> names;
        for (const auto& choice : choices) names.push_back(choice.first);
        return choices[one_of(names)].second;
    }

private:
    std::string path_of(const std::string& member) const {
        return path_.empty() ? member : path_ + "." + member;
    }

    const Json& value_;
    std::string path_;
};

/// Returns what `read` makes of JSON. If that is refused, returns an error (ErrorKind::input) whose message
/// begins with `where`.
auto checked(std::string_view where, auto read) -> Result<decltype(read())> {
    try {
        return read();
    } catch (const Refusal& reason) {
        return input_error(std::string(where) + ": " + reason.message);
    } catch (const Json::exception& fault) {
        return input_error(std::string(where) + ": " + fault.what());
    }
}

/// Returns what `read` makes of a text's whole value; `read` or `parse` may refuse it.
auto read_checked(std::string_view text, std::size_t largest, std::string_view where, auto read) {
    return checked(where, [&] {
        const Json json = parse(text, largest);
        return read(Node(json, ""));
    });
}

}  // namespace touchable::checked_json
