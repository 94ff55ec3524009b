#include <bit>
#include <limits>
#include <map>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"
#include "engine/picture/zip_archive.hpp"

namespace touchable {

namespace {

constexpr std::string_view npy_magic = "\x93NUMPY";

/// What a file of NumPy's format 1.0 to 3.0 says before its data.
struct NpyHeader {
    NumberFormat format;
    bool columns_first = false;  ///< Fortran order: the first index runs fastest
    std::vector<std::int64_t> shape;
    std::size_t data_at = 0;  ///< bytes before the data
};

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

/// Every extent of the shape is at most 2^31.
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

/// One member that is an array.
struct NpzArray {
    std::string name;  // without ".npy"
    ZipMember member;
    std::uint64_t size;
    std::optional<NpyHeader> header{};  // of what is pictures
    bool is_possible = true;            // that so many bytes are packed in those of the file

    bool is_pictures() const { return header.has_value(); }
};

/// A .npy file inside a .npz file, which is a zip archive.
struct NpzMember {
    std::unique_ptr<ByteSource> bytes;  ///< keeps the archive open
    std::string where;                  ///< both names, as messages begin
    /// An array of pictures named conf or confidence, which networks write beside depth; null: there is none.
    std::unique_ptr<ByteSource> confidence{};
    /// The arrays of one picture each that are frames together, in the place of `bytes`; empty: there are
    /// none.
    std::vector<NpzArray> row{};
    ZipArchive archive{};    ///< of the row
    std::string left_out{};  ///< ImageStack
    std::vector<SmallArray> small_arrays{};
};

constexpr std::uint64_t most_members = 4096;

std::unique_ptr<ByteSource> unpacked(const ZipArchive& archive, const NpzArray& array) {
    return unpacked_member(archive, array.member);
}

std::vector<NpzArray> npz_arrays(const ZipArchive& archive) {
    std::vector<NpzArray> arrays;
    for (const ZipMember& member : zip_members(archive)) {
        if (!member.name.ends_with(".npy")) continue;
        NpzArray array{member.name.substr(0, member.name.size() - 4), member, member.size};
        array.is_possible = member.is_possible();
        auto header = read_npy_header(*unpacked(archive, array), "");
        if (header && pictures_of_array(header->shape, "")) array.header = std::move(*header);
        arrays.push_back(std::move(array));
    }
    return arrays;
}

/// The only one that fits, if it is.
template <class Fits>
const NpzArray* only(const std::vector<NpzArray>& arrays, Fits&& fits) {
    const auto first = std::ranges::find_if(arrays, fits);
    if (first == arrays.end() || std::find_if(first + 1, arrays.end(), fits) != arrays.end()) return nullptr;
    return &*first;
}

double number_in(const char* bytes, const NumberFormat& format) {
    std::uint64_t bits = 0;
    for (int k = 0; k < format.bytes; ++k) {
        const auto byte = static_cast<unsigned char>(bytes[format.big_endian ? k : format.bytes - 1 - k]);
        bits = bits << 8 | byte;
    }
    if (format.kind == NumberFormat::Kind::floating)
        return format.bytes == 8   ? std::bit_cast<double>(bits)
               : format.bytes == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(bits))
                                   : std::numeric_limits<double>::quiet_NaN();
    if (format.kind == NumberFormat::Kind::unsigned_integer) return static_cast<double>(bits);
    const int unused = 64 - 8 * format.bytes;
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

/// Those with numbers that can be read: not half floats, not in Fortran order.
std::vector<SmallArray> small_arrays_of(const ZipArchive& archive, const std::vector<NpzArray>& arrays) {
    constexpr std::uint64_t most_numbers = 65536;
    constexpr std::size_t most_arrays = 64;
    std::vector<SmallArray> small;
    for (const NpzArray& array : arrays) {
        if (small.size() >= most_arrays || stop_requested()) break;
        if (!array.is_possible || array.member.size > 8 * most_numbers + 70000) continue;
        const auto bytes = unpacked(archive, array);
        const auto header = read_npy_header(*bytes, "");
        if (!header || (header->columns_first && header->shape.size() > 1)) continue;
        std::uint64_t count = 1;
        for (const std::int64_t extent : header->shape)
            count = count > most_numbers ? count : count * static_cast<std::uint64_t>(extent);
        const auto each = static_cast<std::size_t>(header->format.bytes);
        if (count == 0 || count > most_numbers || bytes->size() < header->data_at + count * each) continue;
        std::vector<char> held(static_cast<std::size_t>(count) * each);
        if (!bytes->read(header->data_at, held.data(), held.size())) continue;
        SmallArray read{array.name, header->shape, {}};
        for (std::size_t k = 0; k < count; ++k)
            read.numbers.push_back(number_in(held.data() + k * each, header->format));
        small.push_back(std::move(read));
    }
    return small;
}

const NpzArray* depth_array(const std::vector<NpzArray>& arrays) {
    if (arrays.size() == 1) return &arrays.front();
    const auto named = [](const NpzArray& a) { return a.is_pictures() && a.name == "depth"; };
    const auto begins = [](const NpzArray& a) { return a.is_pictures() && a.name.starts_with("depth"); };
    if (const NpzArray* found = only(arrays, named)) return found;
    if (const NpzArray* found = only(arrays, begins)) return found;
    return only(arrays, [](const NpzArray& a) { return a.is_pictures(); });
}

/// Arrays of one picture each, of one size and type, whose names differ by a number alone, as numpy.savez has
/// them of a list (arr_0, arr_1, ...): in the order of their numbers. Empty where not all that is pictures is
/// of one such row, or where one row of several is not the only one that is named depth.
std::vector<NpzArray> row_of_arrays(const std::vector<NpzArray>& arrays) {
    std::map<std::string, std::vector<NpzArray>> rows;
    for (const NpzArray& array : arrays)
        if (array.is_pictures()) rows[numbered_name(array.name).first].push_back(array);
    if (rows.size() > 1) std::erase_if(rows, [](const auto& row) { return !row.first.starts_with("depth"); });
    if (rows.size() != 1 || rows.begin()->second.size() < 2) return {};
    std::vector<NpzArray>& row = rows.begin()->second;
    const NpyHeader& first = *row.front().header;
    const auto is_alike = [&](const NpzArray& array) {
        const NpyHeader& own = *array.header;
        return array.is_possible && own.shape == first.shape && own.format.kind == first.format.kind &&
               own.format.bytes == first.format.bytes && pictures_of_array(own.shape, "")->count == 1;
    };
    if (!std::ranges::all_of(row, is_alike)) return {};
    std::ranges::sort(row, {}, [](const NpzArray& array) {
        const std::string number = numbered_name(array.name).second;
        return std::pair(number.size(), number);
    });
    return std::move(row);
}

/// Arrays of as many pixels as the one that is read, which may be depth as well; in words.
std::string other_pictures(const std::vector<NpzArray>& arrays, const NpzArray& read, const NpzArray* trust) {
    std::vector<std::string> names;
    const auto size = pictures_of_array(read.header->shape, "");
    for (const NpzArray& array : arrays) {
        if (&array == &read || &array == trust || !array.is_pictures()) continue;
        if (array.name.find("mask") != std::string::npos || array.name.find("conf") != std::string::npos)
            continue;
        const auto own = pictures_of_array(array.header->shape, "");
        if (own->width == size->width && own->height == size->height) names.push_back(printable(array.name));
    }
    if (names.empty()) return "";
    return "depth is the array " + printable(read.name) + "; left out: " + printable(listed(names), 200);
}

Result<NpzMember> depth_member_of(ZipArchive archive, const std::string& where) {
    const auto arrays = npz_arrays(archive);
    if (arrays.empty())
        return input_error(where +
                           ": is a zip archive without arrays (.npy): unpack it, or give what is inside");
    const NpzArray* array = depth_array(arrays);
    if (!array)
        if (auto row = row_of_arrays(arrays); !row.empty()) {
            NpzMember found{nullptr, where};
            found.row = std::move(row);
            found.small_arrays = small_arrays_of(archive, arrays);
            found.archive = std::move(archive);
            return found;
        }
    if (!array)
        return input_error(where +
                           ": has several arrays, and none is the only one named depth or of height x "
                           "width: " +
                           printable(listed(arrays, &NpzArray::name), 300));
    const std::string name = where + ": " + printable(array->name);
    if (!array->is_possible)
        return input_error(name + ": is damaged: is said to unpack to " + std::to_string(array->size) +
                           " bytes");
    const NpzArray* const trust = only(arrays, [&](const NpzArray& a) {
        return &a != array && a.is_pictures() && a.is_possible &&
               (a.name == "conf" || a.name == "confidence");
    });
    NpzMember found{unpacked(archive, *array), name, trust ? unpacked(archive, *trust) : nullptr};
    if (array->is_pictures()) found.left_out = other_pictures(arrays, *array, trust);
    found.small_arrays = small_arrays_of(archive, arrays);
    return found;
}

/// The array that depth is read from. Messages begin with `where`.
Result<NpzMember> open_npz(std::unique_ptr<ByteSource> bytes, const std::string& where) {
    TRY_ASSIGN(auto archive, open_zip(std::move(bytes), most_members, where));
    return depth_member_of(std::move(archive), where);
}

constexpr std::size_t npy_block = std::size_t{1} << 20;

/// Of pixel k, row by row. What is no number is least.
float number_at(const StoredImage& picture, std::size_t k) {
    if (picture.values.empty()) {
        const PlaneView codes = picture.image.view();
        const int at = static_cast<int>(k);
        return static_cast<float>(codes.sample(at % codes.width, at / codes.width));
    }
    const float value = picture.values[k];
    return value == value ? value : std::numeric_limits<float>::lowest();
}

std::size_t pixels_of(const StoredImage& picture) {
    return pixel_count(picture.image.width, picture.image.height);
}

class NpyStack final : public ImageStack {
public:
    /// Of the bytes of a .npy file; messages begin with `where`.
    static Result<NpyStack> of(std::unique_ptr<ByteSource> bytes, std::string where) {
        TRY_ASSIGN(auto header, read_npy_header(*bytes, where));
        TRY_ASSIGN(const auto pictures, pictures_of_array(header.shape, where));
        NpyStack stack(std::move(bytes), std::move(where), std::move(header), pictures);
        TRY(stack.check());
        TRY(stack.find_floats());
        return stack;
    }

