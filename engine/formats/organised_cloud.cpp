// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/organised_cloud.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::size_t largest_cloud_header = std::size_t{64} << 10;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Takes the first word off a text; empty after the last.
std::string_view cut_word(std::string_view& text) {
    constexpr std::string_view blanks = " \t\r\n";
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

/// Takes the first line off a header; nothing if no whole line is left. `end`: the bytes before the next one.
std::optional<std::string_view> next_header_line(std::string_view bytes, std::size_t& end) {
    std::string_view rest = bytes.substr(end, largest_cloud_header - end);
    if (rest.find('\n') == std::string_view::npos) return {};
    const std::string_view line = cut_line(rest);
    end += line.size() + 1;
    return line;
}

std::optional<std::uint64_t> count_in(std::string_view word, std::uint64_t most) {
    const auto number = parsed_as<std::uint64_t>(word);
    return number && *number <= most ? number : std::nullopt;
}

/// How a number is stored.
struct Scalar {
    char kind = 'F';  ///< 'F': floating, 'I': signed, 'U': unsigned, as PCD calls them
    std::size_t bytes = 4;

    bool is_known() const {
        return kind == 'F' ? bytes == 4 || bytes == 8
                           : (kind == 'I' || kind == 'U') && bytes <= 8 && std::has_single_bit(bytes);
    }
};

double number_at(const char* from, const Scalar& scalar, bool big_endian) {
    const std::uint64_t bits = number_in_bytes({from, scalar.bytes}, big_endian);
    if (scalar.kind == 'U') return static_cast<double>(bits);
    if (scalar.kind == 'F')
        return scalar.bytes == 8
                   ? std::bit_cast<double>(bits)
                   : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    const auto unused = static_cast<int>(64 - 8 * scalar.bytes);
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

/// Parses a number, also nan and inf; beyond the range of a double it is NaN. Nothing: the word is no number.
std::optional<double> number_of_word(std::string_view word) {
    if (word.starts_with('+')) word.remove_prefix(1);
    double number = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (word.empty() || failure == std::errc::invalid_argument || end != word.data() + word.size()) return {};
    return failure == std::errc() ? number : not_a_number;
}

Error cut_short(const std::string& where) {
    return input_error(where + ": is cut short: has fewer points than its header states");
}

// --- The picture that points make

/// Place = middle + focal * slope, by least squares.
struct SlopeFit {
    double count = 0, slopes = 0, places = 0, squares = 0, products = 0;

    void add(double slope, double place) {
        ++count;
        slopes += slope;
        places += place;
        squares += slope * slope;
        products += slope * place;
    }
    /// Negative if the axis goes the other way.
    double focal() const {
        const double spread = squares - slopes * slopes / count;
        return spread > 0 ? (products - slopes * places / count) / spread : not_a_number;
    }
    double middle() const { return (places - focal() * slopes) / count; }
};

/// Collects a cloud's points, and finds their camera.
class CloudPicture {
public:
    CloudPicture(int width, int height, bool has_colour)
        : width_(width),
          height_(height),
          depth_(pixel_count(width, height), std::numeric_limits<float>::quiet_NaN()),
          across_(depth_.size()),
          down_(depth_.size()),
          colour_(has_colour ? 3 * depth_.size() : 0) {}

    void put(std::size_t pixel, double x, double y, double z) {
        const auto depth = static_cast<float>(z);
        if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(depth) || depth == 0) return;
        depth_[pixel] = depth;
        across_[pixel] = static_cast<float>(x / z);
        down_[pixel] = static_cast<float>(y / z);
        is_ahead_ = is_ahead_ || z > 0;
    }
    void paint(std::size_t pixel, const std::array<std::uint8_t, 3>& rgb) {
        std::ranges::copy(rgb, colour_.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
    }

    /// `kind`: PCD or PLY.
    Result<OrganisedCloud> finish(const std::string& kind, const std::string& where) && {
        const float side = is_ahead_ ? 1.0F : -1.0F;
        for (float& depth : depth_) depth = depth * side > 0 ? depth * side : no_depth;
        OrganisedCloud cloud;
        if (std::ranges::any_of(depth_, [](float depth) { return depth > 0; }))
            TRY(assign(cloud.camera, find_camera(kind, where)));
        cloud.depth.image = {width_, height_, 4, 1, {}};
        cloud.depth.codec = small_letters(kind);
        cloud.depth.pixel_format = "grayf32le";
        cloud.depth.bits = 32;
        cloud.depth.values = std::move(depth_);
        if (colour_.empty()) return cloud;
        cloud.depth.beside = std::make_shared<BesideDepth>();
        StoredImage& colour = cloud.depth.beside->colour.emplace();
        colour.image = {width_, height_, 1, 3, std::move(colour_)};
        colour.codec = cloud.depth.codec;
        colour.pixel_format = "rgb24";
        return cloud;
    }

private:
    static constexpr float no_depth = std::numeric_limits<float>::quiet_NaN();

    void for_each_point(auto&& act) const {
        std::size_t k = 0;
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x, ++k)
                if (depth_[k] > 0) act(x, y, double{across_[k]}, double{down_[k]});
    }

    Result<Intrinsics> find_camera(const std::string& kind, const std::string& where) {
        SlopeFit columns, rows;
        for_each_point([&](int x, int y, double across, double down) {
            columns.add(across, x);
            rows.add(down, y);
        });
        const double fx = columns.focal(), cx = columns.middle(), fy = rows.focal(), cy = rows.middle();
        double off = 0;
        for_each_point([&](int x, int y, double across, double down) {
            constexpr double most = 1;  // pixels
            const bool fits = std::abs(fx * across + cx - x) <= most && std::abs(fy * down + cy - y) <= most;
            if (!fits) ++off;
        });
        constexpr double largest_share = 0.02;
        const bool is_pinhole =
            std::isfinite(fx * fy) && fx != 0 && fy != 0 && off <= largest_share * columns.count;
        if (!is_pinhole)
            return input_error(where + ": is a " + kind + " cloud of " + size_text(width_, height_) +
                               " points whose rows and columns are not the pixels of one pinhole camera (" +
                               short_number(100 * off / columns.count, 2) +
                               " % of them lie more than a pixel off in the best one): project it into a "
                               "camera (t.geometry.PointCloud.project_to_depth_image of Open3D) and save "
                               "that picture, then: touchable play depth.png");
        Intrinsics camera{std::abs(fx), std::abs(fy), cx, cy, width_, height_};
        // In OpenGL's frame y goes up and z, by which slopes are divided, is negative.
        const bool begins_below = !is_ahead_ && fx < 0 && fy < 0;
        if (begins_below) {
            turn_rows(depth_, static_cast<std::size_t>(width_));
            turn_rows(colour_, 3 * static_cast<std::size_t>(width_));
            camera.cy = height_ - 1 - cy;
        }
        return camera;
    }

    template <class Sample>
    static void turn_rows(std::vector<Sample>& samples, std::size_t row) {
        for (std::size_t above = 0, below = samples.size(); above + 2 * row <= below; above += row) {
            below -= row;
            std::swap_ranges(samples.begin() + static_cast<std::ptrdiff_t>(above),
                             samples.begin() + static_cast<std::ptrdiff_t>(above + row),
                             samples.begin() + static_cast<std::ptrdiff_t>(below));
        }
    }

    int width_, height_;
    std::vector<float> depth_, across_, down_;  // z until `finish`, x / z, y / z
    std::vector<std::uint8_t> colour_;          // empty: there is none
    bool is_ahead_ = false;                     // a point has a positive z
};

// --- PCD

struct PcdField {
    std::string_view name;
    Scalar scalar{};
    std::size_t count = 1;
    std::size_t offset = 0;  ///< bytes of a point before it
    std::size_t words = 0;   ///< numbers of a point before it

    bool is_one_number() const { return count == 1 && scalar.is_known(); }
};

struct PcdHeader {
    std::vector<PcdField> fields{};
    std::uint64_t width = 0, height = 0;
    std::optional<std::uint64_t> points{};
    std::string_view data{};  ///< "ascii", "binary", "binary_compressed"
    std::size_t end = 0;      ///< bytes of the header
    std::size_t point_bytes = 0, point_words = 0;

    const PcdField* field(std::string_view name) const { return named_in(fields, name, &PcdField::name); }
};

constexpr std::uint64_t largest_count = 1'000'000'000;

/// Parses a PCD header; nothing if it is none.
std::optional<PcdHeader> pcd_header(std::string_view bytes) {
    constexpr std::size_t most_fields = 64, largest_field = 4096;
    PcdHeader header;
    while (auto words = next_header_line(bytes, header.end)) {
        const std::string_view key = cut_word(*words);
        if (key == "FIELDS") {
            header.fields.clear();
            for (auto name = cut_word(*words); !name.empty(); name = cut_word(*words))
                header.fields.push_back({name});
            if (header.fields.size() > most_fields) return {};
        } else if (key == "SIZE" || key == "COUNT") {
            for (PcdField& field : header.fields) {
                const auto number = count_in(cut_word(*words), largest_field);
                if (!number) return {};
                (key == "SIZE" ? field.scalar.bytes : field.count) = *number;
            }
        } else if (key == "TYPE") {
            for (PcdField& field : header.fields) {
                const std::string_view type = cut_word(*words);
                if (type.size() != 1) return {};
                field.scalar.kind = type[0];
            }
        } else if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
            const auto number = count_in(cut_word(*words), largest_count);
            if (!number) return {};
            if (key == "POINTS")
                header.points = number;
            else
                (key == "WIDTH" ? header.width : header.height) = *number;
        } else if (key == "DATA") {
            header.data = cut_word(*words);
            for (PcdField& field : header.fields) {
                field.offset = header.point_bytes;
                field.words = header.point_words;
                header.point_bytes += field.scalar.bytes * field.count;
                header.point_words += field.count;
            }
            return header;
        }
    }
    return {};
}

