// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <limits>

#include "engine/base/result.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"
#include "engine/picture/zip_archive.hpp"

namespace touchable {

namespace {

constexpr std::string_view npy_magic = "\x93NUMPY";

/// The header of a file in NumPy's format 1.0 to 3.0.
struct NpyHeader {
    NumberFormat format;
    bool columns_first = false;  ///< Fortran order: the first index runs fastest
    bool is_boolean = false;     ///< bytes of 0 and 1
    std::vector<std::int64_t> shape;
    std::size_t data_at = 0;  ///< bytes before the data
};

/// Parses the few Python literals of a header.
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
        {"f8", {Kind::floating, 8}},         {"b1", {Kind::unsigned_integer, 1}}};
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

Error unknown_type(std::string_view type, const std::string& where) {
    return input_error(where + ": is of NumPy's type " + in_quotes(type) +
                       ": must be an integer or float of 8 to 64 bits");
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
    if (*type == "|O")
        return input_error(
            where +
            ": is a pickled Python object, which is not read, as it may run any program: "
            "numpy.load(FILE, allow_pickle=True).item() opens it; numpy.save its array of depth");
    const auto format = number_format_of(*type);
    if (!format) return unknown_type(*type, where);
    return NpyHeader{*format, *columns_first, *type == "|b1", std::move(*shape)};
}

/// Every extent of the header's shape is at most 2^31.
Result<NpyHeader> read_npy_header(ByteSource& bytes, const std::string& where) {
    char begin[12] = {};
    if (bytes.size() < sizeof begin) return damaged_header(where);
    TRY(error_at(where, bytes.read(0, begin, sizeof begin)));
    if (!is_npy({begin, sizeof begin})) return damaged_header(where);
    const auto byte = [&](int at) { return std::size_t{static_cast<unsigned char>(begin[at])}; };
    if (byte(6) < 1 || byte(6) > 3)
        return input_error(where + ": is of NumPy's format " + std::to_string(byte(6)) + ": must be 1 to 3");
    const std::size_t text_at = byte(6) == 1 ? 10 : 12;
    const std::size_t length = byte(8) | byte(9) << 8 | (byte(6) == 1 ? 0 : byte(10) << 16 | byte(11) << 24);
    if (length > 65536 || text_at + length > bytes.size()) return damaged_header(where);
    std::string text(length, '\0');
    TRY(error_at(where, bytes.read(text_at, text.data(), length)));
    auto header = header_of_text(text, where);
    if (header) header->data_at = text_at + length;
    return header;
}

/// A member that is an array.
struct NpzArray {
    std::string name;  // without ".npy"
    ZipMember member;
    std::optional<NpyHeader> header{};  // if it can be read
};

/// A .npy file inside a .npz file, which is a zip archive.
struct NpzMember {
    std::unique_ptr<ByteSource> bytes;  ///< keeps the archive open
    std::string where;                  ///< both names, as messages begin
    std::string array{};                ///< its name; empty: the file is a single array
    /// Names of arrays of as many pictures of the same size that rate depth; empty: none.
    std::string confidence{}, mask{};
    /// Arrays of one picture each, which are the frames in place of `bytes`; empty: none.
    std::vector<NpzArray> row{};
    ZipArchive archive{};    ///< of all named arrays
    std::string left_out{};  ///< ImageStack
    std::vector<SmallArray> small_arrays{};
};

constexpr std::uint64_t most_members = 4096;

std::vector<NpzArray> npz_arrays(const ZipArchive& archive) {
    std::vector<NpzArray> arrays;
    for (const ZipMember& member : zip_members(archive)) {
        if (!member.name.ends_with(".npy")) continue;
        NpzArray array{member.name.substr(0, member.name.size() - 4), member};
        if (auto header = read_npy_header(*unpacked_member(archive, array.member), ""))
            array.header = std::move(*header);
        arrays.push_back(std::move(array));
    }
    return arrays;
}

/// A small array with readable numbers, in Fortran order only a matrix; half floats become NaN.
std::optional<SmallArray> small_array(const std::string& name, ByteSource& bytes, const NpyHeader& header) {
    if (header.columns_first && header.shape.size() > 2) return {};
    std::uint64_t count = 1;
    for (const std::int64_t extent : header.shape)
        count = count > most_small_numbers ? count : count * static_cast<std::uint64_t>(extent);
    const auto each = static_cast<std::size_t>(header.format.bytes);
    if (count == 0 || count > most_small_numbers || bytes.size() < header.data_at + count * each) return {};
    std::vector<char> held(static_cast<std::size_t>(count) * each);
    if (!bytes.read(header.data_at, held.data(), held.size())) return {};
    SmallArray read{name, header.shape, {}};
    const bool is_turned = header.columns_first && header.shape.size() == 2;
    const std::size_t rows = is_turned ? static_cast<std::size_t>(header.shape.front()) : 1;
    const std::size_t columns = count / rows;
    for (std::size_t k = 0; k < count; ++k)
        read.numbers.push_back(
            stored_number(held.data() + (k / columns + rows * (k % columns)) * each, header.format));
    return read;
}

std::vector<SmallArray> small_arrays_of(const ZipArchive& archive, const std::vector<NpzArray>& arrays) {
    std::vector<SmallArray> small;
    for (const NpzArray& array : arrays) {
        if (small.size() >= most_small_arrays || stop_requested()) break;
        if (!array.member.is_possible() || array.member.size > 8 * most_small_numbers + 70000) continue;
        if (!array.header) continue;
        if (auto read = small_array(array.name, *unpacked_member(archive, array.member), *array.header))
            small.push_back(std::move(*read));
    }
    return small;
}

std::vector<NamedArray> named_arrays(const std::vector<NpzArray>& arrays) {
    std::vector<NamedArray> named;
    for (const NpzArray& array : arrays) {
        NamedArray& last = named.emplace_back(NamedArray{array.name, {}, {}});
        if (!array.header) continue;
        last.shape = array.header->shape;
        last.format = array.header->format;
        last.is_boolean = array.header->is_boolean;
    }
    return named;
}

/// Whether the shape is that of a camera's matrix, or of several.
bool is_of_matrices(const std::vector<std::int64_t>& shape) {
    const std::size_t sides = shape.size();
    if (sides < 2 || sides > 3 || shape[sides - 1] != shape[sides - 2]) return false;
    return shape[sides - 1] == 3 || shape[sides - 1] == 4;
}

/// The places of depth's arrays: one, or several of one picture each.
Result<std::vector<std::size_t>> depth_places(const std::vector<NamedArray>& arrays,
                                              const std::string& wanted) {
    if (!wanted.empty()) {
        const auto found = std::ranges::find(arrays, wanted, &NamedArray::name);
        if (found == arrays.end())
            return input_error("has no array " + in_quotes(wanted) + ", but " + some_of(arrays),
                               {{Setting::dataset, "NAME"}});
        return std::vector{static_cast<std::size_t>(found - arrays.begin())};
    }
    if (arrays.size() == 1) return std::vector<std::size_t>{0};
    TRY_ASSIGN(auto places, depth_among(arrays, "array"));
    const bool has_points = std::ranges::any_of(arrays, [](const auto& array) {
        return array.shape.size() > 2 && array.shape.back() == 3 && !is_of_matrices(array.shape);
    });
    if (places.empty())
        return input_error(
            "has no array of pictures of depth (height x width, or count x height x width): it has " +
                some_of(arrays) + (has_points ? "; of points " + std::string(depth_of_points) : ""),
            {{Setting::dataset, "NAME"}});
    return places;
}

/// Whether an array has as many pictures as depth, of the same size.
bool is_of_same_pictures(const NamedArray& array, const NamedArray& depth) {
    const auto own = pictures_of_array(array.shape, ""), other = pictures_of_array(depth.shape, "");
    return array.format && own && other && own->count == other->count && own->width == other->width &&
           own->height == other->height;
}

/// Finds depth's confidence and mask, and lists other arrays that may be depth, confidence or mask.
void find_beside(const std::vector<NamedArray>& arrays, const NamedArray& depth, NpzMember& found) {
    const auto has = [](const NamedArray& array, const char* word) {
        return small_letters(array.name).find(word) != std::string::npos;
    };
    std::vector<const NamedArray*> alike, confidences, masks;
    for (const NamedArray& array : arrays)
        if (&array != &depth && is_of_same_pictures(array, depth)) alike.push_back(&array);
    for (const NamedArray* array : alike) {
        const std::string name = small_letters(array->name);
        const bool is_byte =
            array->format->kind == NumberFormat::Kind::unsigned_integer && array->format->bytes == 1;
        if (has(*array, "conf")) confidences.push_back(array);
        if (is_byte && (name == "valid" || name == "valid_mask" || name == "mask")) masks.push_back(array);
    }
    // A confidence of this name is depth's own, so one with other pictures is refused when read.
    for (const NamedArray& array : arrays)
        if (&array != &depth && array.format && (array.name == "conf" || array.name == "confidence"))
            confidences = {&array};
    if (confidences.size() > 1)
        std::erase_if(confidences, [](const NamedArray* array) { return !has_depth_in_name(*array); });
    if (confidences.size() == 1) found.confidence = confidences.front()->name;
    if (masks.size() == 1) found.mask = masks.front()->name;
    std::vector<std::string> names;
    for (const NamedArray* array : alike)
        if (array->name != found.confidence && array->name != found.mask &&
            (may_be_depth(*array) || is_trust_of_depth(*array)))
            names.push_back(printable(array->name));
    for (const NamedArray& array : arrays)
        if (is_colour(array)) names.push_back(printable(array.name));
    if (!names.empty())
        found.left_out =
            "depth is the array " + printable(depth.name) + "; left out: " + printable(listed(names), 200);
}

/// `wanted`: the name of depth's array; empty: found.
Result<NpzMember> depth_member_of(ZipArchive archive, const std::string& where, const std::string& wanted) {
    const auto arrays = npz_arrays(archive);
    if (arrays.empty())
        return input_error(where +
                           ": is a zip archive without arrays (.npy): unpack it, or give what is inside");
    const auto named = named_arrays(arrays);
    TRY_ASSIGN(const auto places, error_at(where, depth_places(named, wanted)));
    for (const std::size_t place : places)
        if (const ZipMember& member = arrays[place].member; !member.is_possible())
            return input_error(where + ": " + printable(arrays[place].name) +
                               ": is damaged: is said to unpack to " + std::to_string(member.size) +
                               " bytes");
    NpzMember found{nullptr, where};
    found.small_arrays = small_arrays_of(archive, arrays);
    const std::size_t first = places.front();
    found.array = arrays[first].name;
    if (places.size() > 1) {
        for (const std::size_t place : places) found.row.push_back(arrays[place]);
    } else {
        found.bytes = unpacked_member(archive, arrays[first].member);
        found.where = where + ": " + printable(found.array);
        find_beside(named, named[first], found);
    }
    found.archive = std::move(archive);
    return found;
}

/// Opens the array that depth is read from. Messages begin with `where`.
Result<NpzMember> open_npz(std::unique_ptr<ByteSource> bytes, const std::string& where,
                           const std::string& wanted = {}) {
    TRY_ASSIGN(auto archive, open_zip(std::move(bytes), most_members, where));
    return depth_member_of(std::move(archive), where, wanted);
}

constexpr std::size_t npy_block = std::size_t{1} << 20;

/// The number of pixel k, row by row; NaN counts as the lowest.
float number_at(const StoredImage& picture, std::size_t k) {
    if (picture.values.empty()) return sample_at(picture.image, k);
    const float value = picture.values[k];
    return value == value ? value : std::numeric_limits<float>::lowest();
}

class NpyStack final : public ImageStack {
public:
    /// Opens a .npy file's bytes; booleans are allowed if `is_mask`. Messages begin with `where`.
    static Result<NpyStack> of(std::unique_ptr<ByteSource> bytes, std::string where, bool is_mask = false) {
        TRY_ASSIGN(auto header, read_npy_header(*bytes, where));
        if (header.is_boolean && !is_mask) return unknown_type("|b1", where);
        if (is_of_matrices(header.shape))
            return input_error(where + ": is of " + shape_text(header.shape) +
                               " numbers, as cameras' matrices are: must be a picture of depth");
        TRY_ASSIGN(const auto pictures, pictures_of_array(header.shape, where));
        NpyStack stack(std::move(bytes), std::move(where), std::move(header), pictures);
        TRY(stack.check());
        if (!stack.header_.format.is_decided()) TRY(stack.find_floats());
        return stack;
    }