    std::int64_t count() const override { return pictures_.count; }
    int width() const override { return pictures_.width; }
    int height() const override { return pictures_.height; }
    Result<StoredImage> image(std::int64_t number) override {
        if (number < 0 || number >= count())
            return usage_error(where_ + ": has no picture " + std::to_string(number) +
                               ": must be from 0 to " + std::to_string(count() - 1));
        TRY_ASSIGN(auto picture, read(number));
        StoredImage image = std::move(picture).finish("npy", floats_);
        if (stop_requested()) return interrupted_error();
        if (!confidence_) return image;
        TRY_ASSIGN(const auto confidence, confidence_->image(number));
        const auto bytes = static_cast<std::size_t>(image.image.bytes_per_sample);
        const bool all_trusted = until_stopped(pixels_of(image), [&](std::size_t first, std::size_t last) {
            for (std::size_t k = first; k < last; ++k) {
                if (number_at(confidence, k) >= *least_confidence_) continue;
                if (!image.values.empty())
                    image.values[k] = std::numeric_limits<float>::quiet_NaN();
                else
                    std::fill_n(image.image.samples.begin() + static_cast<std::ptrdiff_t>(k * bytes), bytes,
                                std::uint8_t{0});
            }
        });
        if (!all_trusted) return interrupted_error();
        return image;
    }

