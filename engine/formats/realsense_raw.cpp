// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/formats_read.hpp"
#include "engine/formats/picture_files.hpp"

#include <charconv>
#include <cmath>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/sidecar_text.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view metadata_ending = "_metadata.csv", snapshot_ending = "_Depth.raw";

/// The number in the row of a name: "Fx,105.75".
Result<double> number_of_row(std::string_view table, const std::string& name, const std::string& where) {
    const auto text = line_after(table, name + ',');
    double number = 0;
    const bool is_read =
        text && std::from_chars(text->data(), text->data() + text->size(), number).ec == std::errc();
    if (is_read && std::isfinite(number)) return number;
    return input_error(where + ": has no row \"" + name + ",NUMBER\"");
}

bool is_snapshot(const fs::path& file) {
    return file.filename().string().ends_with(snapshot_ending) && realsense_metadata_of(file);
}

}  // namespace

std::optional<fs::path> realsense_metadata_of(const fs::path& raw) {
    if (small_letters(raw.extension().string()) != ".raw") return {};
    fs::path metadata = raw.parent_path() / (raw.stem().string() + std::string(metadata_ending));
    return is_file(metadata) ? std::optional(std::move(metadata)) : std::nullopt;
}

std::optional<fs::path> realsense_snapshot_in(const fs::path& folder) {
    constexpr std::size_t most_entries = 1000;
    std::optional<fs::path> found;
    std::size_t entries = 0;
    std::error_code failure;
    for (fs::directory_iterator at(folder, failure), end; !failure && at != end; at.increment(failure)) {
        if (++entries > most_entries) return {};
        if (!is_snapshot(at->path())) continue;
        if (found) return {};
        found = at->path();
    }
    if (!found) return {};
    // A folder with other depth pictures is opened for these, not for a snapshot among them.
    std::string own = found->filename().string();
    own.resize(own.size() - snapshot_ending.size());
    const auto is_other_depth = [&](const PictureGroup& group) {
        return has_word(group.pattern, {"depth"}) && !group.pattern.starts_with(own);
    };
    return std::ranges::any_of(picture_groups(folder), is_other_depth) ? std::nullopt : found;
}

Result<Intrinsics> parse_realsense_metadata(std::string_view text, const std::string& where) {
    const auto format = line_after(text, "Format,");
    if (format != "Z16")
        return input_error(where + ": must have a row \"Format,Z16\", as depth has" +
                           (format ? ", not " + in_quotes(*format) : ""));
    TRY_ASSIGN(const double width, number_of_row(text, "Resolution x", where));
    TRY_ASSIGN(const double height, number_of_row(text, "Resolution y", where));
    constexpr double most = 1e6;  // a side fits an int; a picture's limit is lower
    const auto side = [&](double number) { return static_cast<int>(std::clamp(number, 0.0, most)); };
    TRY(check_picture_size(side(width), side(height), where));
    Intrinsics camera{.width = side(width), .height = side(height)};
    TRY_ASSIGN(camera.fx, number_of_row(text, "Fx", where));
    TRY_ASSIGN(camera.fy, number_of_row(text, "Fy", where));
    TRY_ASSIGN(camera.cx, number_of_row(text, "PPx", where));
    TRY_ASSIGN(camera.cy, number_of_row(text, "PPy", where));
    if (!(camera.fx > 0) || !(camera.fy > 0))
        return input_error(where + ": its focal lengths Fx and Fy must be above 0");
    return camera;
}

Result<Intrinsics> read_realsense_metadata(const fs::path& metadata) {
    constexpr std::size_t largest = std::size_t{64} << 10;
    TRY_ASSIGN(const auto text, SourceFile(metadata).read("metadata of the RealSense Viewer", largest));
    return parse_realsense_metadata(text, metadata.string());
}

Result<StoredImage> read_realsense_raw(const SourceFile& raw) {
    const auto metadata = realsense_metadata_of(raw.path());
    if (!metadata)
        return input_error(raw.string() + ": has no " + raw.path().stem().string() +
                           std::string(metadata_ending) + " beside it, which says how large its picture is");
    TRY_ASSIGN(const auto camera, read_realsense_metadata(*metadata));
    TRY_ASSIGN(const auto bytes, read_picture_bytes(raw));
    const std::size_t needed = 2 * pixel_count(camera.width, camera.height);
    if (bytes.size() != needed)
        return input_error(raw.string() + ": has " + std::to_string(bytes.size()) + " bytes: must be " +
                           std::to_string(needed) + " for the " + size_text(camera.width, camera.height) +
                           " pixels of 16 bits that " + metadata->filename().string() + " states");
    StoredImage picture{{camera.width, camera.height, 2, 1, {}}, "raw", "gray16le"};
    picture.bits = 16;
    picture.image.samples.assign(bytes.begin(), bytes.end());
    return picture;
}

}  // namespace touchable
