#include "engine/formats/plain_yaml.hpp"

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"

namespace touchable {
namespace {

using YamlValue = nlohmann::json;

constexpr int deepest_yaml = 16;

std::string_view without_ends(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
    return first == std::string_view::npos ? std::string_view() : text.substr(first, last + 1 - first);
}

YamlValue yaml_scalar(std::string_view text) {
    text = without_ends(text);
    if (const auto number = parsed_number(text)) return *number;
    const bool is_quoted = text.size() > 1 && (text[0] == '"' || text[0] == '\'') && text.back() == text[0];
    return is_quoted ? std::string(text.substr(1, text.size() - 2)) : std::string(text);
}

/// Numbers are names as well.
std::string yaml_name(std::string_view text) {
    const YamlValue name = yaml_scalar(text);
    return name.is_string() ? name.get<std::string>() : name.dump();
}

/// Where a comment begins: at the start, or after a space.
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

/// Lists and maps in brackets.
class YamlInBrackets {
public:
    explicit YamlInBrackets(std::string_view text) : rest_(text) {}
    YamlValue value(int depth = 0) {
        skip_spaces();
        if (depth > deepest_yaml || rest_.empty()) return nullptr;
        const char open = rest_[0];
        if (open != '[' && open != '{') return yaml_scalar(taken(rest_.find_first_of(",]}")));
        const char close = open == '[' ? ']' : '}';
        YamlValue made = open == '[' ? YamlValue::array() : YamlValue::object();
        rest_.remove_prefix(1);
        for (skip_spaces(); !rest_.empty() && rest_[0] != close; skip_spaces()) {
            std::string name;
            if (open == '{') {
                name = yaml_name(taken(rest_.find_first_of(":,]}")));
                if (rest_.empty() || rest_[0] != ':') return nullptr;
                rest_.remove_prefix(1);
            }
            YamlValue inner = value(depth + 1);
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
    explicit YamlLines(std::string_view text);
    YamlValue block(std::size_t indent, int depth);
    std::size_t first_indent() const { return lines_.empty() ? 0 : lines_[0].indent; }

private:
    struct Line {
        std::size_t indent;
        std::string_view text;
    };
    bool is_item() const { return lines_[at_].text == "-" || lines_[at_].text.starts_with("- "); }
    bool goes_on(std::size_t indent) const { return at_ < lines_.size() && lines_[at_].indent == indent; }
    YamlValue items(std::size_t indent, int depth);
    YamlValue value_of(std::string_view text, std::size_t indent, int depth);
    std::string gathered(std::string_view text);
    static void add(YamlValue& map, std::string_view name, YamlValue value);

    std::vector<Line> lines_;
    std::size_t at_ = 0;
};

YamlLines::YamlLines(std::string_view text) {
    while (!text.empty()) {
        const auto end = text.find('\n');
        const std::string_view line = without_comment(text.substr(0, end));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        const std::string_view inner = without_ends(line);
        if (inner == "---" || inner == "...") {
            if (!lines_.empty()) break;
            continue;
        }
        if (inner.empty() || line[0] == '%') continue;
        lines_.push_back({static_cast<std::size_t>(inner.data() - line.data()), inner});
    }
}

/// Names with a point lead further in.
void YamlLines::add(YamlValue& map, std::string_view name, YamlValue value) {
    const auto point = name.find('.');
    YamlValue* within = &map;
    if (point != std::string_view::npos && point > 0 && point + 1 < name.size()) {
        within = &map[std::string(name.substr(0, point))];
        if (within->is_null()) *within = YamlValue::object();
        name.remove_prefix(point + 1);
    }
    if (within->is_object()) within->emplace(std::string(name), std::move(value));
}

/// A value in brackets may go on over lines.
std::string YamlLines::gathered(std::string_view text) {
    std::string all;
    std::ptrdiff_t open = 0;
    const auto add_text = [&](std::string_view more) {
        for (const char c : more) open += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
        (all += more) += ' ';
    };
    for (add_text(text); open > 0 && at_ < lines_.size(); ++at_) add_text(lines_[at_].text);
    return all;
}

/// What stands behind a name, or in the lines below it.
YamlValue YamlLines::value_of(std::string_view text, std::size_t indent, int depth) {
    while (!text.empty() && (text[0] == '!' || text[0] == '&')) {
        const auto end = text.find_first_of(" \t");
        text = end == std::string_view::npos ? std::string_view() : without_ends(text.substr(end));
    }
    if (!text.empty() && (text[0] == '[' || text[0] == '{')) return YamlInBrackets(gathered(text)).value();
    if (!text.empty() && text[0] != '|' && text[0] != '>') return yaml_scalar(text);
    if (!text.empty()) {  // a text of several lines, in which nobody looks for numbers
        while (at_ < lines_.size() && lines_[at_].indent > indent) ++at_;
        return nullptr;
    }
    if (at_ >= lines_.size()) return nullptr;
    const std::size_t below = lines_[at_].indent;
    return below > indent || (below == indent && is_item()) ? block(below, depth + 1) : YamlValue();
}

YamlValue YamlLines::items(std::size_t indent, int depth) {
    YamlValue list = YamlValue::array();
    while (goes_on(indent) && is_item()) {
        const std::string_view text = without_ends(lines_[at_].text.substr(1));
        const bool is_bracket = text.starts_with('[') || text.starts_with('{');
        if (!text.empty() && !is_bracket && text[0] != '"' && text[0] != '\'' &&
            (text.starts_with("- ") || text.find(": ") != std::string_view::npos || text.back() == ':')) {
            // A map or a list that begins here: as if it stood in a line of its own, at its own place.
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

YamlValue YamlLines::block(std::size_t indent, int depth) {
    if (depth > deepest_yaml) {
        at_ = lines_.size();
        return nullptr;
    }
    if (goes_on(indent) && is_item()) return items(indent, depth);
    YamlValue map = YamlValue::object();
    while (goes_on(indent)) {
        const std::string_view line = lines_[at_].text;
        auto colon = line.find(": ");
        if (colon == std::string_view::npos && line.back() == ':') colon = line.size() - 1;
        ++at_;
        if (colon == std::string_view::npos) continue;
        add(map, yaml_name(line.substr(0, colon)),
            value_of(without_ends(line.substr(colon + 1)), indent, depth));
        // What stands further in without a reason is passed over.
        while (at_ < lines_.size() && lines_[at_].indent > indent) ++at_;
    }
    return map;
}

}  // namespace

nlohmann::json plain_yaml(std::string_view text) {
    YamlLines lines(text);
    YamlValue made = lines.block(lines.first_indent(), 0);
    return made.is_object() && !made.empty() ? std::move(made) : YamlValue();
}

}  // namespace touchable