    std::optional<double> least_confidence() const override { return least_confidence_; }
    std::string left_out() const override { return left_out_; }
    void leave_out(std::string what) { left_out_ = std::move(what); }
    std::span<const SmallArray> small_arrays() const override { return small_arrays_; }
    void set_small_arrays(std::vector<SmallArray> arrays) { small_arrays_ = std::move(arrays); }

    /// Whether the first picture is integers from 0 to 65535.
    Result<bool> has_codes() {
        TRY_ASSIGN(const auto picture, read(0));
        return picture.has_codes();
    }
    /// All pictures become floats.
    void use_floats() { floats_ = true; }

    /// Where `confidence` is below `least` there is no depth. Refused where it is of other pictures.
    Result<void> trust(NpyStack confidence, std::optional<double> least) {
        if (confidence.count() != count() || confidence.width() != width() || confidence.height() != height())
            return input_error(confidence.where_ + ": is of " + std::to_string(confidence.count()) +
                               " pictures of " + std::to_string(confidence.width()) + "x" +
                               std::to_string(confidence.height()) + ", but depth of " +
                               std::to_string(count()) + " of " + std::to_string(width()) + "x" +
                               std::to_string(height()));
        if (!least) {
            TRY_ASSIGN(const auto first, confidence.image(0));
            std::vector<float> numbers(pixels_of(first));
            for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = number_at(first, k);
            const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
            std::ranges::nth_element(numbers, middle);
            least = *middle / 2.0;
        }
        least_confidence_ = least;
        confidence_ = std::make_unique<NpyStack>(std::move(confidence));
        return {};
    }

private:
    NpyStack(std::unique_ptr<ByteSource> bytes, std::string where, NpyHeader header, ArrayPictures pictures)
        : bytes_(std::move(bytes)),
          where_(std::move(where)),
          header_(std::move(header)),
          pictures_(pictures) {}
    Result<void> check() const {
        if (header_.columns_first && pictures_.count > 1)
            return input_error(where_ + ": is a stack in Fortran order: must be in C order, as " +
                               "numpy.ascontiguousarray makes it");
        const auto needed =
            static_cast<std::uint64_t>(pictures_.count) * static_cast<std::uint64_t>(pictures_.width) *
            static_cast<std::uint64_t>(pictures_.height) * static_cast<std::uint64_t>(header_.format.bytes);
        if (bytes_->size() < header_.data_at || bytes_->size() - header_.data_at < needed)
            return input_error(where_ + ": is cut short: has " + std::to_string(bytes_->size()) +
                               " bytes of " + std::to_string(header_.data_at + needed));
        return {};
    }

