// SPDX-License-Identifier: Apache-2.0
// Pictures in HDF5 files, which MATLAB's 7.3 files are, too.
//
// HDF5's library is known to crash on hostile files, so this program does not link it: h5ls and h5dump
// (Debian's hdf5-tools) read a file in a process of their own, with limits of memory and time. h5ls lists the
// data sets, one of them is chosen as depth, and h5dump gives its numbers, some pictures at a time.
#include <algorithm>
#include <bit>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "engine/base/child_process.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"

namespace touchable {
namespace {

constexpr std::string_view hdf5_magic = "\x89HDF\r\n\x1a\n", matlab_magic = "MATLAB 7.3 MAT-file";
constexpr std::size_t largest_listing = std::size_t{64} << 20;
constexpr std::uint64_t largest_hdf5_picture = std::uint64_t{257} << 20;  // as read_picture_bytes has it
constexpr std::uint64_t bytes_at_once = std::uint64_t{8} << 20;
/// Of a larger chunk h5dump keeps nothing: it unpacks the whole chunk again for each row.
constexpr std::uint64_t largest_kept_chunk = std::uint64_t{1} << 20;

// --- The tools

/// The output of a tool. `words`: its name, options and the file.
Result<std::string> ask_tool(std::vector<std::string> words, std::uint64_t most) {
    // Load no plugin, which a file could ask for; take no lock, which some disks do not support.
    const std::vector<std::string> settings{"HDF5_PLUGIN_PRELOAD=::", "HDF5_USE_FILE_LOCKING=FALSE",
                                            "LC_ALL=C"};
    constexpr ChildLimits limits{std::uint64_t{1} << 30, 60};
    const std::string name = words.front();
    TRY_ASSIGN(const auto tool, ChildProcess::start(std::move(words), limits, settings));
    if (!tool) return input_error("is HDF5, which needs h5dump: install the package hdf5-tools");
    auto output = tool->all_output(most);
    if (output || output.error().kind != ErrorKind::input) return output;
    const std::string how = name + " " + output.error().message;
    if (output.error().cause == Error::Cause::out_of_time) return input_error(how);
    return input_error("is damaged, or more than HDF5's tools can read: " + how);
}

// --- The listing

/// Takes a path as h5ls writes it off the front: up to the first blank without a backslash. Empty: there is
/// none.
std::string take_path(std::string_view& line) {
    constexpr std::string_view letters = "bfnrt", meant = "\b\f\n\r\t";
    std::string path;
    std::size_t at = 0;
    for (; at < line.size() && line[at] != ' '; ++at) {
        if (line[at] != '\\' || at + 1 == line.size()) {
            path += line[at];
            continue;
        }
        const std::string_view digits = line.substr(at + 1, 3);
        if (const auto code = parsed_as<unsigned>(digits, 8); code && digits.size() == 3) {
            path += static_cast<char>(*code);
            at += 3;
            continue;
        }
        const auto letter = letters.find(line[++at]);
        path += letter == std::string_view::npos ? line[at] : meant[letter];
    }
    line.remove_prefix(std::min(at + 1, line.size()));
    return path;
}

/// "{2/2, 80/Inf, 60/60}": the extents that there are, each with the largest that there may be.
std::optional<std::vector<std::int64_t>> extents_of(std::string_view text) {
    std::vector<std::int64_t> extents;
    if (text == "{SCALAR") return extents;
    while (!text.empty()) {
        std::int64_t extent = 0;
        const auto [end, failure] = std::from_chars(text.data() + 1, text.data() + text.size(), extent);
        if (failure != std::errc() || extent < 0 || extent > std::int64_t{1} << 31 || extents.size() == 32)
            return std::nullopt;
        extents.push_back(extent);
        const std::size_t next = text.find(' ', static_cast<std::size_t>(end - text.data()));
        text.remove_prefix(std::min(next, text.size()));
    }
    return extents;
}

std::string numbers_in_row(const std::vector<std::int64_t>& all) {
    return listed(
        all, [](std::int64_t each) { return std::to_string(each); }, ",");
}

/// The format of a type in h5ls's words, one line or several. Nullopt: it is not numbers of whole bytes.
std::optional<NumberFormat> format_of_type(std::string_view type) {
    using Kind = NumberFormat::Kind;
    constexpr bool is_big = std::endian::native == std::endian::big;
    constexpr std::pair<std::string_view, NumberFormat> native[] = {
        {"signed char", {Kind::signed_integer, 1}},
        {"unsigned char", {Kind::unsigned_integer, 1}},
        {"short", {Kind::signed_integer, sizeof(short), is_big}},
        {"unsigned short", {Kind::unsigned_integer, sizeof(short), is_big}},
        {"int", {Kind::signed_integer, sizeof(int), is_big}},
        {"unsigned int", {Kind::unsigned_integer, sizeof(int), is_big}},
        {"long", {Kind::signed_integer, sizeof(long), is_big}},
        {"unsigned long", {Kind::unsigned_integer, sizeof(long), is_big}},
        {"long long", {Kind::signed_integer, sizeof(long long), is_big}},
        {"unsigned long long", {Kind::unsigned_integer, sizeof(long long), is_big}},
        {"_Float16", {Kind::floating, 2, is_big}},
        {"float", {Kind::floating, sizeof(float), is_big}},
        {"double", {Kind::floating, sizeof(double), is_big}}};
    if (type.starts_with("shared-")) type.remove_prefix(std::min(type.find(' '), type.size() - 1) + 1);
    if (type.starts_with("native ")) {
        for (const auto& [name, format] : native)
            if (name == type.substr(7)) return format;
        return std::nullopt;
    }
    // What versions before 1.14.4 say of a half float, with the places of its bits.
    constexpr std::string_view half_bits =
        "\n(significant for 10 bits at bit 0, msb implied)\n(exponent for 5 bits at bit 10, bias is 0xf)"
        "\n(sign bit at 15)";
    for (const bool big : {false, true}) {
        const std::string order = big ? "-bit big-endian" : "-bit little-endian";
        if (type == "16" + order + " floating-point" + std::string(half_bits))
            return NumberFormat{Kind::floating, 2, big};
        for (const int bytes : {1, 2, 4, 8}) {
            const std::string bits = std::to_string(8 * bytes), of = bits + (bytes == 1 ? "-bit" : order);
            if (type == of + " integer") return NumberFormat{Kind::signed_integer, bytes, big};
            if (type == of + " unsigned integer") return NumberFormat{Kind::unsigned_integer, bytes, big};
            if (bytes > 1 && type == "IEEE " + of + " float") return NumberFormat{Kind::floating, bytes, big};
        }
    }
    return std::nullopt;
}

// --- The data set that is depth

/// Excludes "#refs#", to which MATLAB refers.
std::vector<NamedArray> named_arrays(const std::vector<Hdf5DataSet>& sets) {
    std::vector<NamedArray> arrays;
    for (const Hdf5DataSet& set : sets)
        arrays.push_back({set.path, set.shape,
                          set.is_elsewhere || set.path.starts_with("/#") ? std::nullopt : set.format});
    return arrays;
}

Result<std::vector<Hdf5DataSet>> chosen(const std::vector<Hdf5DataSet>& all) {
    const auto arrays = named_arrays(all);
    TRY_ASSIGN(const auto places, depth_among(arrays, "data set"));
    if (places.empty())
        return input_error(
            "is an HDF5 file without a data set of pictures of depth (height x width, or count x height x "
            "width): it has " +
            (all.empty() ? "none" : some_of(arrays)));
    std::vector<Hdf5DataSet> sets;
    for (const std::size_t place : places) sets.push_back(all[place]);
    return sets;
}

/// The data set of this name, with or without the slash before it.
Result<std::vector<Hdf5DataSet>> named(const std::vector<Hdf5DataSet>& all, const std::string& name) {
    const std::string path = name.starts_with('/') ? name : '/' + name;
    const auto found = std::ranges::find(all, path, &Hdf5DataSet::path);
    if (found == all.end())
        return input_error("has no data set " + in_quotes(name) + ", but " +
                               (all.empty() ? "none at all" : some_of(named_arrays(all))),
                           {{Setting::dataset, "NAME"}});
    if (found->is_elsewhere)
        return input_error(printable(path) + ": has its numbers in other files, which are not read");
    if (!found->format)
        return input_error(printable(path) + ": is of the type " + in_quotes(found->type) +
                           ": must be integers or floats of 8 to 64 bits");
    TRY(pictures_of_array(found->shape, printable(path)));
    return std::vector{*found};
}

/// Lists other data sets of the same shape that are named depth as well, and of colour.
std::string other_depths(const std::vector<Hdf5DataSet>& all, const Hdf5DataSet& read) {
    std::vector<std::string> names;
    for (const NamedArray& array : named_arrays(all))
        if (is_colour(array) || (array.name != read.path && array.shape == read.shape &&
                                 has_depth_in_name(array) && may_be_depth(array)))
            names.push_back(printable(array.name));
    if (names.empty()) return "";
    return "depth is the data set " + printable(read.path) + "; left out: " + printable(listed(names), 200);
}

/// Adds the data sets and attributes of numbers that h5dump prints, by the last part of their names, and
/// robomimic's rate, which is in an attribute of JSON.
void add_printed(std::string_view text, std::vector<SmallArray>& arrays) {
    while (!text.empty() && arrays.size() <= most_small_arrays) {
        std::string_view line = trimmed(cut_line(text));
        if (line.starts_with("DATASET \"") || line.starts_with("ATTRIBUTE \"")) {
            if (!arrays.empty() && arrays.back().numbers.empty()) arrays.pop_back();
            line = line.substr(0, line.rfind('"'));
            arrays.push_back({std::string(line.substr(line.find_last_of("\"/") + 1)), {}, {}});
        }
        constexpr std::string_view rate = "\"control_freq\":";
        if (const auto begin = line.find(rate), end = line.find_first_of(",}", begin); end < line.size()) {
            const auto hertz = line.substr(begin + rate.size(), end - begin - rate.size());
            arrays.push_back({"control_freq", {}, {parsed_number(trimmed(hertz)).value_or(0)}});
            continue;
        }
        if (arrays.empty() || !line.starts_with('(')) continue;
        for (std::size_t at = line.find(": "); at < line.size(); at = line.find(',', at + 1))  // (0,0): 1, 2,
            if (const auto number =
                    parsed_number(trimmed(line.substr(at + 1, line.find(',', at + 1) - at - 1))))
                arrays.back().numbers.push_back(*number);
    }
}

// --- Its pictures

class Hdf5Stack final : public ImageStack {
public:
    /// `sets`: one, or several of one picture each. `pictures`: as stored. `is_turned`: MATLAB's, which
    /// stores its last index first: rows become columns.
    Hdf5Stack(SourceFile file, std::vector<Hdf5DataSet> sets, const ArrayPictures& pictures, bool is_turned,
              std::string left_out, std::vector<Hdf5DataSet> others)
        : ImageStack(file.string() + ": " + printable(sets.front().path), std::move(left_out)),
          file_(std::move(file)),
          path_(std::filesystem::absolute(file_.path()).string()),
          sets_(std::move(sets)),
          others_(std::move(others)),
          pictures_(pictures),
          is_turned_(is_turned) {
        array_ = sets_.front().path.substr(sets_.front().path.rfind('/') + 1);
    }

