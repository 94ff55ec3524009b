#include "device/csv_table.hpp"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

namespace touchable {
namespace {

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

/// Any number, infinities and NaN included; nothing for other text.
std::optional<double> parse_number(std::string_view text) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    double value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

bool is_text(std::string_view line) {
    for (const char c : line) {
        if (static_cast<unsigned char>(c) < 0x20 && c != '\t') return false;
    }
    return true;
}

}  // namespace

Result<CsvTable> CsvTable::read(const std::string& file) {
    std::error_code missing;
    if (!std::filesystem::is_regular_file(file, missing)) {
        return input_error(file + ": is not a file that can be read; give a CSV file");
    }
    std::ifstream stream(file, std::ios::binary);
    CsvTable table;
    table.file_ = file;
    table.text_.assign(std::istreambuf_iterator<char>(stream), {});
    if (!stream) return input_error(file + ": cannot be read; give a CSV file with read permission");
    if (const Result<void> done = table.split(); !done) return done.error();
    return table;
}

Result<void> CsvTable::split() {
    std::string_view rest(text_.data(), text_.size());
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    for (std::size_t number = 1; !rest.empty(); ++number) {
        const std::size_t end = rest.find('\n');
        std::string_view line = rest.substr(0, end);
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (line.empty() && rest.empty()) break;
        if (const Result<void> done = split_line(line, number); !done) return done;
    }
    for (std::size_t column = 0; column < columns_; ++column) {
        if (!parse_number(fields_[column])) has_header_ = true;
    }
    if (fields_.empty() || rows() == 0) return input_error(file_ + ": has no row of data; expected numbers");
    return {};
}

Result<void> CsvTable::split_line(std::string_view line, std::size_t number) {
    const std::string where = file_ + ": line " + std::to_string(number);
    if (!is_text(line))
        return input_error(where + " holds bytes that are no text; give a comma-separated table");
    const std::size_t before = fields_.size();
    for (bool more = true; more;) {
        line = trimmed(line);
        std::size_t end = line.find(',');
        if (line.starts_with('"')) {
            const std::size_t quote = line.find('"', 1);
            if (quote == std::string_view::npos)
                return input_error(where + ": a quote is opened and not closed");
            end = line.find(',', quote);
            const std::string_view after =
                trimmed(line.substr(quote + 1, end == line.npos ? end : end - quote - 1));
            if (!after.empty())
                return input_error(where + ": text follows a closing quote; expected a comma");
            fields_.push_back(line.substr(1, quote - 1));
        } else {
            fields_.push_back(trimmed(line.substr(0, end)));
        }
        more = end != std::string_view::npos;
        if (more) line.remove_prefix(end + 1);
    }
    const std::size_t fields = fields_.size() - before;
    if (before == 0) columns_ = fields;
    if (fields != columns_) {
        return input_error(where + " has " + std::to_string(fields) + " fields; the lines before have " +
                           std::to_string(columns_));
    }
    return {};
}

bool CsvTable::names(std::string_view column) const {
    for (std::size_t at = 0; at < columns_ && has_header_; ++at) {
        if (header(at) == column) return true;
    }
    return false;
}

Result<std::size_t> CsvTable::column(std::string_view name_or_number) const {
    for (std::size_t at = 0; at < columns_ && has_header_; ++at) {
        if (header(at) == name_or_number) return at;
    }
    std::size_t number = 0;
    const char* const last = name_or_number.data() + name_or_number.size();
    const auto [end, fault] = std::from_chars(name_or_number.data(), last, number);
    if (fault == std::errc() && end == last && number >= 1 && number <= columns_) return number - 1;
    std::string legal = "1 to " + std::to_string(columns_);
    for (std::size_t at = 0; at < columns_ && has_header_; ++at) legal.append(", ").append(header(at));
    return input_error(file_ + ": has no column '" + std::string(name_or_number) + "'; columns are " + legal);
}

Result<std::vector<double>> CsvTable::numbers(std::size_t column) const {
    std::vector<double> values;
    values.reserve(rows());
    const std::string name = has_header_ ? std::string(header(column)) : std::to_string(column + 1);
    for (std::size_t row = 0; row < rows(); ++row) {
        const std::string_view field = fields_[(row + (has_header_ ? 1 : 0)) * columns_ + column];
        const std::optional<double> value = parse_number(field);
        if (!value || !std::isfinite(*value)) {
            std::string message = place(row) + ", column '" + name + "' holds ";
            message += field.empty() ? "nothing" : std::string("'").append(field).append("'");
            return input_error(message + "; expected a finite number");
        }
        values.push_back(*value);
    }
    return values;
}

std::string CsvTable::place(std::size_t row) const {
    return file_ + ": line " + std::to_string(row + (has_header_ ? 2 : 1));
}

}  // namespace touchable