    /// Opens a .npz file's member that is one array, with those of `file` that rate it.
    static Result<NpyStack> of(NpzMember member, const std::string& file,
                               std::optional<double> least_confidence) {
        TRY_ASSIGN(auto stack, of(std::move(member.bytes), member.where));
        stack.left_out_ = member.left_out;
        stack.array_ = member.array;
        stack.small_arrays_ = std::move(member.small_arrays);
        if (member.confidence.empty() && member.mask.empty()) return stack;
        const auto arrays = npz_arrays(member.archive);
        const auto beside = [&](const std::string& name) {
            return of(
                unpacked_member(member.archive, std::ranges::find(arrays, name, &NpzArray::name)->member),
                file + ": " + printable(name), true);
        };
        if (!member.confidence.empty()) {
            TRY_ASSIGN(auto confidence, beside(member.confidence));
            TRY(stack.trust(std::move(confidence), least_confidence));
        }
        if (!member.mask.empty()) {
            TRY_ASSIGN(auto mask, beside(member.mask));
            TRY_ASSIGN(const bool is_taken, stack.take_mask(std::move(mask)));
            stack.left_out_ +=
                (stack.left_out_.empty() ? "" : "; ") +
                (is_taken ? "where its array " + printable(member.mask) + " is 0 there is no depth"
                          : "its array " + printable(member.mask) + " is not used, as most of it is not 1");
        }
        return stack;
    }

