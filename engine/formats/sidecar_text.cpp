// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/sidecar_text.hpp"

#include <algorithm>
#include <cctype>
#include <pugixml.hpp>
#include <sstream>

#include "engine/base/words.hpp"

namespace touchable {
namespace {

using checked_json::Json;

constexpr std::size_t most_columns = 200, most_lines = 4000, longest_name = 200;
constexpr int deepest_yaml = 16;

/// Index of the separator that ends a field; those within brackets, as in K[0,2], do not.
std::size_t end_of_field(std::string_view line, char between) {
    int open = 0;
    for (std::size_t k = 0; k < line.size(); ++k) {
        open += line[k] == '[' ? 1 : line[k] == ']' ? -1 : 0;
        if (line[k] == between && open <= 0) return k;
    }
    return std::string_view::npos;
}

/// The fields of a line; several blanks count as one.
std::vector<std::string_view> fields_of(std::string_view line, char between) {
    std::vector<std::string_view> fields;
    while (fields.size() <= most_columns) {
        if (between == ' ') line = trimmed(line);
        if (between == ' ' && line.empty()) break;
        const auto end = between == ' ' ? line.find_first_of(" \t") : end_of_field(line, between);
        fields.push_back(trimmed(line.substr(0, end)));
        if (end == std::string_view::npos) break;
        line.remove_prefix(end + 1);
    }
    return fields;
}

bool has_letter(std::string_view text) {
    return std::ranges::any_of(text, [](unsigned char c) { return std::isalpha(c) != 0; });
}

/// The fields' numbers; empty if a field is no number.
std::vector<double> numbers_of(const std::vector<std::string_view>& fields) {
    std::vector<double> numbers;
    for (const std::string_view field : fields) {
        const auto number = parsed_number(field.starts_with('+') ? field.substr(1) : field);
        if (!number) return {};
        numbers.push_back(*number);
    }
    return numbers;
}

Json yaml_scalar(std::string_view text) {
    text = trimmed(text);
    if (const auto number = parsed_number(text)) return *number;
    const bool is_quoted = text.size() > 1 && (text[0] == '"' || text[0] == '\'') && text.back() == text[0];
    return is_quoted ? std::string(text.substr(1, text.size() - 2)) : std::string(text);
}

/// A member's name, which may be a number.
std::string yaml_name(std::string_view text) {
    const Json name = yaml_scalar(text);
    return name.is_string() ? name.get<std::string>() : name.dump();
}

/// A line without its comment, which begins at the start or after a space.
std::string_view without_comment(std::string_view line) {
    char quote = 0;
    for (std::size_t k = 0; k < line.size(); ++k) {
        if (quote != 0 ? line[k] == quote : line[k] == '"' || line[k] == '\'')
            quote = quote != 0 ? 0 : line[k];
        if (quote == 0 && line[k] == '#' && (k == 0 || line[k - 1] == ' ' || line[k - 1] == '\t'))
            return line.substr(0, k);
    }
    return line;
}

/// Parses lists and maps in brackets.
class YamlInBrackets {
public:
    explicit YamlInBrackets(std::string_view text) : rest_(text) {}
    Json value(int depth = 0) {
        skip_spaces();
        if (depth > deepest_yaml || rest_.empty()) return nullptr;
        const char open = rest_[0];
        if (open != '[' && open != '{') return yaml_scalar(taken(rest_.find_first_of(",]}")));
        const char close = open == '[' ? ']' : '}';
        Json made = open == '[' ? Json::array() : Json::object();
        rest_.remove_prefix(1);
        for (skip_spaces(); !rest_.empty() && rest_[0] != close; skip_spaces()) {
            std::string name;
            if (open == '{') {
                name = yaml_name(taken(rest_.find_first_of(":,]}")));
                if (rest_.empty() || rest_[0] != ':') return nullptr;
                rest_.remove_prefix(1);
            }
            Json inner = value(depth + 1);
            if (open == '[')
                made.push_back(std::move(inner));
            else
                made.emplace(std::move(name), std::move(inner));
            skip_spaces();
            if (rest_.empty() || (rest_[0] != ',' && rest_[0] != close)) return nullptr;
            if (rest_[0] == ',') rest_.remove_prefix(1);
        }
        if (rest_.empty()) return nullptr;
        rest_.remove_prefix(1);
        return made;
    }

private:
    std::string_view taken(std::size_t count) {
        const auto begin = rest_.substr(0, count);
        rest_.remove_prefix(begin.size());
        return begin;
    }
    void skip_spaces() {
        while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\t')) rest_.remove_prefix(1);
    }

