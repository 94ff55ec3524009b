#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// A table of numbers in text, with or without a header, its fields separated by commas, semicolons, tabs or
/// blanks. Every row has the same number of fields; a field may stand in double quotes; columns nobody asks
/// for may hold anything; blank lines at the end do not count.
class CsvTable {
public:
    /// Refuses (ErrorKind::input, with file and line) what cannot be read, is larger than 256 MiB or has more
    /// than ten million rows, is no text, has rows of different lengths or no row of data. The first line is
    /// a header if it holds a field that is not a number.
    static Result<CsvTable> read(const std::string& file);

    CsvTable(CsvTable&&) = default;
    CsvTable& operator=(CsvTable&&) = default;

    std::size_t rows() const { return lines_.size() - (has_header_ ? 1 : 0); }
    std::size_t columns() const { return first_.size(); }
    /// Whether the header names such a column.
    bool names(std::string_view column) const;
    /// A column by the header's name for it, or by its number, from 1. Refuses others, listing the legal
    /// ones.
    Result<std::size_t> column(std::string_view name_or_number) const;
    /// All values of a column, from the top. Refuses (file, line, column) what is not a finite number.
    Result<std::vector<double>> numbers(std::size_t column) const;
    /// The same, where a field may be empty: not a number then.
    Result<std::vector<double>> numbers_where_given(std::size_t column) const;
    /// As the file's name stands in messages: "FILE: line N" of row `row`.
    std::string place(std::size_t row) const;
    const std::string& file() const { return file_; }

private:
    CsvTable() = default;
    Result<std::vector<double>> numbers(std::size_t column, bool may_be_empty) const;
    Result<void> find_lines();
    Result<void> check_fields();
    std::size_t fields_by(char separator);
    void choose_separator();
    std::string_view line(std::size_t number) const;
    /// Fields of a line, which replace those given; says what is wrong with it.
    Result<void> split(std::string_view line, std::vector<std::string_view>& fields) const;

    std::string file_;
    std::shared_ptr<const std::string> text_;  // stays put when this is moved
    std::vector<std::uint32_t> lines_;         // where each begins
    std::vector<std::string_view> first_;      // fields of the first line
    char separator_ = ',';                     // a blank: any number of blanks and tabs
    bool has_header_ = false;
};

}  // namespace touchable