    std::int64_t count() const override { return pictures_.count; }
    int width() const override { return pictures_.width; }
    int height() const override { return pictures_.height; }
    Result<StoredImage> read(std::int64_t number, bool floats_anyway) override {
        TRY_ASSIGN(auto picture, numbers(number));
        StoredImage image = std::move(picture).finish("npy", floats_anyway);
        if (stop_requested()) return interrupted_error();
        if (confidence_) TRY(drop(image, *confidence_, number, *least_confidence_));
        if (mask_) TRY(drop(image, *mask_, number, 1));
        return image;
    }

private:
    /// Removes depth where `confidence` is below `least`. Refused if its pictures differ in number or size.
    Result<void> trust(NpyStack confidence, std::optional<double> least) {
        if (confidence.count() != count() || confidence.width() != width() || confidence.height() != height())
            return input_error(confidence.where_ + ": is of " + std::to_string(confidence.count()) +
                               " pictures of " + size_text(confidence.width(), confidence.height()) +
                               ", but depth of " + std::to_string(count()) + " of " +
                               size_text(width(), height()));
        if (!least) {
            TRY_ASSIGN(const auto first, confidence.image(0));
            std::vector<float> numbers(pixel_count(first.image));
            for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = number_at(first, k);
            least = sorted_element(numbers, numbers.size() / 2) / 2.0;
        }
        least_confidence_ = least;
        confidence_ = std::make_unique<NpyStack>(std::move(confidence));
        return {};
    }