    std::string_view rest_;
};

class YamlLines {
public:
    explicit YamlLines(std::string_view text) {
        while (!text.empty()) {
            const std::string_view line = without_comment(cut_line(text));
            const std::string_view inner = trimmed(line);
            if (inner == "---" || inner == "...") {
                if (!lines_.empty()) break;
                continue;
            }
            if (inner.empty() || line[0] == '%') continue;
            lines_.push_back({static_cast<std::size_t>(inner.data() - line.data()), inner});
        }
    }

    Json block(std::size_t indent, int depth) {
        if (depth > deepest_yaml) {
            at_ = lines_.size();
            return nullptr;
        }
        if (goes_on(indent) && is_item()) return items(indent, depth);
        Json map = Json::object();
        while (goes_on(indent)) {
            const std::string_view line = lines_[at_].text;
            auto colon = line.find(": ");
            if (colon == std::string_view::npos && line.back() == ':') colon = line.size() - 1;
            ++at_;
            if (colon == std::string_view::npos) continue;
            add(map, yaml_name(line.substr(0, colon)),
                value_of(trimmed(line.substr(colon + 1)), indent, depth));
            // Skips lines that are indented further without a reason.
            while (at_ < lines_.size() && lines_[at_].indent > indent) ++at_;
        }
        return map;
    }

    std::size_t first_indent() const { return lines_.empty() ? 0 : lines_[0].indent; }

private:
    struct Line {
        std::size_t indent;
        std::string_view text;
    };
    bool is_item() const { return lines_[at_].text == "-" || lines_[at_].text.starts_with("- "); }
    bool goes_on(std::size_t indent) const { return at_ < lines_.size() && lines_[at_].indent == indent; }

    Json items(std::size_t indent, int depth) {
        Json list = Json::array();
        while (goes_on(indent) && is_item()) {
            const std::string_view text = trimmed(lines_[at_].text.substr(1));
            const bool is_bracket = text.starts_with('[') || text.starts_with('{');
            if (!text.empty() && !is_bracket && text[0] != '"' && text[0] != '\'' &&
                (text.starts_with("- ") || text.find(": ") != std::string_view::npos || text.back() == ':')) {
                // A map or a list that begins here is read as if in a line of its own, at its place.
                lines_[at_].indent += static_cast<std::size_t>(text.data() - lines_[at_].text.data());
                lines_[at_].text = text;
                list.push_back(block(lines_[at_].indent, depth + 1));
            } else {
                ++at_;
                list.push_back(value_of(text, indent, depth));
            }
        }
        return list;
    }

    /// The value behind a name, or in the lines below it.
    Json value_of(std::string_view text, std::size_t indent, int depth) {
        while (!text.empty() && (text[0] == '!' || text[0] == '&')) {
            const auto end = text.find_first_of(" \t");
            text = end == std::string_view::npos ? std::string_view() : trimmed(text.substr(end));
        }
        if (!text.empty() && (text[0] == '[' || text[0] == '{'))
            return YamlInBrackets(gathered(text)).value();
        if (!text.empty() && text[0] != '|' && text[0] != '>') return yaml_scalar(text);
        if (!text.empty()) {  // a text of several lines, which has no numbers of a camera
            while (at_ < lines_.size() && lines_[at_].indent > indent) ++at_;
            return nullptr;
        }
        if (at_ >= lines_.size()) return nullptr;
        const std::size_t below = lines_[at_].indent;
        return below > indent || (below == indent && is_item()) ? block(below, depth + 1) : Json();
    }