    /// Whether integers that may be beyond 16 bits are, in any picture.
    Result<void> find_floats() {
        const bool codes =
            header_.format.kind == NumberFormat::Kind::unsigned_integer && header_.format.bytes <= 2;
        if (codes || header_.format.kind == NumberFormat::Kind::floating) return {};
        for (std::int64_t number = 0; number < count() && count() > 1 && !floats_; ++number) {
            TRY_ASSIGN(const auto picture, read(number));
            floats_ = !picture.has_codes();
        }
        return {};
    }

    Result<NumberPicture> read(std::int64_t number) {
        const int bytes = header_.format.bytes, width = pictures_.width, height = pictures_.height;
        const bool columns = header_.columns_first;
        const int lines = columns ? width : height, line = bytes * (columns ? height : width);
        const int together = std::max(1, static_cast<int>(npy_block) / line);
        std::vector<char> block(static_cast<std::size_t>(line) *
                                static_cast<std::size_t>(std::min(together, lines)));
        NumberPicture picture(width, height, header_.format);
        std::uint64_t at = header_.data_at + static_cast<std::uint64_t>(number) *
                                                 static_cast<std::uint64_t>(line) *
                                                 static_cast<std::uint64_t>(lines);
        for (int first = 0; first < lines; first += together) {
            if (stop_requested()) return interrupted_error();
            const int now = std::min(together, lines - first);
            const std::size_t size = static_cast<std::size_t>(line) * static_cast<std::size_t>(now);
            if (auto got = bytes_->read(at, block.data(), size); !got) return error_at(where_, got.error());
            if (columns)
                picture.put(first, 0, {block.data(), now, height, line, bytes});
            else
                picture.put(0, first, {block.data(), width, now, bytes, line});
            at += size;
        }
        return picture;
    }

    std::unique_ptr<ByteSource> bytes_;
    std::string where_;
    NpyHeader header_;
    ArrayPictures pictures_;
    bool floats_ = false;
    std::unique_ptr<NpyStack> confidence_;
    std::optional<double> least_confidence_;
    std::string left_out_;
    std::vector<SmallArray> small_arrays_;
};

/// Arrays of an archive, one picture each.
class NpzRow final : public ImageStack {
public:
    NpzRow(NpzMember member, int width, int height)
        : archive_(std::move(member.archive)),
          row_(std::move(member.row)),
          where_(std::move(member.where)),
          small_arrays_(std::move(member.small_arrays)),
          width_(width),
          height_(height) {}
    static Result<std::shared_ptr<ImageStack>> of(NpzMember member) {
        TRY_ASSIGN(const auto size, pictures_of_array(member.row.front().header->shape, member.where));
        auto row = std::make_shared<NpzRow>(std::move(member), size.width, size.height);
        TRY(row->find_floats());
        return std::shared_ptr<ImageStack>(std::move(row));
    }

