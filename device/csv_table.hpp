#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.hpp"

namespace touchable {

/// A comma-separated table of numbers, with or without a header. Every row has the same number of fields; a
/// field may stand in double quotes; columns nobody asks for may hold anything.
class CsvTable {
public:
    /// Refuses (ErrorKind::input, with file and line) what cannot be read, is no text, has rows of different
    /// lengths or no row of data. The first line is a header if it holds a field that is not a number.
    static Result<CsvTable> read(const std::string& file);

    CsvTable(CsvTable&&) = default;
    CsvTable& operator=(CsvTable&&) = default;

    std::size_t rows() const { return fields_.size() / columns_ - (has_header_ ? 1 : 0); }
    std::size_t columns() const { return columns_; }
    /// Whether the header names such a column.
    bool names(std::string_view column) const;
    /// A column by the header's name for it, or by its number, from 1. Refuses others, listing the legal
    /// ones.
    Result<std::size_t> column(std::string_view name_or_number) const;
    /// All values of a column, from the top. Refuses (file, line, column) what is not a finite number.
    Result<std::vector<double>> numbers(std::size_t column) const;
    /// As the file's name stands in messages: "FILE: line N" of row `row`.
    std::string place(std::size_t row) const;
    const std::string& file() const { return file_; }

private:
    CsvTable() = default;
    Result<void> split();
    Result<void> split_line(std::string_view line, std::size_t number);
    std::string_view header(std::size_t column) const {
        return has_header_ ? fields_[column] : std::string_view();
    }

    std::string file_;
    std::vector<char> text_;  // fields_ point into it; unlike a string's it stays put when moved
    std::vector<std::string_view> fields_;  // row by row, header included
    std::size_t columns_ = 0;
    bool has_header_ = false;
};

}  // namespace touchable
