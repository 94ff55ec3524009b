// SPDX-License-Identifier: Apache-2.0
#include "engine/base/files.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::size_t largest_csv = std::size_t{256} << 20;
constexpr std::size_t most_csv_rows = 10'000'000;  // an hour at 2.7 kHz

/// Any number, infinities and NaN included; nothing for other text.
std::optional<double> parse_number(std::string_view text) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    return parsed_as<double>(text);
}

bool is_csv_text(std::string_view line) {
    return std::ranges::all_of(line, [](unsigned char c) { return c >= 0x20 || c == '\t'; });
}

const char* separator_name(char separator) {
    return separator == ';'    ? "a semicolon"
           : separator == '\t' ? "a tab"
           : separator == ' '  ? "a blank"
                               : "a comma";
}

}  // namespace

Result<CsvTable> CsvTable::read(const std::string& file) {
    TRY_ASSIGN(auto text, read_given_file(file, file, "a CSV file", largest_csv));
    CsvTable table;
    table.file_ = file;
    table.text_ = std::make_shared<const std::string>(std::move(text));
    TRY(table.find_lines());
    table.choose_separator();
    TRY(table.check_fields());
    return table;
}

Result<void> CsvTable::find_lines() {
    const std::string_view text(*text_);
    std::size_t filled = 0;  // lines up to the last that is not blank
    for (std::size_t at = text.starts_with("\xEF\xBB\xBF") ? 3 : 0; at < text.size();) {
        lines_.push_back(static_cast<std::uint32_t>(at));
        if (line(lines_.size() - 1).find_first_not_of(" \t") != std::string_view::npos)
            filled = lines_.size();
        if (filled > most_csv_rows + 1)
            return input_error(file_ + ": has more than " + std::to_string(most_csv_rows) +
                               " rows; give a recorded motion of at most an hour");
        at = std::min(text.find('\n', at), text.size() - 1) + 1;
    }
    lines_.resize(filled);
    return {};
}

/// Field count of the first two lines if both have the same count; otherwise 1.
std::size_t CsvTable::fields_by(char separator) {
    separator_ = separator;
    std::vector<std::string_view> fields;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 2 && k < lines_.size(); ++k) {
        if (!split(line(k), fields) || (k > 0 && fields.size() != count)) return 1;
        count = fields.size();
    }
    return count;
}

/// Takes the separator that yields the most fields; a blank, frequent in notes, only if no other yields any.
void CsvTable::choose_separator() {
    char best = ',';
    std::size_t most = std::max<std::size_t>(fields_by(best), 1);
    for (const char separator : {';', '\t', ' '}) {
        const std::size_t fields = fields_by(separator);
        if (fields <= most || (separator == ' ' && most > 1)) continue;
        best = separator;
        most = fields;
    }
    separator_ = best;
}

Result<void> CsvTable::check_fields() {
    std::vector<std::string_view> fields;
    for (std::size_t number = 0; number < lines_.size(); ++number) {
        const std::string where = file_ + ": line " + std::to_string(number + 1);
        if (!is_csv_text(line(number)))
            return input_error(where + " holds bytes that are no text; give a comma-separated table");
        if (const Result<void> done = split(line(number), fields); !done)
            return input_error(where + done.error().message);
        if (number == 0) first_ = fields;
        if (fields.size() != first_.size())
            return input_error(where + " has " + std::to_string(fields.size()) +
                               " fields; the lines before have " + std::to_string(first_.size()));
    }
    has_header_ = std::ranges::any_of(first_, [](std::string_view field) { return !parse_number(field); });
    if (lines_.empty() || rows() == 0) return input_error(file_ + ": has no row of data; expected numbers");
    return {};
}

Result<void> CsvTable::split(std::string_view line, std::vector<std::string_view>& fields) const {
    const std::string_view blanks = separator_ == '\t' ? " " : " \t";
    const std::string_view separators = separator_ == ' ' ? blanks : std::string_view(&separator_, 1);
    fields.clear();
    line = trimmed(line, blanks);
    for (bool more = true; more;) {
        line = trimmed(line, blanks);
        std::size_t end = line.find_first_of(separators);
        if (line.starts_with('"')) {
            const std::size_t quote = line.find('"', 1);
            if (quote == line.npos) return input_error(": a quote is opened and not closed");
            end = line.find_first_of(separators, quote);
            if (!trimmed(line.substr(quote + 1, end == line.npos ? end : end - quote - 1), blanks).empty())
                return input_error(std::string(": text follows a closing quote; expected ") +
                                   separator_name(separator_));
            fields.push_back(line.substr(1, quote - 1));
        } else {
            fields.push_back(trimmed(line.substr(0, end), blanks));
        }
        more = end != line.npos;
        if (more) line.remove_prefix(end + 1);
    }
    return {};
}

Result<std::size_t> CsvTable::column(std::string_view name_or_number) const {
    std::string legal = "1 to " + std::to_string(columns());
    for (std::size_t at = 0; at < columns() && has_header_; ++at) {
        if (first_[at] == name_or_number) return at;
        legal.append(", ").append(printable(first_[at]));
    }
    const auto number = parsed_as<std::size_t>(name_or_number).value_or(0);
    if (number >= 1 && number <= columns()) return number - 1;
    return input_error(file_ + ": has no column '" + printable(name_or_number) + "'; columns are " +
                       printable(legal, 400));
}

Result<std::vector<double>> CsvTable::numbers(std::size_t column, bool may_be_empty) const {
    std::vector<double> values;
    values.reserve(rows());
    std::vector<std::string_view> fields;
    const std::string name = has_header_ ? printable(first_[column]) : std::to_string(column + 1);
    for (std::size_t row = 0; row < rows(); ++row) {
        TRY(split(line(row + (has_header_ ? 1 : 0)), fields));
        const std::string_view field = fields[column];
        if (may_be_empty && field.empty()) {
            values.push_back(std::numeric_limits<double>::quiet_NaN());
            continue;
        }
        const std::optional<double> value = parse_number(field);
        if (!value || !std::isfinite(*value)) {
            std::string message = place(row) + ", column '" + name + "' holds ";
            message += field.empty() ? "nothing" : std::string("'").append(printable(field)).append("'");
            return input_error(message + "; expected a finite number");
        }
        values.push_back(*value);
    }
    return values;
}

}  // namespace touchable