    std::int64_t count() const override { return is_row() ? std::ssize(sets_) : pictures_.count; }
    int width() const override { return is_turned_ ? pictures_.height : pictures_.width; }
    /// Read when asked for, as they take processes.
    std::span<const SmallArray> small_arrays() override {
        if (std::exchange(has_read_others_, true)) return small_arrays_;
        // Depth's own group has the longest beginning in common.
        std::ranges::stable_sort(others_, std::greater(), [&](const Hdf5DataSet& set) {
            return std::ranges::mismatch(set.path, sets_.front().path).in1 - set.path.begin();
        });
        std::vector<std::string> words{"h5dump", "-m", "%.17g"};
        for (const Hdf5DataSet& set : others_) {
            const double count = std::accumulate(set.shape.begin(), set.shape.end(), 1.0, std::multiplies());
            if (set.format && !set.is_elsewhere && count <= double{most_small_numbers} &&
                words.size() < 2 * most_small_arrays)
                words.insert(words.end(), {"-d", set.path});
        }
        words.push_back(path_);
        for (const auto& asked : {words, {"h5dump", "-m", "%.17g", "-A", path_}})
            if (asked.size() > 4)
                if (const auto printed = ask_tool(asked, largest_listing))
                    add_printed(*printed, small_arrays_);
        return small_arrays_;
    }
    int height() const override { return is_turned_ ? pictures_.width : pictures_.height; }

