#include "engine/formats/sidecar_text.hpp"

#include <algorithm>
#include <cctype>

#include "engine/base/words.hpp"

namespace touchable {
namespace {

using checked_json::Json;

constexpr std::size_t most_columns = 200, most_lines = 4000, longest_name = 200;

std::string_view next_line(std::string_view& rest) {
    const auto end = rest.find('\n');
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    return line;
}

/// Where a field ends: not within brackets, as in K[0,2].
std::size_t end_of_field(std::string_view line, char between) {
    int open = 0;
    for (std::size_t k = 0; k < line.size(); ++k) {
        open += line[k] == '[' ? 1 : line[k] == ']' ? -1 : 0;
        if (line[k] == between && open <= 0) return k;
    }
    return std::string_view::npos;
}

/// The fields of a line; of blanks several are one.
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

/// Nothing where a field is no number.
std::vector<double> numbers_of(const std::vector<std::string_view>& fields) {
    std::vector<double> numbers;
    for (const std::string_view field : fields) {
        const auto number = parsed_number(field.starts_with('+') ? field.substr(1) : field);
        if (!number) return {};
        numbers.push_back(*number);
    }
    return numbers;
}

}  // namespace

std::string bare_name(std::string_view name) {
    std::string bare;
    for (const char c : name.substr(0, longest_name))
        if (std::isalnum(static_cast<unsigned char>(c)) != 0)
            bare += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return bare;
}

int NumberTable::column(std::initializer_list<const char*> wanted) const {
    for (const char* name : wanted)
        if (const auto found = std::ranges::find(names, name); found != names.end())
            return static_cast<int>(found - names.begin());
    return -1;
}

NumberTable table_in(std::string_view text) {
    std::string_view head;
    while (head.empty() && !text.empty()) head = next_line(text);
    if (head.starts_with('#')) head = trimmed(head.substr(1));
    if (!has_letter(head) || head.starts_with('{') || head.starts_with('<')) return {};
    std::string_view first, rest = text;
    while (first.empty() && !rest.empty()) first = next_line(rest);
    for (const char between : {' ', ',', ';'}) {
        const auto names = fields_of(head, between);
        if (names.size() < 2 || names.size() > most_columns) continue;
        if (numbers_of(fields_of(first, between)).size() != names.size()) continue;
        NumberTable table;
        for (const std::string_view name : names) table.names.push_back(bare_name(name));
        while (!text.empty() && table.rows.size() < most_table_rows) {
            auto row = numbers_of(fields_of(next_line(text), between));
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
        std::string_view line = next_line(text);
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

}  // namespace touchable
