#include "engine/formats/picture_roles.hpp"

#include <algorithm>
#include <iterator>

#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/far_plane.hpp"
#include "engine/formats/value_estimator.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

using SharedPicture = std::shared_ptr<const StoredImage>;

Error interrupted_reading(const fs::path& file) {
    return {ErrorKind::interrupted, "interrupted while " + file.string() + " was read"};
}

/// Colour that is grey everywhere as grey.
Result<SharedPicture> as_depth(SharedPicture stored, const fs::path& file) {
    if (!stored->values.empty() || stored->image.channels == 1) return stored;
    auto grey = as_grey(stored->image);
    if (stop_requested()) return interrupted_reading(file);
    if (!grey)
        return input_error(file.string() +
                           ": is in colour: a picture of depth is grey (of depth as hue, give a scene file)");
    const StoredImage& of = *stored;
    return std::make_shared<const StoredImage>(
        StoredImage{std::move(*grey), of.codec, of.pixel_format, of.bits, of.interlaced, {}, of.beside});
}

/// Of a picture, or the first of a stack.
Result<SharedPicture> depth_in(const fs::path& file, ReadPictures& pictures) {
    auto looked = pictures.look(file);
    return looked ? as_depth(std::move(*looked), file) : looked;
}

Result<SharedPicture> depth_of(Result<StoredImage> read, const fs::path& file) {
    if (!read) return read.error();
    return as_depth(std::make_shared<const StoredImage>(std::move(*read)), file);
}

/// Whether it has a value; nothing where it is asked to stop before that is known.
Result<bool> holds_values(const StoredImage& picture, const fs::path& file) {
    const bool any = estimate_values(picture).any;
    return stop_requested() ? Result<bool>(interrupted_reading(file)) : any;
}

/// How well a group goes as depth: 0 not at all.
int depth_mark(const PictureGroup& group, ReadPictures& pictures) {
    if (has_word(group.pattern, {"conf", "mask", "label", "normal", "haptic", "height"})) return 0;
    const auto looked = pictures.look(group.first);
    if (!looked) return 0;
    const StoredImage& first = **looked;
    if (first.values.empty() && !is_grey(first.image)) return 0;
    const bool is_deep = !first.values.empty() || first.image.bytes_per_sample == 2;
    return (has_word(group.pattern, {"depth", "disp", "range", "dpt"}) ? 4 : 0) + (is_deep ? 2 : 0);
}

bool is_in_colour(const StoredImage& picture) {
    return picture.values.empty() && picture.image.channels == 3 && picture.image.bytes_per_sample == 1;
}

bool goes_as_colour(const PictureGroup& group, const PictureGroup& depth, ReadPictures& pictures) {
    if (group.pattern == depth.pattern ||
        has_word(group.pattern,
                 {"conf", "mask", "label", "normal", "haptic", "height", "depth", "disp", "ultrawide"}))
        return false;
    const auto looked = pictures.look(group.first);
    if (!looked) return false;
    const StoredImage& first = **looked;
    if (!first.values.empty() || first.image.bytes_per_sample != 1) return false;
    return is_in_colour(first) ||
           has_word(group.pattern, {"rgb", "color", "colour", "image", "grey", "gray"});
}

std::string found_there(const std::vector<PictureGroup>& groups) {
    std::string words;
    for (std::size_t n = 0; n < std::min<std::size_t>(groups.size(), 4); ++n)
        words += (n == 0 ? "" : ", ") + std::to_string(groups[n].count) + " x " + groups[n].pattern;
    return words.empty() ? "no pictures" : words + (groups.size() > 4 ? ", ..." : "");
}

}  // namespace

Result<std::shared_ptr<const StoredImage>> telling_depth(const std::vector<fs::path>& files,
                                                         ReadPictures& pictures) {
    auto first = depth_in(files.front(), pictures);
    if (!first) return first;
    if (const auto any = holds_values(**first, files.front()); !any || *any)
        return any ? first : Result<SharedPicture>(any.error());
    TRY_ASSIGN(const auto stack, pictures.stack_in(files.front()));
    const bool is_stack = files.size() == 1 && stack;
    for (const std::int64_t n : telling_frames(is_stack ? stack->count() : std::ssize(files))) {
        if (stop_requested()) return interrupted_reading(files.front());
        const fs::path& file = files[is_stack ? 0 : static_cast<std::size_t>(n)];
        auto stored = is_stack ? depth_of(stack->image(n), file) : depth_in(file, pictures);
        const bool is_alike = stored && (*stored)->image.width == (*first)->image.width &&
                              (*stored)->image.height == (*first)->image.height;
        if (!is_alike) continue;
        if (const auto any = holds_values(**stored, file); !any || *any)
            return any ? stored : Result<SharedPicture>(any.error());
    }
    return first;
}

