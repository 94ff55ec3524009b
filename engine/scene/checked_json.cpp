// SPDX-License-Identifier: Apache-2.0
#include "engine/scene/checked_json.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <set>

#include "engine/base/words.hpp"

namespace touchable::checked_json {
namespace {

/// Deeper than any text of ours; the library writes values by recursion.
constexpr std::size_t deepest_nesting = 16;

/// Feeds characters to the parser and records how far it has come, which the parser itself does not tell.
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

/// The value on one line, whatever its bytes, and short enough to read.
std::string shown(const Json& value) {
    return printable(value.dump(-1, ' ', true, Json::error_handler_t::replace), 60);
}

/// Checks a text without making values of it, and keeps the fault that it finds.
class Watch final : public nlohmann::json_sax<Json> {
public:
    Watch(std::string_view text, const char* const& furthest) : text_(text), furthest_(furthest) {}
    const std::string& fault() const { return fault_; }

    bool null() override { return is_shallow(); }
    bool boolean(bool) override { return is_shallow(); }
    bool number_integer(number_integer_t) override { return is_shallow(); }
    bool number_unsigned(number_unsigned_t) override { return is_shallow(); }
    bool number_float(number_float_t, const string_t&) override { return is_shallow(); }
    bool string(string_t&) override { return is_shallow(); }
    bool binary(binary_t&) override { return is_shallow(); }
    bool start_array(std::size_t) override { return begin(); }
    bool end_array() override { return end(); }
    bool start_object(std::size_t) override { return begin(); }
    bool end_object() override { return end(); }
    bool key(string_t& name) override {
        if (!is_shallow()) return false;
        if (members_.back().insert(name).second) return true;
        fault_ =
            position(text_, furthest_) + ": member " + shown(Json(name)) + " is given twice: must be once";
        return false;
    }
    bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& fault) override {
        const std::size_t begin = text_.find_first_not_of(" \t\r\n");
        if (begin == std::string_view::npos || (text_[begin] != '{' && text_[begin] != '[')) {
            fault_ = position(text_, furthest_) + ": is no JSON text: must begin with {";
            return false;
        }
        // "[json.exception...] parse error at ...: syntax error while ... - the reason; last read: '...';
        // ..."
        std::string reason = fault.what();
        if (const auto at = reason.find(" - "); at != std::string::npos) reason.erase(0, at + 3);
        if (const auto at = reason.find("; last read: "); at != std::string::npos)
            reason.erase(at, reason.find("; expected", at) - at);
        fault_ = position(text_, furthest_) + ": must be JSON: " + printable(reason, 200);
        return false;
    }

private:
    bool is_shallow() {
        if (members_.size() <= deepest_nesting) return true;
        fault_ = position(text_, furthest_) + ": nested too deeply: must be at most " +
                 std::to_string(deepest_nesting) + " deep";
        return false;
    }
    bool begin() {
        if (!is_shallow()) return false;
        members_.emplace_back();
        return true;
    }
    bool end() {
        members_.pop_back();
        return true;
    }

    const std::string_view text_;
    const char* const& furthest_;                 // how far the parser has come
    std::vector<std::set<std::string>> members_;  // of each open object; empty for a list
    std::string fault_;
};

}  // namespace

Json parse(std::string_view text, std::size_t largest) {
    if (text.size() > largest)
        throw Refusal{"is more than " + std::to_string(largest) + " bytes of text: must be less"};
    // First check the text. (The library's own callback while it makes values takes time that grows with the
    // square of a list's length.)
    const char* furthest = text.data();
    Watch watch(text, furthest);
    Json::sax_parse(CountingIterator{text.data(), &furthest},
                    CountingIterator{text.data() + text.size(), &furthest}, &watch);
    if (!watch.fault().empty()) throw Refusal{watch.fault()};
    return Json::parse(text.begin(), text.end());
}

void Node::refuse(const std::string& right) const {
    throw Refusal{(path_.empty() ? "the whole" : path_) + " is " + shown(value_) + ": must be " + right};
}

void Node::allow_only(const std::vector<std::string>& legal) const {
    const std::string names = listed(legal);
    if (!value_.is_object()) refuse("an object {...} of " + names);
    for (const auto& item : value_.items())
        if (std::ranges::find(legal, item.key()) == legal.end())
            throw Refusal{"unknown member " + shown(path_of(item.key())) + ": must be one of " + names};
}

Node Node::operator[](const char* member) const {
    if (!value_.is_object()) refuse("an object {...} with a member " + std::string(member));
    if (!has(member)) throw Refusal{path_of(member) + " is missing: must be given"};
    return {value_.at(member), path_of(member)};
}

void Node::check_version(const char* member) const {
    const Node version = (*this)[member];
    if (version.integer(1, 1'000'000) != 1) version.refuse("1, the version that is read here");
}

std::vector<std::string> Node::members() const {
    if (!value_.is_object()) refuse("an object {...}");
    std::vector<std::string> names;
    for (const auto& member : value_.items()) names.push_back(member.key());
    return names;
}

double Node::number() const {
    if (!value_.is_number()) refuse("a number");
    return value_.get<double>();
}

double Node::within(double least, double most, const char* right) const {
    const double number = this->number();
    if (!(number >= least && number <= most)) refuse(right);
    return number;
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

std::string Node::text() const {
    if (!value_.is_string()) refuse("a string");
    return value_.get<std::string>();
}

bool Node::boolean() const {
    if (!value_.is_boolean()) refuse("true or false");
    return value_.get<bool>();
}

std::size_t Node::one_of(const std::vector<const char*>& names) const {
    std::string all;
    for (std::size_t k = 0; k < names.size(); ++k) {
        if (value_ == names[k]) return k;
        all += (k == 0 ? "\"" : ", \"") + std::string(names[k]) + "\"";
    }
    refuse("one of " + all);
}

std::vector<Node> Node::elements(std::size_t least, std::size_t most, const std::string& right) const {
    if (!value_.is_array() || value_.size() < least || value_.size() > most) refuse(right);
    std::vector<Node> nodes;
    for (std::size_t k = 0; k < value_.size(); ++k)
        nodes.emplace_back(value_[k], path_ + "[" + std::to_string(k) + "]");
    return nodes;
}

std::optional<Node> Node::element(std::size_t number) const {
    if (!value_.is_array()) refuse("an array");
    if (number >= value_.size()) return std::nullopt;
    return Node(value_[number], path_ + "[" + std::to_string(number) + "]");
}

}  // namespace touchable::checked_json
