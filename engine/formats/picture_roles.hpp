#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/formats/picture_groups.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

// Which pictures of a folder are depth, and which are colour: by their names, kinds and places.

/// Cameras may begin blank. The first of the telling frames that has depth, or else the first of all.
/// `files`: of each frame, or the one that is a stack of them.
Result<std::shared_ptr<const StoredImage>> telling_depth(const std::vector<std::filesystem::path>& files,
                                                         ReadPictures& pictures);

/// The picture of the same name in another form, or with another word for depth in it.
std::optional<std::filesystem::path> colour_beside(const std::filesystem::path& depth,
                                                   ReadPictures& pictures);

/// That a person stopped it.
Error interrupted_looking(const std::filesystem::path& folder);

/// All that there are; of pictures that call themselves depth the first can be read.
Result<std::vector<PictureGroup>> readable_groups(const std::filesystem::path& folder,
                                                  ReadPictures& pictures);

/// Those that go best as depth, the largest first.
std::vector<const PictureGroup*> depths_among(const std::vector<PictureGroup>& groups,
                                              ReadPictures& pictures);

/// Grey of 8 bits has no name or kind that says depth: it is that where somebody says so, or its folder.
std::vector<const PictureGroup*> greys_among(const std::vector<PictureGroup>& groups, ReadPictures& pictures);

/// Rather from depth's own folder, and from none that has depth of its own.
const PictureGroup* colour_among(const std::vector<PictureGroup>& groups,
                                 const std::vector<const PictureGroup*>& depths, ReadPictures& pictures);

/// Files and their times, a line each.
bool is_list_of_depth(const std::string& pattern);

/// What goes as depth as well, by its folder where that is another: "t2/, t3/".
std::string left_out(const std::vector<const PictureGroup*>& depths);

/// What was found in a folder without depth, and what to do.
Error without_depth(const std::filesystem::path& folder, const std::vector<PictureGroup>& groups);

}  // namespace touchable
