#pragma once

// JSON from outside, read member by member with checks.
//
// parse takes a whole text, within limits of size and depth. A Node is one value of it with its path: its
// functions give the value as what it must be, or throw a Refusal, which names the member by its path, its
// value and what would be right. Members that are not known are refused by Node::allow_only.
//
// Here alone is thrown across functions: read_checked, or the one that reads a text, catches a Refusal, and
// the library's own exceptions, and makes an Error of it, so that none leaves a module. Include it only where
// JSON is read: it brings nlohmann/json.
//
// A Node refers to the Json that it is of. Pure functions, for any thread.

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

/// Larger than any text of ours could be.
inline constexpr std::size_t largest_text = 1 << 20;

/// What is wrong, at which member or byte, and what would be right.
struct Refusal {
    std::string message;
};

/// One value per text of up to `largest` bytes, no member twice, and no deeper nesting than a library that
/// recurses can stand; refused by line and byte (from the start) otherwise. All JSON that was not written by
/// this very run goes through here.
Json parse(std::string_view text, std::size_t largest = largest_text);

/// A value and its path, such as depth.invalid[1]; the empty path is the whole text.
class Node {
public:
    Node(const Json& value, std::string path) : value_(value), path_(std::move(path)) {}

    /// Throws "<path> is <value>: must be <right>".
    [[noreturn]] void refuse(const std::string& right) const;

    /// Refuses what is not an object, and members other than these.
    void allow_only(const std::vector<std::string>& legal) const;
    bool is_object() const { return value_.is_object(); }
    bool is_list() const { return value_.is_array(); }
    bool has(const char* member) const { return value_.contains(member); }  ///< false where this is no object
    /// Names of an object's members.
    std::vector<std::string> members() const;
    Node operator[](const char* member) const;  ///< a member that must be there

    double number() const;
    std::int64_t integer(std::int64_t least, std::int64_t most) const;
    /// Not negative.
    int whole() const { return static_cast<int>(integer(0, std::numeric_limits<int>::max())); }
    std::string text() const;
    std::string json() const { return value_.dump(); }  ///< of any kind, as a text of its own
    std::size_t size() const { return value_.size(); }
    /// Of a list that one; nothing beyond its end.
    std::optional<Node> element(std::size_t number) const;
    std::vector<Node> elements(std::size_t least, std::size_t most, const std::string& right) const;

    /// Which of these names this string is.
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

/// What `read` makes of a text's whole value. What it or the text refuses is an error (ErrorKind::input)
/// whose message begins with `where`.
template <class Read>
auto read_checked(std::string_view text, std::size_t largest, std::string_view where, Read read)
    -> Result<decltype(read(std::declval<const Node&>()))> {
    try {
        const Json json = parse(text, largest);
        return read(Node(json, ""));
    } catch (const Refusal& reason) {
        return input_error(std::string(where) + ": " + reason.message);
    } catch (const Json::exception& fault) {
        return input_error(std::string(where) + ": " + fault.what());
    }
}

}  // namespace touchable::checked_json