/// Unpacks LZF into exactly `size` bytes; nothing if `packed` is invalid.
std::optional<std::string> unpacked_lzf(std::string_view packed, std::size_t size) {
    std::string out;
    out.reserve(size);
    std::size_t at = 0;
    const auto next = [&] { return static_cast<unsigned char>(packed[at++]); };
    while (at < packed.size()) {
        const std::size_t control = next();
        if (control < 32) {  // control + 1 literal bytes
            const std::size_t count = control + 1;
            if (count > packed.size() - at || count > size - out.size()) return {};
            out += packed.substr(at, count);
            at += count;
            continue;
        }
        std::size_t count = control >> 5;
        if (packed.size() - at < (count == 7 ? 2U : 1U)) return {};
        if (count == 7) count += next();
        count += 2;
        const std::size_t back = ((control & 31) << 8) + next() + 1;
        if (back > out.size() || count > size - out.size()) return {};
        for (std::size_t k = 0; k < count; ++k) out += out[out.size() - back];
    }
    return out.size() == size ? std::optional(std::move(out)) : std::nullopt;
}

/// The bytes of a PCD file's points, unpacked into `unpacked` if they are packed.
Result<std::string_view> pcd_points(const PcdHeader& header, std::string_view bytes, std::uint64_t size,
                                    std::string& unpacked, const std::string& where) {
    const std::string_view data = bytes.substr(header.end);
    if (header.data == "binary")
        return data.size() < size ? cut_short(where) : Result<std::string_view>(data);
    if (header.data != "binary_compressed")
        return input_error(where + ": its points are " + in_quotes(header.data) +
                           ": must be ascii, binary or binary_compressed");
    constexpr std::size_t head = 8;
    if (data.size() < head) return cut_short(where);
    const std::uint64_t packed = number_in_bytes(data.substr(0, 4), false),
                        stated = number_in_bytes(data.substr(4, 4), false);
    if (packed > data.size() - head) return cut_short(where);
    if (stated != size)
        return input_error(where + ": is damaged: its points are said to unpack to " +
                           std::to_string(stated) + " bytes: must be " + std::to_string(size));
    constexpr std::uint64_t largest_expansion = 88, largest = std::uint64_t{1} << 30;
    if (size / largest_expansion > packed || size > largest)
        return input_error(where + ": is damaged, or too large: has " + std::to_string(packed) +
                           " bytes for " + std::to_string(size) + " of points: must be " + in_bytes(largest) +
                           " at most");
    auto whole = unpacked_lzf(data.substr(head, packed), size);
    if (!whole) return input_error(where + ": is damaged: its points cannot be unpacked");
    unpacked = std::move(*whole);
    return std::string_view(unpacked);
}