    /// Removes depth where `mask` is 0, if it has only 0 and 1, and 1 in most of its first picture; otherwise
    /// it is not depth's mask: returns false.
    Result<bool> take_mask(NpyStack mask) {
        TRY_ASSIGN(const auto first, mask.image(0));
        const auto& samples = first.image.samples;
        if (std::ranges::any_of(samples, [](std::uint8_t sample) { return sample > 1; })) return false;
        if (2 * std::ranges::count(samples, 1) <= std::ssize(samples)) return false;
        mask_ = std::make_unique<NpyStack>(std::move(mask));
        return true;
    }

    /// Removes depth where `trust`'s picture of the same number is below `least`.
    static Result<void> drop(StoredImage& image, NpyStack& trust, std::int64_t number, double least) {
        TRY_ASSIGN(const auto numbers, trust.image(number));
        const auto bytes = static_cast<std::size_t>(image.image.bytes_per_sample);
        const bool is_whole = until_stopped(pixel_count(image.image), [&](std::size_t first,
                                                                          std::size_t last) {
            for (std::size_t k = first; k < last; ++k) {
                if (number_at(numbers, k) >= least) continue;
                if (!image.values.empty())
                    image.values[k] = std::numeric_limits<float>::quiet_NaN();
                else
                    std::fill_n(image.image.samples.begin() + static_cast<std::ptrdiff_t>(k * bytes), bytes,
                                std::uint8_t{0});
            }
        });
        return is_whole ? Result<void>{} : Result<void>(interrupted_error());
    }

