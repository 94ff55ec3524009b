#include "engine/picture/npy_header.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::string_view npy_magic = "\x93NUMPY";

/// The few of Python's literals of which a header consists.
class PythonText {
public:
    explicit PythonText(std::string_view text) : rest_(text) {}
    bool take(char c) {
        skip_blanks();
        if (!rest_.starts_with(c)) return false;
        rest_.remove_prefix(1);
        return true;
    }
    std::optional<std::string_view> quoted() {
        skip_blanks();
        const char quote = rest_.empty() ? '\0' : rest_.front();
        if (quote != '\'' && quote != '"') return std::nullopt;
        const auto end = rest_.find(quote, 1);
        if (end == std::string_view::npos) return std::nullopt;
        const std::string_view text = rest_.substr(1, end - 1);
        rest_.remove_prefix(end + 1);
        return text;
    }
    std::optional<bool> boolean() {
        skip_blanks();
        for (const bool value : {false, true}) {
            const std::string_view word = value ? "True" : "False";
            if (!rest_.starts_with(word)) continue;
            rest_.remove_prefix(word.size());
            return value;
        }
        return std::nullopt;
    }
    /// A tuple of extents, which Python 2 wrote with an L behind them.
    std::optional<std::vector<std::int64_t>> extents() {
        std::vector<std::int64_t> found;
        if (!take('(')) return std::nullopt;
        while (!take(')')) {
            skip_blanks();
            std::int64_t value = 0;
            const auto [end, failure] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
            if (failure != std::errc() || value < 0 || value > std::int64_t{1} << 31 || found.size() == 32)
                return std::nullopt;
            rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
            if (rest_.starts_with('L')) rest_.remove_prefix(1);
            found.push_back(value);
            if (!take(',') && !rest_.starts_with(')')) return std::nullopt;
        }
        return found;
    }

private:
    void skip_blanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size())); }
    std::string_view rest_;
};

std::optional<NumberFormat> number_format_of(std::string_view type) {
    using Kind = NumberFormat::Kind;
    constexpr std::pair<std::string_view, NumberFormat> types[] = {
        {"u1", {Kind::unsigned_integer, 1}}, {"u2", {Kind::unsigned_integer, 2}},
        {"u4", {Kind::unsigned_integer, 4}}, {"u8", {Kind::unsigned_integer, 8}},
        {"i1", {Kind::signed_integer, 1}},   {"i2", {Kind::signed_integer, 2}},
        {"i4", {Kind::signed_integer, 4}},   {"i8", {Kind::signed_integer, 8}},
        {"f2", {Kind::floating, 2}},         {"f4", {Kind::floating, 4}},
        {"f8", {Kind::floating, 8}}};
    if (type.size() != 3 || std::string_view("<>|").find(type[0]) == std::string_view::npos)
        return std::nullopt;
    for (const auto& [name, format] : types)
        if (name == type.substr(1) && (type[0] != '|' || format.bytes == 1))
            return NumberFormat{format.kind, format.bytes, type[0] == '>'};
    return std::nullopt;
}

Error damaged_header(const std::string& where) {
    return input_error(where + ": is damaged: its header is not NumPy's");
}

std::string shape_text(const std::vector<std::int64_t>& shape) {
    std::string text;
    for (const std::int64_t extent : shape) {
        if (!text.empty()) text += 'x';
        text += std::to_string(extent);
    }
    return text.empty() ? "a single number" : text;
}

Result<NpyHeader> header_of_text(std::string_view dictionary, const std::string& where) {
    PythonText text(dictionary);
    std::optional<std::string_view> type;
    std::optional<bool> columns_first;
    std::optional<std::vector<std::int64_t>> shape;
    if (!text.take('{')) return damaged_header(where);
    while (!text.take('}')) {
        const auto key = text.quoted();
        if (!key || !text.take(':')) return damaged_header(where);
        if (*key == "descr" && !(type = text.quoted()))
            return input_error(where + ": is an array of records: must be of plain numbers");
        if (*key == "fortran_order") columns_first = text.boolean();
        if (*key == "shape") shape = text.extents();
        text.take(',');
    }
    if (!type || !columns_first || !shape) return damaged_header(where);
    const auto format = number_format_of(*type);
    if (!format)
        return input_error(where + ": is of NumPy's type " + in_quotes(*type) +
                           ": must be an integer or float of 8 to 64 bits");
    NpyHeader header;
    header.format = *format;
    header.columns_first = *columns_first;
    header.shape = std::move(*shape);
    return header;
}

}  // namespace

bool is_npy(std::string_view begin) {
    return begin.starts_with(npy_magic);
}

Result<NpyHeader> read_npy_header(ByteSource& bytes, const std::string& where) {
    char begin[12] = {};
    if (bytes.size() < sizeof begin) return damaged_header(where);
    if (auto got = bytes.read(0, begin, sizeof begin); !got) return error_at(where, got.error());
    if (!is_npy({begin, sizeof begin})) return damaged_header(where);
    const auto byte = [&](int at) { return std::size_t{static_cast<unsigned char>(begin[at])}; };
    if (byte(6) < 1 || byte(6) > 3)
        return input_error(where + ": is of NumPy's format " + std::to_string(byte(6)) + ": must be 1 to 3");
    const std::size_t text_at = byte(6) == 1 ? 10 : 12;
    const std::size_t length = byte(8) | byte(9) << 8 | (byte(6) == 1 ? 0 : byte(10) << 16 | byte(11) << 24);
    if (length > 65536 || text_at + length > bytes.size()) return damaged_header(where);
    std::string text(length, '\0');
    if (auto got = bytes.read(text_at, text.data(), length); !got) return error_at(where, got.error());
    auto header = header_of_text(text, where);
    if (header) header->data_at = text_at + length;
    return header;
}

Result<NpyPictures> npy_pictures(const NpyHeader& header, const std::string& where) {
    std::vector<std::int64_t> shape = header.shape;
    if (shape.size() > 2 && shape.back() == 1) shape.pop_back();
    // Networks count batches and colours too: 1 x 1 x height x width, count x 1 x height x width.
    for (auto one = shape.begin(); shape.size() > 3 && one != shape.end() - 2;)
        one = *one == 1 ? shape.erase(one) : one + 1;
    if (shape.size() == 2) shape.insert(shape.begin(), 1);
    if (shape.size() != 3 || shape[0] < 1)
        return input_error(where + ": is an array of " + shape_text(header.shape) +
                           ": must be height x width, or count x height x width");
    if (shape[2] <= 4 && shape[1] > 4 && shape[0] > 4)
        return input_error(where + ": is an array of " + shape_text(header.shape) + ", with " +
                           std::to_string(shape[2]) + " numbers a pixel: must have one");
    TRY(check_picture_size(shape[2], shape[1], where));
    return NpyPictures{shape[0], static_cast<int>(shape[2]), static_cast<int>(shape[1])};
}

}  // namespace touchable