std::optional<fs::path> colour_beside(const fs::path& depth, ReadPictures& pictures) {
    const std::string stem = depth.stem().string();
    std::vector<std::string> stems{stem};
    for (const char* of_depth : {"depth", "Depth", "disp0", "disparity"})
        if (const auto at = stem.find(of_depth); at != std::string::npos)
            for (const char* of_colour : {"color", "colour", "rgb", "image", "Color", "im0"})
                stems.push_back(std::string(stem).replace(at, std::string(of_depth).size(), of_colour));
    for (const std::string& other : stems)
        for (const char* extension : {".png", ".jpg", ".jpeg", ".ppm"}) {
            const fs::path file = depth.parent_path() / (other + extension);
            std::error_code ignored;
            if (file == depth || !fs::is_regular_file(file, ignored)) continue;
            if (const auto picture = pictures.look(file); picture && is_in_colour(**picture)) return file;
        }
    return {};
}

Error interrupted_looking(const fs::path& folder) {
    return {ErrorKind::interrupted, "interrupted while " + folder.string() + " was looked through"};
}

Result<std::vector<PictureGroup>> readable_groups(const fs::path& folder, ReadPictures& pictures) {
    std::vector<PictureGroup> groups = picture_groups(folder);
    constexpr std::size_t most_groups = 200;  // the largest are first, and each is looked at
    if (groups.size() > most_groups) groups.resize(most_groups);
    for (const PictureGroup& group : groups) {
        if (stop_requested()) return interrupted_looking(folder);
        if (!has_word(group.pattern, {"depth"})) continue;
        TRY(pictures.look(group.first));
    }
    return groups;
}

std::vector<const PictureGroup*> depths_among(const std::vector<PictureGroup>& groups,
                                              ReadPictures& pictures) {
    std::vector<const PictureGroup*> best;
    int highest = 1;
    for (const PictureGroup& group : groups) {
        const int mark = depth_mark(group, pictures);
        if (mark > highest) best.clear();
        highest = std::max(highest, mark);
        if (mark == highest) best.push_back(&group);
    }
    return best;
}

std::vector<const PictureGroup*> greys_among(const std::vector<PictureGroup>& groups,
                                             ReadPictures& pictures) {
    std::vector<const PictureGroup*> greys;
    for (const PictureGroup& group : groups) {
        if (has_word(group.pattern, {"conf", "mask", "label", "normal", "haptic", "height", "rgb", "color",
                                     "colour", "infra"}))
            continue;
        const auto looked = pictures.look(group.first);
        if (looked && (*looked)->values.empty() && is_grey((*looked)->image)) greys.push_back(&group);
    }
    return greys;
}

const PictureGroup* colour_among(const std::vector<PictureGroup>& groups,
                                 const std::vector<const PictureGroup*>& depths, ReadPictures& pictures) {
    const PictureGroup& depth = *depths.front();
    const PictureGroup* elsewhere = nullptr;
    for (const PictureGroup& group : groups) {
        if (!goes_as_colour(group, depth, pictures) || (group.count == 1) != (depth.count == 1)) continue;
        const std::string folder = folder_of(group);
        if (folder == folder_of(depth)) return &group;
        const bool is_of_another = std::any_of(depths.begin(), depths.end(), [&](const PictureGroup* other) {
            return folder_of(*other) == folder;
        });
        if (elsewhere == nullptr && !is_of_another) elsewhere = &group;
    }
    return elsewhere;
}

bool is_list_of_depth(const std::string& pattern) {
    return pattern.ends_with(".txt");
}

std::string left_out(const std::vector<const PictureGroup*>& depths) {
    const PictureGroup& depth = *depths.front();
    const bool is_listed = is_list_of_depth(depth.pattern);
    std::string names;
    std::vector<std::string> told;
    for (const PictureGroup* other : depths) {
        if (other == &depth || (is_listed && other->first.parent_path() == depth.first.parent_path()))
            continue;
        const std::string folder = folder_of(*other),
                          name = folder.empty() || folder == folder_of(depth) ? other->pattern : folder;
        if (std::find(told.begin(), told.end(), name) != told.end()) continue;
        told.push_back(name);
        names += (names.empty() ? "" : ", ") + name;
    }
    return printable(names, 200);
}

Error without_depth(const fs::path& folder, const std::vector<PictureGroup>& groups) {
    std::string message =
        folder.string() + ": no pictures of depth were found (there are " + found_there(groups);
    const std::string elsewhere = found_elsewhere(folder);
    if (!elsewhere.empty()) return input_error(message + ", " + elsewhere + ')');
    return input_error(
        message +
            "): describe them with a scene file, as docs/scene_file.md has it; where grey pictures "
            "are what a network guessed, a preset says so",
        {{Setting::scene_file, "FILE"}, {Setting::preset, "relative-inverse"}});
}

}  // namespace touchable
