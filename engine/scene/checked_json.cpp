#include "engine/scene/checked_json.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <set>

#include "engine/printable.hpp"

namespace touchable::checked_json {
namespace {

/// Deeper than any text of ours; the library writes values by recursion.
constexpr int deepest_nesting = 16;

/// Reads characters for the parser and leaves behind how far it has come, which the parser itself does not
/// tell.
struct CountingIterator {
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    const char* at;
    const char** furthest;

    reference operator*() const { return *at; }
    CountingIterator& operator++() {
        *furthest = std::max(*furthest, ++at);
        return *this;
    }
    bool operator==(const CountingIterator& other) const { return at == other.at; }
    bool operator!=(const CountingIterator& other) const { return at != other.at; }
};

std::string position(std::string_view text, const char* at) {
    const auto line = 1 + std::count(text.data(), at, '\n');
    return "line " + std::to_string(line) + ", byte " + std::to_string(at - text.data());
}

/// On one line whatever its bytes, and not longer than a person reads.
std::string shown(const Json& value) {
    return printable(value.dump(-1, ' ', true, Json::error_handler_t::replace), 60);
}

}  // namespace

Json parse(std::string_view text, std::size_t largest) {
    if (text.size() > largest)
        throw Refusal{"is more than " + std::to_string(largest) + " bytes of text: must be less"};
    const char* furthest = text.data();
    std::vector<std::set<std::string>> members;  // of each object around the place read
    const auto watch = [&](int depth, Json::parse_event_t event, Json& value) {
        if (depth > deepest_nesting)
            throw Refusal{position(text, furthest) + ": nested too deeply: must be at most " +
                          std::to_string(deepest_nesting) + " deep"};
        if (event == Json::parse_event_t::object_start) members.emplace_back();
        if (event == Json::parse_event_t::object_end) members.pop_back();
        if (event == Json::parse_event_t::key && !members.back().insert(value.get<std::string>()).second)
            throw Refusal{position(text, furthest) + ": member " + shown(value) +
                          " is given twice: must be once"};
        return true;
    };
    try {
        return Json::parse(CountingIterator{text.data(), &furthest},
                           CountingIterator{text.data() + text.size(), &furthest}, watch);
    } catch (const Json::exception& fault) {
        const std::string what = fault.what();  // "[json.exception...] parse error at ...: the reason"
        const std::size_t reason = what.find("] ");
        throw Refusal{position(text, furthest) + ": must be JSON: " +
                      printable(what.substr(reason == std::string::npos ? 0 : reason + 2), 200)};
    }
}

void Node::refuse(const std::string& right) const {
    throw Refusal{(path_.empty() ? "the whole" : path_) + " is " + shown(value_) + ": must be " + right};
}

void Node::allow_only(const std::vector<std::string>& legal) const {
    std::string names;
    for (const std::string& name : legal) names += (names.empty() ? "" : ", ") + name;
    if (!value_.is_object()) refuse("an object {...} of " + names);
    for (const auto& item : value_.items())
        if (std::find(legal.begin(), legal.end(), item.key()) == legal.end())
            throw Refusal{"unknown member " + shown(path_of(item.key())) + ": must be one of " + names};
}

Node Node::operator[](const char* member) const {
    if (!value_.is_object()) refuse("an object {...} with a member " + std::string(member));
    if (!has(member)) throw Refusal{path_of(member) + " is missing: must be given"};
    return {value_.at(member), path_of(member)};
}

double Node::number() const {
    if (!value_.is_number()) refuse("a number");
    return value_.get<double>();
}

std::int64_t Node::integer(std::int64_t least, std::int64_t most) const {
    const bool too_large = value_.is_number_unsigned() && value_.get<std::uint64_t>() > std::uint64_t{1}
                                                                                            << 62;
    if (value_.is_number_integer() && !too_large) {
        const auto number = value_.get<std::int64_t>();
        if (number >= least && number <= most) return number;
    }
    refuse("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
}

int Node::whole() const {
    return static_cast<int>(integer(0, std::numeric_limits<int>::max()));
}

std::string Node::text() const {
    if (!value_.is_string()) refuse("a string");
    return value_.get<std::string>();
}

std::vector<Node> Node::elements(std::size_t least, std::size_t most, const std::string& right) const {
    if (!value_.is_array() || value_.size() < least || value_.size() > most) refuse(right);
    std::vector<Node> nodes;
    for (std::size_t k = 0; k < value_.size(); ++k)
        nodes.emplace_back(value_[k], path_ + "[" + std::to_string(k) + "]");
    return nodes;
}

std::string Node::path_of(const std::string& member) const {
    return path_.empty() ? member : path_ + "." + member;
}

}  // namespace touchable::checked_json