std::array<std::uint8_t, 3> packed_colour(std::uint64_t rgb) {
    return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8),
            static_cast<std::uint8_t>(rgb)};
}

/// In text, a colour is a whole number, or a float with the same bits, which is tiny.
std::array<std::uint8_t, 3> colour_in_text(double number) {
    if (number >= 1 && number <= 0xffffffffU) return packed_colour(static_cast<std::uint32_t>(number));
    return packed_colour(std::bit_cast<std::uint32_t>(static_cast<float>(number)));
}

Result<OrganisedCloud> decode_pcd(std::string_view bytes, const std::string& where) {
    const auto header = pcd_header(bytes);
    if (!header) return input_error(where + ": is damaged: its header is not that of a PCD file");
    TRY(check_picture_size(static_cast<std::int64_t>(header->width),
                           static_cast<std::int64_t>(header->height), where));
    const std::uint64_t points = header->width * header->height;
    if (header->points.value_or(points) != points)
        return input_error(where + ": is damaged: has " + std::to_string(*header->points) +
                           " points: must be " + std::to_string(points) + ", its width times its height");
    std::array<const PcdField*, 3> axes{header->field("x"), header->field("y"), header->field("z")};
    for (const PcdField* axis : axes)
        if (axis == nullptr || !axis->is_one_number())
            return input_error(where + ": has no fields x, y and z of one number each");
    const PcdField* colour = header->field("rgb");
    if (colour == nullptr) colour = header->field("rgba");
    if (colour != nullptr && (!colour->is_one_number() || colour->scalar.bytes != 4)) colour = nullptr;
    const int width = static_cast<int>(header->width), height = static_cast<int>(header->height);
    const bool is_text = header->data == "ascii";
    std::string_view data = bytes.substr(header->end);
    std::string unpacked;
    // In text, each number takes at least two bytes: a digit and a separator.
    if (is_text && points * header->point_words * 2 > data.size() + 1) return cut_short(where);
    if (!is_text)
        TRY(assign(data, pcd_points(*header, bytes, points * header->point_bytes, unpacked, where)));
    CloudPicture picture(width, height, colour != nullptr);
    if (is_text) {
        std::vector<double> numbers(header->point_words);
        for (std::size_t k = 0; k < points; ++k) {
            for (double& number : numbers) {
                const std::string_view word = cut_word(data);
                if (word.empty()) return cut_short(where);
                const auto read = number_of_word(word);
                if (!read)
                    return input_error(where + ": point " + std::to_string(k) + " has " + in_quotes(word) +
                                       ": must be a number");
                number = *read;
            }
            picture.put(k, numbers[axes[0]->words], numbers[axes[1]->words], numbers[axes[2]->words]);
            if (colour) picture.paint(k, colour_in_text(numbers[colour->words]));
        }
        return std::move(picture).finish("PCD", where);
    }
    // Packed points are stored field by field: first one field of all points, then the next.
    const bool by_fields = header->data == "binary_compressed";
    const auto at = [&](const PcdField& field, std::size_t k) {
        return data.data() + (by_fields ? field.offset * points + k * field.scalar.bytes
                                        : k * header->point_bytes + field.offset);
    };
    for (std::size_t k = 0; k < points; ++k) {
        std::array<double, 3> point{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = number_at(at(*axes[axis], k), axes[axis]->scalar, false);
        picture.put(k, point[0], point[1], point[2]);
        if (colour) picture.paint(k, packed_colour(number_in_bytes({at(*colour, k), 4}, false)));
    }
    return std::move(picture).finish("PCD", where);
}

// --- PLY

struct PlyProperty {
    std::string_view name;
    Scalar scalar{};
    std::optional<Scalar> count{};  ///< of a list: how its length is stored
};

struct PlyElement {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties{};

    /// Index of the first property with one of these names that is a single number.
    std::optional<std::size_t> place_of(std::initializer_list<std::string_view> names) const {
        for (std::size_t k = 0; k < properties.size(); ++k)
            if (!properties[k].count && std::ranges::count(names, properties[k].name) > 0) return k;
        return {};
    }
};

struct PlyHeader {
    std::string_view format{};  ///< "ascii", "binary_little_endian", "binary_big_endian"
    std::vector<PlyElement> elements{};
    std::uint64_t width = 0, height = 0;  ///< 0: not stated
    std::size_t end = 0;

    const PlyElement* element(std::string_view name) const {
        return named_in(elements, name, &PlyElement::name);
    }
};

std::optional<Scalar> ply_scalar(std::string_view name) {
    struct Known {
        std::string_view name, sized_name;
        Scalar scalar;
    };
    constexpr Known all[] = {
        {"char", "int8", {'I', 1}},     {"uchar", "uint8", {'U', 1}},    {"short", "int16", {'I', 2}},
        {"ushort", "uint16", {'U', 2}}, {"int", "int32", {'I', 4}},      {"uint", "uint32", {'U', 4}},
        {"float", "float32", {'F', 4}}, {"double", "float64", {'F', 8}},
    };
    for (const Known& known : all)
        if (name == known.name || name == known.sized_name) return known.scalar;
    return {};
}

/// Parses a PLY header; nothing if it is none.
std::optional<PlyHeader> ply_header(std::string_view bytes) {
    constexpr std::size_t most_elements = 64, most_properties = 256;
    PlyHeader header;
    while (auto words = next_header_line(bytes, header.end)) {
        const std::string_view key = cut_word(*words);
        if (key == "end_header") return header;
        if (key == "format") {
            header.format = cut_word(*words);
        } else if (key == "comment" || key == "obj_info") {
            const std::string what = small_letters(std::string(cut_word(*words)));
            const auto number = count_in(cut_word(*words), largest_count);
            if (number && (what == "num_cols" || what == "width")) header.width = *number;
            if (number && (what == "num_rows" || what == "height")) header.height = *number;
        } else if (key == "element") {
            const std::string_view name = cut_word(*words);
            const auto count = count_in(cut_word(*words), largest_count);
            if (!count || header.elements.size() == most_elements) return {};
            header.elements.push_back({name, *count});
        } else if (key == "property") {
            PlyProperty property;
            std::string_view type = cut_word(*words);
            if (type == "list") {
                property.count = ply_scalar(cut_word(*words));
                if (!property.count) return {};
                type = cut_word(*words);
            }
            const auto scalar = ply_scalar(type);
            if (!scalar || header.elements.empty()) return {};
            property.scalar = *scalar;
            property.name = cut_word(*words);
            auto& properties = header.elements.back().properties;
            if (properties.size() == most_properties) return {};
            properties.push_back(property);
        }
    }
    return {};
}

/// Reads the numbers behind a PLY file's header, one after the other.
class PlyNumbers {
public:
    PlyNumbers(std::string_view format, std::string_view data)
        : is_text_(format == "ascii"), big_endian_(format == "binary_big_endian"), data_(data) {}
    /// Nothing at the end, and if a word is no number.
    std::optional<double> next(const Scalar& scalar) {
        if (is_text_) return number_of_word(cut_word(data_));
        if (data_.size() < scalar.bytes) return {};
        const double number = number_at(data_.data(), scalar, big_endian_);
        data_.remove_prefix(scalar.bytes);
        return number;
    }
    /// Reads the numbers of one row of an element; of a list its first, NaN if it is empty. False at the end.
    bool take(const PlyElement& element, std::vector<double>& numbers) {
        numbers.clear();
        for (const PlyProperty& property : element.properties) {
            double count = 1, first = not_a_number;
            if (property.count) {
                const auto stated = next(*property.count);
                if (!stated) return false;
                count = *stated;
            }
            for (double k = 0; k < count; ++k) {
                const auto number = next(property.scalar);
                if (!number) return false;
                if (k == 0) first = *number;
            }
            numbers.push_back(first);
        }
        return true;
    }

private:
    bool is_text_, big_endian_;
    std::string_view data_;
};

constexpr const char* ply_grid = "range_grid";  // says for each pixel which point is there, if one is

/// Whether the file has a point for each pixel, or a grid that says which pixel has which point.
bool has_ply_grid(const PlyHeader& header) {
    const PlyElement *const vertices = header.element("vertex"), *const grid = header.element(ply_grid),
                            *const faces = header.element("face");
    if (header.width < 2 || header.height < 2 || vertices == nullptr || (faces && faces->count > 0))
        return false;
    return (grid ? grid : vertices)->count == header.width * header.height;
}

Result<OrganisedCloud> decode_ply(std::string_view bytes, const std::string& where) {
    const auto header = ply_header(bytes);
    if (!header || !has_ply_grid(*header))
        return input_error(where +
                           ": is damaged: its header is not that of a PLY file with rows and columns");
    TRY(check_picture_size(static_cast<std::int64_t>(header->width),
                           static_cast<std::int64_t>(header->height), where));
    if (header->format != "ascii" && !header->format.starts_with("binary_"))
        return input_error(where + ": its format is " + in_quotes(header->format) +
                           ": must be ascii, binary_little_endian or binary_big_endian");
    const PlyElement& vertices = *header->element("vertex");
    const PlyElement* const grid = header->element(ply_grid);
    const auto x = vertices.place_of({"x"}), y = vertices.place_of({"y"}), z = vertices.place_of({"z"});
    if (!x || !y || !z) return input_error(where + ": its points have no x, y and z");
    const std::optional<std::size_t> colours[] = {vertices.place_of({"red", "r", "diffuse_red"}),
                                                  vertices.place_of({"green", "g", "diffuse_green"}),
                                                  vertices.place_of({"blue", "b", "diffuse_blue"})};
    const bool has_colour = colours[0] && colours[1] && colours[2];
    const std::string_view data = bytes.substr(header->end);
    // A number takes at least a byte; in text two: a digit and a separator.
    const std::uint64_t least = header->format == "ascii" ? 2 : 1,
                        numbers_stated = vertices.count * vertices.properties.size();
    if (numbers_stated * least > data.size() + 1 || (grid && grid->count * least > data.size() + 1))
        return cut_short(where);
    CloudPicture picture(static_cast<int>(header->width), static_cast<int>(header->height), has_colour);
    struct Point {
        float x, y, z;
        std::array<std::uint8_t, 3> rgb{};
    };
    std::vector<Point> points;  // if a grid says which is where
    const auto place = [&](std::size_t pixel, const Point& point) {
        picture.put(pixel, double{point.x}, double{point.y}, double{point.z});
        if (has_colour) picture.paint(pixel, point.rgb);
    };
    const auto take_point = [&](std::size_t k, const std::vector<double>& numbers) {
        Point point{static_cast<float>(numbers[*x]), static_cast<float>(numbers[*y]),
                    static_cast<float>(numbers[*z])};
        for (std::size_t channel = 0; has_colour && channel < 3; ++channel) {
            const Scalar& scalar = vertices.properties[*colours[channel]].scalar;
            const double whole = scalar.kind == 'F' ? 1 : scalar.bytes == 2 ? 65535 : 255;
            const double share = numbers[*colours[channel]] / whole;
            point.rgb[channel] =
                share > 0 ? static_cast<std::uint8_t>(255 * std::min(share, 1.0) + 0.5) : std::uint8_t{0};
        }
        if (grid)
            points.push_back(point);
        else
            place(k, point);
    };
    PlyNumbers source(header->format, data);
    std::vector<double> numbers;
    for (const PlyElement& element : header->elements) {
        if (element.properties.empty()) continue;
        for (std::size_t k = 0; k < element.count; ++k) {
            if (!source.take(element, numbers)) return cut_short(where);
            if (&element == &vertices) take_point(k, numbers);
            if (&element != grid || std::isnan(numbers.front())) continue;
            if (!(numbers.front() >= 0 && numbers.front() < static_cast<double>(points.size())))
                return input_error(where + ": is damaged: pixel " + std::to_string(k) + " has point " +
                                   short_number(numbers.front()) + " of " + std::to_string(points.size()));
            place(k, points[static_cast<std::size_t>(numbers.front())]);
        }
        if (&element == (grid ? grid : &vertices)) break;
    }
    return std::move(picture).finish("PLY", where);
}

bool is_ply(std::string_view begin) {
    return begin.starts_with("ply\n") || begin.starts_with("ply\r\n");
}
bool is_pcd(std::string_view begin) {
    return begin.starts_with("# .PCD") || begin.starts_with("VERSION ");
}

}  // namespace

bool is_named_cloud(const std::filesystem::path& file) {
    const std::string extension = small_letters(file.extension().string());
    return extension == ".pcd" || extension == ".ply";
}

bool begins_organised_cloud(std::string_view begin) {
    if (is_ply(begin)) {
        const auto header = ply_header(begin);
        return header && has_ply_grid(*header);
    }
    const auto header = is_pcd(begin) ? pcd_header(begin) : std::nullopt;
    return header && header->width > 1 && header->height > 1;
}

bool is_organised_cloud(const SourceFile& file) {
    const std::string begin = first_bytes(file, 8);
    return (is_ply(begin) || is_pcd(begin)) &&
           begins_organised_cloud(first_bytes(file, largest_cloud_header));
}

Result<OrganisedCloud> decode_organised_cloud(std::string_view bytes, const std::string& where) {
    return is_ply(bytes) ? decode_ply(bytes, where) : decode_pcd(bytes, where);
}

}  // namespace touchable