    /// Call first. Refuses more data than the file can hold.
    Result<void> check() {
        if (picture_bytes() > largest_hdf5_picture)
            return input_error(where_ + ": has pictures of " + std::to_string(picture_bytes()) +
                               " bytes: must be " + in_bytes(largest_hdf5_picture) + " at most");
        TRY_ASSIGN(const auto bytes, bytes_of_file(file_));
        TRY(check_expansion(picture_bytes() * static_cast<std::uint64_t>(count()), bytes->size(), where_));
        return format().is_decided() ? Result<void>{} : find_floats();
    }

private:
    bool is_row() const { return sets_.size() > 1; }
    const NumberFormat& format() const { return *sets_.front().format; }
    std::string where(std::int64_t number) const {
        return file_.string() + ": " + printable(set_of(number).path);
    }
    const Hdf5DataSet& set_of(std::int64_t number) const {
        return sets_[is_row() ? static_cast<std::size_t>(number) : 0];
    }
    std::uint64_t picture_bytes() const {
        return pixel_count(pictures_.width, pictures_.height) * static_cast<std::uint64_t>(format().bytes);
    }

    /// Pictures are read in blocks that begin at multiples of their length, so that playing backward reads no
    /// more blocks.
    Result<StoredImage> read(std::int64_t number, bool floats_anyway) override {
        const auto fit = static_cast<std::int64_t>(bytes_at_once / picture_bytes());
        const auto together = is_row() ? 1 : std::max(std::int64_t{1}, fit);
        const std::int64_t first = number - number % together;
        if (first != block_first_) {
            const std::int64_t pictures = std::min(together, count() - first);
            block_first_ = -1;
            TRY_ASSIGN(block_, numbers(first, pictures));
            block_first_ = first;
        }
        const int bytes = format().bytes, line = bytes * pictures_.width;
        const char* const numbers =
            block_.data() + static_cast<std::uint64_t>(number - first) * picture_bytes();
        NumberPicture picture(width(), height(), format());
        if (is_turned_)
            picture.put(0, 0, {numbers, width(), height(), line, bytes});
        else
            picture.put(0, 0, {numbers, width(), height(), bytes, line});
        return std::move(picture).finish("hdf5", floats_anyway);
    }

