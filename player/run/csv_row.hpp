#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

namespace touchable {

/// Fields of a row, each followed by a comma but the last.
class CsvRow {
public:
    explicit CsvRow(std::string& text) : text_(text) {}
    CsvRow& operator<<(double value) {
        std::array<char, 40> digits;
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                       std::chars_format::general, 17);
        return add(digits.data(), end.ptr);
    }
    CsvRow& operator<<(std::int64_t value) {
        std::array<char, 24> digits;
        return add(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
    }
    CsvRow& operator<<(const glm::dvec3& v) { return *this << v.x << v.y << v.z; }
    /// Of a number that is not there.
    CsvRow& empty() {
        text_ += ',';
        return *this;
    }
    void end() { text_.back() = '\n'; }

private:
    CsvRow& add(const char* begin, const char* end) {
        text_.append(begin, end);
        text_ += ',';
        return *this;
    }
    std::string& text_;
};

}  // namespace touchable