    std::int64_t count() const override { return std::ssize(row_); }
    int width() const override { return width_; }
    int height() const override { return height_; }
    std::optional<double> least_confidence() const override { return {}; }
    std::span<const SmallArray> small_arrays() const override { return small_arrays_; }
    Result<StoredImage> image(std::int64_t number) override {
        if (number < 0 || number >= count())
            return usage_error(where_ + ": has no picture " + std::to_string(number) +
                               ": must be from 0 to " + std::to_string(count() - 1));
        TRY_ASSIGN(auto picture, array(number));
        if (floats_) picture.use_floats();
        return picture.image(0);
    }

private:
    Result<NpyStack> array(std::int64_t number) {
        const NpzArray& own = row_[static_cast<std::size_t>(number)];
        return NpyStack::of(unpacked(archive_, own), where_ + ": " + printable(own.name));
    }
    /// Whether integers that may be beyond 16 bits are, in any picture.
    Result<void> find_floats() {
        const NumberFormat& format = row_.front().header->format;
        const bool codes = format.kind == NumberFormat::Kind::unsigned_integer && format.bytes <= 2;
        if (codes || format.kind == NumberFormat::Kind::floating) return {};
        for (std::int64_t number = 0; number < count() && !floats_; ++number) {
            TRY_ASSIGN(auto picture, array(number));
            TRY_ASSIGN(const bool has_codes, picture.has_codes());
            floats_ = !has_codes;
        }
        return {};
    }

    ZipArchive archive_;
    std::vector<NpzArray> row_;
    std::string where_;
    std::vector<SmallArray> small_arrays_;
    int width_, height_;
    bool floats_ = false;
};

Result<StoredImage> only_image(Result<NpyStack> stack, const std::string& where) {
    if (!stack) return stack.error();
    if (stack->count() == 1) return stack->image(0);
    return input_error(where + ": is a stack of " + std::to_string(stack->count()) + " pictures of " +
                       std::to_string(stack->width()) + "x" + std::to_string(stack->height()) +
                       ": must be one picture here");
}

}  // namespace

bool is_npy(std::string_view begin) {
    return begin.starts_with(npy_magic);
}

bool is_npz(std::string_view begin) {
    return begin.starts_with("PK\x03\x04");
}

Result<std::shared_ptr<ImageStack>> open_npy_stack(const SourceFile& file,
                                                   std::optional<double> least_confidence) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    NpzMember member{std::move(bytes), file.string()};
    if (is_npz(first_bytes(*member.bytes, 4))) {
        TRY_ASSIGN(member, open_npz(std::move(member.bytes), file.string()));
    }
    if (!member.row.empty()) return NpzRow::of(std::move(member));
    TRY_ASSIGN(auto stack, NpyStack::of(std::move(member.bytes), member.where));
    stack.leave_out(std::move(member.left_out));
    stack.set_small_arrays(std::move(member.small_arrays));
    if (member.confidence) {
        TRY_ASSIGN(auto confidence, NpyStack::of(std::move(member.confidence), file.string() + ": conf"));
        TRY(stack.trust(std::move(confidence), least_confidence));
    }
    return std::shared_ptr<ImageStack>(std::make_shared<NpyStack>(std::move(stack)));
}

bool is_npy_file(const SourceFile& file) {
    const std::string begin = first_bytes(file, 8);
    const std::string_view kind = picture_kind(begin);
    return kind == "npy" || kind == "npz";
}

Result<StoredImage> decode_npy(std::string_view bytes, const std::string& where) {
    return only_image(NpyStack::of(bytes_in_memory(bytes), where), where);
}

Result<StoredImage> decode_npz(std::string_view bytes, const std::string& where) {
    TRY_ASSIGN(auto member, open_npz(bytes_in_memory(bytes), where));
    if (!member.row.empty())
        return input_error(where + ": has " + std::to_string(member.row.size()) +
                           " pictures: must have one here");
    return only_image(NpyStack::of(std::move(member.bytes), member.where), member.where);
}

}  // namespace touchable