    /// The command that writes the file anew with chunks of a picture, or of as many rows as h5dump keeps.
    std::string repack_words(const Hdf5DataSet& set) const {
        std::vector<std::int64_t> chunk = set.shape;
        const auto is_several = [](std::int64_t extent) { return extent > 1; };
        if (pictures_.count > 1) *std::ranges::find_if(chunk, is_several) = 1;
        if (const auto rows = std::ranges::find_if(chunk, is_several); rows != chunk.end())
            *rows = std::clamp<std::int64_t>(
                largest_kept_chunk * static_cast<std::uint64_t>(*rows) / picture_bytes(), 1, *rows);
        return "h5repack -l " + shell_word(set.path + ":CHUNK=" + shape_text(chunk)) + ' ' +
               shell_word(file_.string()) + " repacked.h5";
    }

    /// The stored numbers of `pictures` pictures from `first` on.
    Result<std::string> numbers(std::int64_t first, std::int64_t pictures) const {
        const Hdf5DataSet& set = set_of(first);
        std::vector<std::int64_t> start(set.shape.size()), extents = set.shape;
        // Extents before the count of pictures are 1.
        const auto counts = std::ranges::find_if(extents, [](std::int64_t extent) { return extent > 1; });
        if (pictures_.count > 1) {
            start[static_cast<std::size_t>(counts - extents.begin())] = first;
            *counts = pictures;
        }
        const std::uint64_t expected = picture_bytes() * static_cast<std::uint64_t>(pictures);
        auto output =
            ask_tool({"h5dump", "--no-compact-subset", "-d", set.path, "-s", numbers_in_row(start), "-c",
                      numbers_in_row(extents), "-b", "FILE", "-O", "/dev/null", "-o", "/dev/stdout", path_},
                     expected);
        if (!output) {
            Error failed = error_at(where(first), output.error());
            if (!set.packed_by.empty() && failed.kind == ErrorKind::input)
                failed.message += " (it is packed by " + printable(set.packed_by) + ")";
            if (set.chunk_bytes > largest_kept_chunk && failed.kind == ErrorKind::input)
                failed.message += "; it has chunks of " + std::to_string(set.chunk_bytes) +
                                  " bytes, and must have smaller ones: " + repack_words(set);
            return failed;
        }
        if (output->size() != expected)
            return input_error(where(first) + ": is damaged: h5dump gives " + std::to_string(output->size()) +
                               " bytes of " + std::to_string(expected));
        return output;
    }

