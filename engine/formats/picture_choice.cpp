// SPDX-License-Identifier: Apache-2.0
// Chooses which pictures are depth, and which are colour, by their names and by what they hold.

#include <unistd.h>
#include <cerrno>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/formats/sidecar_text.hpp"
#include "engine/formats/value_evidence.hpp"
#include "engine/formats/video_picture.hpp"
#include "engine/picture/image.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

using SharedPicture = std::shared_ptr<const StoredImage>;

/// Turns RGB that is grey or nearly so everywhere, or in a half beside colour, into grey, and packed depth
/// into numbers.
Result<SharedPicture> as_depth(SharedPicture stored, const fs::path& file, Packing packing = Packing::none) {
    if (!stored->values.empty()) return stored;
    if (packing == Packing::none) packing = packing_of(*stored);
    if (packing != Packing::none) {
        auto unpacked = std::make_shared<StoredImage>(*stored);
        if (unpack_depth(*unpacked, packing)) return SharedPicture(std::move(unpacked));
        if (stop_requested()) return interrupted_error();
    }
    if (stored->image.channels == 1) return stored;
    if (const auto found = depth_in_colours(stored->image)) {
        auto depth = std::make_shared<StoredImage>(half_of(*stored, *found, PlaneRole::depth));
        if (found->layout == VideoLayout::alone) return SharedPicture(std::move(depth));
        depth->beside = std::make_shared<BesideDepth>();
        depth->beside->colour = half_of(*stored, *found, PlaneRole::colour);
        return SharedPicture(std::move(depth));
    }
    auto grey = as_grey(stored->image);
    if (stop_requested()) return interrupted_error();
    if (!grey) {
        const auto* const likely = preset_of(packing_of(*stored, true));
        const bool may_be_floats =
            !stored->alpha.empty() && std::ranges::all_of(stored->alpha, [](std::uint8_t exponent) {
                return exponent == 0 || (exponent >= 0x30 && exponent < 0x80);
            });
        return input_error(
            file.string() + ": is in colour: " +
                (likely          ? "its bytes look like " + std::string(likely->what)
                 : may_be_floats ? "its bytes and its alpha's may be floats"
                                 : "a colour map's colours are no depth, the grey of 16 bits or floats that "
                                   "they were made of is; numbers in its bytes need a preset"),
            likely          ? Hints{{Setting::preset, likely->name}}
            : may_be_floats ? Hints{{Setting::preset, "bgra32f"}, {Setting::preset, "rgba32f"}}
                            : Hints{{Setting::preset, "bgr24"}, {Setting::preset, "carla"}});
    }
    const StoredImage& of = *stored;
    return std::make_shared<const StoredImage>(
        StoredImage{std::move(*grey), of.codec, of.pixel_format, of.bits, of.interlaced, {}, of.beside});
}

/// Depth in a picture, or in the first of a stack.
Result<SharedPicture> depth_in(const fs::path& file, ReadPictures& pictures, Packing packing) {
    auto looked = pictures.look(file);
    return looked ? as_depth(std::move(*looked), file, packing) : looked;
}

Result<SharedPicture> depth_in_stack(ImageStack& stack, std::int64_t frame, const fs::path& file) {
    TRY_ASSIGN(auto picture, stack.image(frame));
    return as_depth(std::make_shared<const StoredImage>(std::move(picture)), file);
}

/// Whether a picture has a usable value; an error if the search was interrupted.
Result<bool> holds_values(const StoredImage& picture) {
    const bool any = estimate_values(picture).any;
    return stop_requested() ? Result<bool>(interrupted_error()) : any;
}

/// Whether a name has a word for infrared pictures, which look like depth and are none.
bool names_infrared(const std::string& name) {
    return has_beginning(name, {"ir ", "infra", "amplitude ", "ambient "});
}

bool is_in_colour(const StoredImage& picture) {
    return picture.values.empty() && picture.image.channels == 3 && picture.image.bytes_per_sample == 1;
}

/// Whether a group is named as pictures that are neither depth nor colour.
bool names_other(const std::string& name) {
    return has_word(name, {"conf", "mask", "label", "normal", "haptic", "height", "validity"}) ||
           (has_word(name, {"instance", "semantic", "segment", "panoptic"}) &&
            !has_word(name, {"depth", "disp", "rgb", "color", "colour", "image"}));
}