    /// Joins the lines of a value in brackets.
    std::string gathered(std::string_view text) {
        std::string all;
        std::ptrdiff_t open = 0;
        const auto add_text = [&](std::string_view more) {
            for (const char c : more) open += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
            (all += more) += ' ';
        };
        for (add_text(text); open > 0 && at_ < lines_.size(); ++at_) add_text(lines_[at_].text);
        return all;
    }

    /// Adds a member; a name with a point becomes a member of a member.
    static void add(Json& map, std::string_view name, Json value) {
        const auto point = name.find('.');
        Json* within = &map;
        if (point != std::string_view::npos && point > 0 && point + 1 < name.size()) {
            within = &map[std::string(name.substr(0, point))];
            if (within->is_null()) *within = Json::object();
            name.remove_prefix(point + 1);
        }
        if (within->is_object()) within->emplace(std::string(name), std::move(value));
    }

    std::vector<Line> lines_;
    std::size_t at_ = 0;
};

/// Parses YAML in the form in which programs write cameras: maps and lists by indentation or in brackets,
/// numbers and words. Tags, anchors and comments are skipped; only the first document is read, and the first
/// member of a name. A name with a point, such as ORB-SLAM's Camera.fx, becomes a member of a member. Null if
/// the text is no map, is nested deeper than 16, or is none of this.
Json plain_yaml(std::string_view text) {
    YamlLines lines(text);
    Json made = lines.block(lines.first_indent(), 0);
    return made.is_object() && !made.empty() ? std::move(made) : Json();
}

/// An element as JSON: numbers, words, or members; several members of one name become a list.
Json json_of(const pugi::xml_node& node, int depth = 0) {
    constexpr int deepest = 8;
    Json members = Json::object();
    if (depth > deepest) return nullptr;
    for (const pugi::xml_node& child : node.children()) {
        if (child.type() != pugi::node_element) continue;
        Json value = json_of(child, depth + 1);
        auto [there, is_new] = members.emplace(child.name(), Json());
        if (is_new) {
            *there = std::move(value);
            continue;
        }
        if (!there->is_array()) *there = Json::array({std::move(*there)});
        there->push_back(std::move(value));
    }
    // Attributes, if the element has members or is empty: <resolution width="160" height="120"/>.
    if (!members.empty() || node.first_child().empty())
        for (const pugi::xml_attribute& attribute : node.attributes()) {
            const auto number = parsed_number(attribute.value());
            members.emplace(attribute.name(), number ? Json(*number) : Json(std::string(attribute.value())));
        }
    if (!members.empty()) return members;
    std::istringstream words(node.child_value());
    Json list = Json::array();
    for (std::string word; words >> word;) {
        const auto number = parsed_number(word);
        if (!number) return std::string(node.child_value());
        list.push_back(*number);
    }
    return list.size() == 1 ? list[0] : list;
}

}  // namespace

std::optional<std::string_view> line_after(std::string_view text, const std::string& begin) {
    while (!text.empty()) {
        std::string_view line = cut_line(text);
        if (!line.starts_with(begin)) continue;
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line.substr(begin.size());
    }
    return {};
}

std::string bare_name(std::string_view name) {
    std::string bare;
    for (const char c : name.substr(0, longest_name))
        if (std::isalnum(static_cast<unsigned char>(c)) != 0)
            bare += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return bare;
}

std::vector<std::string> words_in_name(std::string_view name) {
    std::vector<std::string> words;
    bool in_word = false;
    for (const char c : small_letters(std::string(name))) {
        const bool is_letter = c >= 'a' && c <= 'z';
        if (is_letter && !in_word) words.emplace_back();
        if (is_letter) words.back() += c;
        in_word = is_letter;
    }
    return words;
}

bool has_beginning(std::string_view name, std::initializer_list<std::string_view> beginnings) {
    return std::ranges::any_of(words_in_name(name), [&](const std::string& word) {
        return std::ranges::any_of(beginnings, [&](auto wanted) { return (word + ' ').starts_with(wanted); });
    });
}

std::string number_in(std::string_view stem, int from_end) {
    constexpr const char* digits = "0123456789";
    for (;; --from_end) {
        const auto last = stem.find_last_of(digits);
        if (last == std::string_view::npos) return "";
        const auto before = stem.find_last_not_of(digits, last);
        const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
        if (from_end > 0) {
            stem = stem.substr(0, begin);
            continue;
        }
        const std::string_view number = stem.substr(begin, last + 1 - begin);
        return std::string(number.substr(std::min(number.find_first_not_of('0'), number.size() - 1)));
    }
}

int NumberTable::column(std::initializer_list<const char*> wanted) const {
    for (const char* name : wanted)
        if (const auto found = std::ranges::find(names, name); found != names.end())
            return static_cast<int>(found - names.begin());
    return -1;
}

NumberTable table_in(std::string_view text) {
    std::string_view head;
    while (head.empty() && !text.empty()) head = trimmed(cut_line(text));
    if (head.starts_with('#')) head = trimmed(head.substr(1));
    if (!has_letter(head) || head.starts_with('{') || head.starts_with('<')) return {};
    std::string_view first, rest = text;
    while (first.empty() && !rest.empty()) first = trimmed(cut_line(rest));
    for (const char between : {' ', ',', ';'}) {
        const auto names = fields_of(head, between);
        if (names.size() < 2 || names.size() > most_columns) continue;
        if (numbers_of(fields_of(first, between)).size() != names.size()) continue;
        NumberTable table;
        for (const std::string_view name : names) table.names.push_back(bare_name(name));
        while (!text.empty() && table.rows.size() < most_table_rows) {
            auto row = numbers_of(fields_of(trimmed(cut_line(text)), between));
            if (row.size() == names.size()) table.rows.push_back(std::move(row));
        }
        return table;
    }
    return {};
}

Json members_in_lines(std::string_view text) {
    Json made = Json::object();
    Json* within = &made;
    for (std::size_t n = 0; n < most_lines && !text.empty(); ++n) {
        std::string_view line = trimmed(cut_line(text));
        line = trimmed(line.substr(0, line.find_first_of("#;")));
        if (line.empty()) continue;
        if (line.front() == '[' && line.back() == ']' && has_letter(line)) {
            within = &made[std::string(line.substr(1, std::min(line.size() - 2, longest_name)))];
            if (!within->is_object()) *within = Json::object();
            continue;
        }
        const auto end = line.find_first_of("=: \t");
        if (end == std::string_view::npos || !has_letter(line.substr(0, end))) continue;
        std::string_view value = trimmed(line.substr(end), " \t\r=:[](){}");
        std::vector<std::string_view> fields = fields_of(value, value.find(',') == value.npos ? ' ' : ',');
        const std::vector<double> numbers = numbers_of(fields);
        if (numbers.empty()) continue;
        const std::string name(line.substr(0, std::min(end, longest_name)));
        within->emplace(name, numbers.size() == 1 ? Json(numbers[0]) : Json(numbers));
    }
    return made.empty() ? Json() : made;
}

Json json_in(std::string_view text) {
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return nullptr;
    if (text[begin] == '{' || text[begin] == '[') {
        auto json = checked_json::checked("", [&] { return checked_json::parse(text, text.size()); });
        return json ? std::move(*json) : Json();
    }
    if (text[begin] == '<') {
        pugi::xml_document document;
        return document.load_buffer(text.data(), text.size()) ? json_of(document) : Json();
    }
    return plain_yaml(text);
}

}  // namespace touchable