    SourceFile file_;
    std::string path_;
    std::vector<Hdf5DataSet> sets_, others_;
    bool has_read_others_ = false;
    ArrayPictures pictures_;
    bool is_turned_;
    std::string block_;  // pictures from block_first_ on
    std::int64_t block_first_ = -1;
};

}  // namespace

bool is_hdf5(std::string_view begin) {
    const std::size_t known = std::min(begin.size(), matlab_magic.size());
    return begin.starts_with(hdf5_magic) ||
           (known >= 8 && begin.substr(0, known) == matlab_magic.substr(0, known));
}

Result<std::vector<Hdf5DataSet>> hdf5_data_sets(std::string_view listing) {
    std::vector<Hdf5DataSet> sets;
    std::set<std::string> paths, groups;
    Hdf5DataSet* set = nullptr;  // described by the next lines
    bool is_in_type = false;
    for (std::string_view rest = listing; !rest.empty();) {
        std::string_view line = cut_line(rest);
        if (line.starts_with('/')) {
            const std::string path = take_path(line);
            const std::string_view what = trimmed(line);
            // A name or a filter's name with a line break could fake a data set in the listing.
            const bool is_listed = path == "/" || groups.contains(path.substr(0, path.rfind('/')));
            if (!is_listed || !paths.insert(path).second)
                return input_error("is damaged: h5ls lists " + in_quotes(path) + " where it cannot be");
            if (what == "Group") groups.insert(path == "/" ? "" : path);
            set = nullptr;
            if (!what.starts_with("Dataset {") || !what.ends_with('}')) continue;
            auto shape = extents_of(what.substr(8, what.size() - 9));
            if (!shape) continue;  // no array: NULL
            set = &sets.emplace_back(Hdf5DataSet{path, std::move(*shape)});
        } else if (set && (line.starts_with("    Extern:") || line.starts_with("    Maps:"))) {
            set->is_elsewhere = true;
        } else if (set && line.starts_with("    Chunks:")) {
            const std::string_view bytes = line.substr(std::min(line.find("} "), line.size() - 2) + 2);
            (void)std::from_chars(bytes.data(), bytes.data() + bytes.size(), set->chunk_bytes);
        } else if (set && line.starts_with("    Filter-")) {
            const std::string_view filter =
                trimmed(line.substr(std::min(line.find(':'), line.size() - 1) + 1));
            set->packed_by +=
                (set->packed_by.empty() ? "" : ", ") + std::string(filter.substr(0, filter.find(' ')));
        } else if (set && line.starts_with("    Type:")) {
            set->type = trimmed(line.substr(9));
            is_in_type = true;
            continue;
        } else if (set && is_in_type && line.starts_with("               ")) {
            set->type += '\n' + std::string(trimmed(line));
            continue;
        }
        is_in_type = false;
    }
    for (Hdf5DataSet& each : sets) each.format = format_of_type(each.type);
    return sets;
}

Result<std::shared_ptr<ImageStack>> open_hdf5_stack(const SourceFile& file, const std::string& dataset) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file.path(), ignored))
        return input_error(file.string() + ": is HDF5 on a server: must be a file of this machine");
    const std::string path = std::filesystem::absolute(file.path()).string();
    TRY_ASSIGN(const auto listing,
               error_at(file.string(), ask_tool({"h5ls", "-r", "-v", path}, largest_listing)));
    TRY_ASSIGN(auto sets, error_at(file.string(), hdf5_data_sets(listing)));
    TRY_ASSIGN(auto read, error_at(file.string(), dataset.empty() ? chosen(sets) : named(sets, dataset)));
    TRY_ASSIGN(const auto pictures, pictures_of_array(read.front().shape, file.string()));
    std::string left_out =
        dataset.empty() && read.size() == 1 ? other_depths(sets, read.front()) : std::string();
    const bool is_matlab = first_bytes(file, matlab_magic.size()) == matlab_magic;
    auto stack = std::make_shared<Hdf5Stack>(file, std::move(read), pictures, is_matlab, std::move(left_out),
                                             std::move(sets));
    TRY(stack->check());
    return std::shared_ptr<ImageStack>(std::move(stack));
}

bool is_hdf5_file(const SourceFile& file) {
    return picture_kind(first_bytes(file, matlab_magic.size())) == "HDF5";
}

Result<StoredImage> refuse_hdf5(std::string_view, const std::string& where) {
    return input_error(where + ": is HDF5, which is read as a file of depth alone, not here");
}

}  // namespace touchable