/// How likely a group is depth; 0: not at all.
int depth_mark(const PictureGroup& group, ReadPictures& pictures) {
    if (names_other(group.pattern)) return 0;
    const auto looked = pictures.look(group.first);
    if (!looked) return 0;
    const StoredImage& first = **looked;
    const bool is_named = has_word(group.pattern, {"depth", "disp", "range", "dpt"});
    const auto* const preset = preset_named(pictures.known().preset);
    const bool is_told = preset && preset->stored.packed != Packing::none && is_named && is_in_colour(first);
    const bool is_packed = is_told || packing_of(first) != Packing::none;
    const bool is_in_grey = is_grey(first.image) || (is_named && depth_in_colours(first.image));
    if (first.values.empty() && !is_packed && !is_in_grey) return 0;
    const bool is_deep = is_packed || !first.values.empty() || first.image.bytes_per_sample == 2;
    // Counts less than dense depth beside it.
    if (has_word(group.pattern, {"sparse"}) || names_infrared(group.pattern)) return is_deep ? 1 : 0;
    return (is_named ? 4 : 0) + (is_deep ? 2 : 0);
}

bool goes_as_colour(const PictureGroup& group, const PictureGroup& depth, ReadPictures& pictures) {
    if (group.pattern == depth.pattern || names_other(group.pattern) ||
        has_word(group.pattern, {"depth", "disp", "ultrawide"}))
        return false;
    const auto looked = pictures.look(group.first);
    if (!looked) return false;
    const StoredImage& first = **looked;
    if (!first.values.empty() || first.image.bytes_per_sample != 1) return false;
    return is_in_colour(first) ||
           has_word(group.pattern, {"rgb", "color", "colour", "image", "grey", "gray"});
}

std::string found_there(const std::vector<PictureGroup>& groups) {
    const std::string words =
        listed(std::span(groups).first(std::min<std::size_t>(groups.size(), 4)),
               [](const PictureGroup& each) { return std::to_string(each.count) + " x " + each.pattern; });
    return words.empty() ? "no pictures" : words + (groups.size() > 4 ? ", ..." : "");
}

/// All groups of a folder. An error if the first picture of a group named depth cannot be read.
Result<std::vector<PictureGroup>> readable_groups(const fs::path& folder, ReadPictures& pictures) {
    std::vector<PictureGroup> groups = picture_groups(folder);
    constexpr std::size_t most_groups = 200;  // the largest are first, and each is looked at
    if (groups.size() > most_groups) groups.resize(most_groups);
    for (const PictureGroup& group : groups) {
        if (stop_requested()) return interrupted_error();
        if (!has_word(group.pattern, {"depth"}) || is_named_cloud(group.first)) continue;
        TRY(pictures.look(group.first));
    }
    return groups;
}

/// The groups that are most likely depth, the largest first.
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

/// Groups of grey that no name or kind shows to be depth; used if a preset or the folder's name says depth.
std::vector<const PictureGroup*> greys_among(const std::vector<PictureGroup>& groups,
                                             ReadPictures& pictures) {
    std::vector<const PictureGroup*> greys;
    for (const PictureGroup& group : groups) {
        if (names_other(group.pattern) || has_word(group.pattern, {"rgb", "color", "colour", "infra"}))
            continue;
        const auto looked = pictures.look(group.first);
        if (looked && (*looked)->values.empty() && is_grey((*looked)->image)) greys.push_back(&group);
    }
    return greys;
}

/// Groups of pictures with depth in a half and colour in the other.
std::vector<const PictureGroup*> halves_among(const std::vector<PictureGroup>& groups,
                                              ReadPictures& pictures) {
    constexpr std::size_t most_looked_at = 8;
    std::vector<const PictureGroup*> halves;
    for (const PictureGroup& group : std::span(groups).first(std::min(groups.size(), most_looked_at)))
        if (const auto looked = pictures.look(group.first); looked && depth_beside_colour((*looked)->image))
            halves.push_back(&group);
    return halves;
}