    NpyStack(std::unique_ptr<ByteSource> bytes, std::string where, NpyHeader header, ArrayPictures pictures)
        : ImageStack(std::move(where)),
          bytes_(std::move(bytes)),
          header_(std::move(header)),
          pictures_(pictures) {}
    Result<void> check() const {
        if (header_.columns_first && pictures_.count > 1)
            return input_error(where_ + ": is a stack in Fortran order: must be in C order, as " +
                               "numpy.ascontiguousarray makes it");
        const std::uint64_t needed = static_cast<std::uint64_t>(pictures_.count) *
                                     pixel_count(pictures_.width, pictures_.height) *
                                     static_cast<std::uint64_t>(header_.format.bytes);
        if (bytes_->size() < header_.data_at || bytes_->size() - header_.data_at < needed)
            return input_error(where_ + ": is cut short: has " + std::to_string(bytes_->size()) +
                               " bytes of " + std::to_string(header_.data_at + needed));
        return {};
    }

    Result<NumberPicture> numbers(std::int64_t number) {
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
            TRY(error_at(where_, bytes_->read(at, block.data(), size)));
            if (columns)
                picture.put(first, 0, {block.data(), now, height, line, bytes});
            else
                picture.put(0, first, {block.data(), width, now, bytes, line});
            at += size;
        }
        return picture;
    }

    std::unique_ptr<ByteSource> bytes_;
    NpyHeader header_;
    ArrayPictures pictures_;
    std::unique_ptr<NpyStack> confidence_, mask_;
};

/// Arrays of an archive, one picture each.
class NpzRow final : public ImageStack {
public:
    NpzRow(NpzMember member, const ArrayPictures& size)
        : ImageStack(std::move(member.where)),
          archive_(std::move(member.archive)),
          row_(std::move(member.row)),
          size_(size) {
        array_ = row_.front().name;
        small_arrays_ = std::move(member.small_arrays);
    }
    static Result<std::shared_ptr<ImageStack>> of(NpzMember member) {
        TRY_ASSIGN(const auto size, pictures_of_array(member.row.front().header->shape, member.where));
        auto row = std::make_shared<NpzRow>(std::move(member), size);
        if (!row->row_.front().header->format.is_decided()) TRY(row->find_floats());
        return std::shared_ptr<ImageStack>(std::move(row));
    }