/// Picks the colour pictures: prefers depth's folder, and skips folders that have depth of their own.
const PictureGroup* colour_among(const std::vector<PictureGroup>& groups,
                                 const std::vector<const PictureGroup*>& depths, ReadPictures& pictures) {
    const PictureGroup& depth = *depths.front();
    const PictureGroup* elsewhere = nullptr;
    for (const PictureGroup& group : groups) {
        if (!goes_as_colour(group, depth, pictures) || (group.count == 1) != (depth.count == 1)) continue;
        const std::string folder = folder_of(group);
        if (folder == folder_of(depth)) return &group;
        const bool is_of_another = std::ranges::any_of(
            depths, [&](const PictureGroup* other) { return folder_of(*other) == folder; });
        if (elsewhere == nullptr && !is_of_another) elsewhere = &group;
    }
    return elsewhere;
}

/// Whether a group could be depth, though another is likelier: deep pictures without a word for depth, and
/// sparse depth.
bool may_be_depth(const PictureGroup& group, ReadPictures& pictures) {
    if (names_infrared(group.pattern) || has_word(group.pattern, {"point"})) return false;
    const int mark = depth_mark(group, pictures);
    return mark == 1 || mark == 2;
}

/// Adds the groups whose first picture has depth, `depths` first, to what is left out.
Result<void> find_left_out(std::vector<const PictureGroup*> depths, const std::vector<PictureGroup>& groups,
                           ReadPictures& pictures, ChosenPictures& chosen) {
    constexpr std::size_t most_told = 20;  // each is looked at
    for (const PictureGroup& group : groups)
        if (std::ranges::count(depths, &group) == 0 && may_be_depth(group, pictures))
            depths.push_back(&group);
    const PictureGroup& depth = *depths.front();
    const bool is_listed = is_list(depth.pattern);
    for (const PictureGroup* other : depths) {
        if (other == &depth || (is_listed && other->first.parent_path() == depth.first.parent_path()))
            continue;
        const std::string folder = folder_of(*other);
        const bool has_own_folder = !folder.empty() && folder != folder_of(depth);
        auto& names =
            has_own_folder || is_still(other->pattern) ? chosen.left_out_by_path : chosen.left_out_by_pattern;
        const std::string name = has_own_folder ? folder : other->pattern;
        if (names.size() == most_told || std::ranges::count(names, name) > 0) continue;
        const auto looked = depth_in(other->first, pictures, Packing::none);
        if (!looked) continue;
        TRY_ASSIGN(const bool any, holds_values(**looked));
        if (any) names.push_back(name);
    }
    return {};
}

/// The error for a folder without depth: what it has, and what to do.
Error without_depth(const fs::path& folder, const std::vector<PictureGroup>& groups) {
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(folder, failure))
        if (entry.is_directory(failure) && ::euidaccess(entry.path().c_str(), R_OK | X_OK) != 0)
            return input_error(entry.path().string() + ": " + failure_words(errno));
    std::string message =
        folder.string() + ": no pictures of depth were found (there are " + found_there(groups);
    const std::string elsewhere = found_elsewhere(folder);
    if (!elsewhere.empty()) return input_error(message + ", " + elsewhere + ')');
    if (const auto foreign = foreign_file_below(folder)) return input_error(message + "), but " + *foreign);
    return input_error(message +
                           "): describe them with a scene file, as docs/scene_file.md has it; where grey "
                           "pictures are what a network guessed, a preset says so",
                       {{Setting::scene_file, "FILE"}, {Setting::preset, "relative-inverse"}});
}

/// The first group beside depth whose first picture is a Git LFS pointer, which was not fetched; null: there
/// is none.
const PictureGroup* unfetched_among(const std::vector<PictureGroup>& groups, const PictureGroup& depth) {
    constexpr std::size_t most_opened = 8, enough = 64;
    for (const PictureGroup& group : std::span(groups).first(std::min(groups.size(), most_opened)))
        if (group.pattern != depth.pattern &&
            is_git_lfs_pointer(first_bytes(SourceFile(group.first), enough)))
            return &group;
    return nullptr;
}

}  // namespace

Result<ChosenPictures> choose_pictures(const fs::path& folder, bool is_relative, ReadPictures& pictures) {
    TRY_ASSIGN(auto groups, readable_groups(folder, pictures));
    std::vector<const PictureGroup*> depths = depths_among(groups, pictures);
    if (depths.empty()) std::ranges::move(hdf5_groups(folder), std::back_inserter(groups));
    if (depths.empty()) depths = depths_among(groups, pictures);
    if (depths.empty() &&
        (is_relative || has_word(fs::weakly_canonical(folder).filename().string(), {"depth"})))
        depths = greys_among(groups, pictures);
    if (depths.empty()) depths = halves_among(groups, pictures);
    if (depths.empty() && stop_requested()) return interrupted_error();
    // A file without the channel or data set that a person named gives an error with those that it has.
    if (const auto& known = pictures.known();
        depths.empty() && !(known.channel.empty() && known.dataset.empty()))
        for (const PictureGroup& group : groups) TRY(pictures.look(group.first));
    for (const PictureGroup& group : groups)  // what is named depth and in colour says more
        if (depths.empty() && has_word(group.pattern, {"depth"}) && pictures.look(group.first))
            TRY(depth_in(group.first, pictures, Packing::none));
    if (depths.empty()) return without_depth(folder, groups);
    ChosenPictures chosen{.depth = *depths.front()};
    if (const PictureGroup* const colour = colour_among(groups, depths, pictures))
        chosen.colour = *colour;
    else if (const PictureGroup* const unfetched = unfetched_among(groups, chosen.depth))
        chosen.unfetched = unfetched->pattern;
    if (stop_requested()) return interrupted_error();  // colour may then have been missed
    const auto haptic = std::ranges::find_if(
        groups, [](const PictureGroup& group) { return has_word(group.pattern, {"haptic"}); });
    if (haptic != groups.end()) chosen.haptic = haptic->pattern;
    TRY(find_left_out(depths, groups, pictures, chosen));
    return chosen;
}

Result<std::shared_ptr<const StoredImage>> telling_depth(const std::vector<fs::path>& files,
                                                         ReadPictures& pictures,
                                                         const SourceDescription::Preset* preset) {
    const Packing packing = preset != nullptr ? preset->stored.packed : Packing::none;
    TRY_ASSIGN(const auto first, depth_in(files.front(), pictures, packing));
    TRY_ASSIGN(const bool any_in_first, holds_values(*first));
    if (any_in_first) return first;
    TRY_ASSIGN(const auto stack, pictures.stack_in(files.front()));
    const bool is_stack = files.size() == 1 && stack;
    for (const std::int64_t n : telling_frames(is_stack ? stack->count() : std::ssize(files))) {
        if (stop_requested()) return interrupted_error();
        const fs::path& file = files[is_stack ? 0 : static_cast<std::size_t>(n)];
        auto stored = is_stack ? depth_in_stack(*stack, n, file) : depth_in(file, pictures, packing);
        const bool is_alike = stored && (*stored)->image.width == first->image.width &&
                              (*stored)->image.height == first->image.height;
        if (!is_alike) continue;
        TRY_ASSIGN(const bool any, holds_values(**stored));
        if (any) return stored;
    }
    return first;
}

std::optional<fs::path> colour_beside(const fs::path& depth, ReadPictures& pictures) {
    const std::string stem = depth.stem().string();
    std::vector<std::string> stems;
    if (!realsense_metadata_of(depth)) stems.push_back(stem);  // there, that is depth in false colours
    for (const char* of_depth : {"depth", "Depth", "disp0", "disparity"})
        if (const auto at = stem.find(of_depth); at != std::string::npos)
            for (const char* of_colour : {"color", "colour", "rgb", "image", "Color", "im0"})
                stems.push_back(std::string(stem).replace(at, std::string(of_depth).size(), of_colour));
    for (const char* end : {"_depth", ".depth"})
        if (stem.ends_with(end)) stems.push_back(stem.substr(0, stem.size() - std::string(end).size()));
    for (const std::string& other : stems)
        for (const char* extension : {".png", ".jpg", ".jpeg", ".ppm", ".JPG", ".JPEG", ".PNG"}) {
            const fs::path file = depth.parent_path() / (other + extension);
            if (file == depth || !is_file(file)) continue;
            if (const auto picture = pictures.look(file); picture && is_in_colour(**picture)) return file;
        }
    return {};
}

}  // namespace touchable