    std::int64_t count() const override { return std::ssize(row_); }
    int width() const override { return size_.width; }
    int height() const override { return size_.height; }

private:
    Result<StoredImage> read(std::int64_t number, bool floats_anyway) override {
        const NpzArray& own = row_[static_cast<std::size_t>(number)];
        TRY_ASSIGN(auto array,
                   NpyStack::of(unpacked_member(archive_, own.member), where_ + ": " + printable(own.name)));
        return array.read(0, floats_anyway);
    }

    ZipArchive archive_;
    std::vector<NpzArray> row_;
    ArrayPictures size_;  // of each
};

Result<StoredImage> only_image(Result<NpyStack> opened, const std::string& where) {
    TRY_ASSIGN(auto stack, std::move(opened));
    if (stack.count() == 1) return stack.image(0);
    return input_error(where + ": is a stack of " + std::to_string(stack.count()) + " pictures of " +
                       size_text(stack.width(), stack.height()) + ": must be one picture here");
}

}  // namespace

bool is_npy(std::string_view begin) {
    return begin.starts_with(npy_magic);
}

bool is_npz(std::string_view begin) {
    return begin.starts_with("PK\x03\x04");
}

Result<std::shared_ptr<ImageStack>> open_npy_stack(const SourceFile& file,
                                                   std::optional<double> least_confidence,
                                                   const std::string& array) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    NpzMember member{std::move(bytes), file.string()};
    if (is_npz(first_bytes(*member.bytes, 4)))
        TRY(assign(member, open_npz(std::move(member.bytes), file.string(), array)));
    if (!member.row.empty()) return NpzRow::of(std::move(member));
    TRY_ASSIGN(auto stack, NpyStack::of(std::move(member), file.string(), least_confidence));
    return std::shared_ptr<ImageStack>(std::make_shared<NpyStack>(std::move(stack)));
}

std::vector<SmallArray> small_arrays_in(const SourceFile& file) {
    auto bytes = bytes_of_file(file);
    if (!bytes) return {};
    if (is_npz(first_bytes(**bytes, 4))) {
        const auto archive = open_zip(std::move(*bytes), most_members, "");
        return archive ? small_arrays_of(*archive, npz_arrays(*archive)) : std::vector<SmallArray>();
    }
    const auto header = read_npy_header(**bytes, "");
    auto only = header ? small_array(file.path().stem().string(), **bytes, *header) : std::nullopt;
    return only ? std::vector{std::move(*only)} : std::vector<SmallArray>();
}

bool is_npy_file(const SourceFile& file) {
    const std::string begin = first_bytes(file, 8);
    const std::string_view kind = picture_kind(begin);
    return kind == "npy" || kind == "npz";
}

bool has_named_arrays(const SourceFile& file) {
    return is_hdf5_file(file) || is_npz(first_bytes(file, 4));
}

Result<StoredImage> decode_npy(std::string_view bytes, const std::string& where) {
    return only_image(NpyStack::of(bytes_in_memory(bytes), where), where);
}

Result<StoredImage> decode_npz(std::string_view bytes, const std::string& where) {
    TRY_ASSIGN(auto member, open_npz(bytes_in_memory(bytes), where));
    if (!member.row.empty())
        return input_error(where + ": has " + std::to_string(member.row.size()) +
                           " pictures: must have one here");
    const std::string name = member.where;
    return only_image(NpyStack::of(std::move(member), where, {}), name);
}

std::string npy_header(std::int64_t frames, int height, int width) {
    std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(frames) + ", " +
                       std::to_string(height) + ", " + std::to_string(width) + "), }";
    constexpr std::size_t whole = 118;  // with what is before it 128 bytes
    text.resize(whole - 1, ' ');
    return std::string(npy_magic) + std::string("\x01\x00\x76\x00", 4) + text + '\n';
}

}  // namespace touchable
