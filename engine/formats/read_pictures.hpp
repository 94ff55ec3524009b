// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <map>
#include <mutex>
#include <set>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Which picture of a file. Only renderings (OpenEXR) and point clouds have more than one; other files give
/// the same one for each.
enum class PictureLayer { own, colour, materials };

/// Keeps pictures that were read to guess a scene, so that they need not be read again as frames: at most 256
/// MiB of them, or one; others are read again.
class ReadPictures {
public:
    /// `known`: what a person says of stacks and renderings. `opened`: a file that is open already.
    explicit ReadPictures(SourceDescription known = {}, std::optional<SourceFile> opened = {})
        : newest_(std::move(opened)), known_(std::move(known)) {}

    /// Reads a file's picture (a stack's first) and keeps it.
    Result<std::shared_ptr<const StoredImage>> look(const std::filesystem::path& file);
    /// Reads a file's picture, or hands over the kept one. The wanted layers of a rendering can be taken
    /// after its own picture, until another rendering's is taken. Several threads may call it at once for
    /// different files without such layers.
    Result<StoredImage> take(const std::filesystem::path& file, PictureLayer layer = PictureLayer::own);
    /// Sets which layers are unpacked with a rendering's own picture; initially all.
    void want_beside(const BesideDepth::Wanted& wanted) { wanted_ = wanted; }
    /// A file's stack of pictures (.npy, .npz, HDF5, TIFF of several pages), which stays open; null for
    /// others.
    Result<std::shared_ptr<ImageStack>> stack_in(const std::filesystem::path& file);
    const SourceDescription& known() const { return known_; }
    /// Keeps a picture for `take`, with its layers.
    void keep(const std::filesystem::path& file, StoredImage picture) {
        if (rendering_ == file.lexically_normal()) picture.beside = std::move(beside_);
        kept(file, std::move(picture));
    }
    /// The camera of the first of these files that was read as a cloud; nothing if none was.
    std::optional<Intrinsics> camera_in(std::span<const std::filesystem::path> files) const;
    /// Whether the XMP of a file that was read says that it is an equirectangular panorama (GPano).
    bool has_panorama(const std::filesystem::path& file) const {
        return panoramas_.contains(file.lexically_normal());
    }
    /// Drops all kept pictures and stacks but these files'.
    void keep_only(std::initializer_list<std::filesystem::path> files);

private:
    static constexpr std::size_t most_bytes = std::size_t{256} << 20;

    std::shared_ptr<const StoredImage> kept(const std::filesystem::path& file, StoredImage picture);
    Result<StoredImage> read(const std::filesystem::path& file, PictureLayer layer);
    Result<StoredImage> read_cloud(std::string bytes, const std::filesystem::path& file, PictureLayer layer);
    std::optional<StoredImage> taken_without_reading(const std::filesystem::path& file, PictureLayer layer);
    const SourceFile& source(const std::filesystem::path& file) {
        if (!newest_ || newest_->path().lexically_normal() != file.lexically_normal()) newest_.emplace(file);
        return *newest_;
    }
    SourceFile taken_source(const std::filesystem::path& file) {
        const std::lock_guard lock(mutex_);
        SourceFile taken = source(file);
        newest_.reset();
        return taken;
    }

    std::mutex mutex_;  // guards the members below that `take` uses
    // By normal paths: lists and patterns may spell one file in two ways.
    std::map<std::filesystem::path, std::shared_ptr<StoredImage>> pictures_;
    std::map<std::filesystem::path, std::shared_ptr<ImageStack>> stacks_;
    std::optional<SourceFile> newest_;  // stays open until another file is wanted, or it was read
    std::size_t bytes_ = 0;             // of the pictures
    const SourceDescription known_;
    BesideDepth::Wanted wanted_{true, true};
    std::filesystem::path rendering_;                      // the newest whose own picture was taken
    std::shared_ptr<BesideDepth> beside_;                  // its layers; null: none
    std::map<std::filesystem::path, Intrinsics> cameras_;  // of the first clouds that were read
    std::set<std::filesystem::path> panoramas_;            // of the first, by their XMP
};

/// Refuses (ErrorKind::usage) a stated channel or data set of a file that has none by name.
Result<void> check_named_depth(const SourceDescription& known, const std::filesystem::path& file);

/// Which pictures of a folder are depth, and which belong to it.
struct ChosenPictures {
    PictureGroup depth{};
    std::optional<PictureGroup> colour{};
    std::string haptic{};  ///< a pattern; empty: there is none
    // Other groups that may be depth as well.
    std::vector<std::string>
        left_out_by_path{};  ///< folders and files that can be opened: "t2/", "old_depth.png"
    std::vector<std::string>
        left_out_by_pattern{};  ///< groups that only a scene file can name: "old_depth_*.png"
    std::string
        unfetched{};  ///< if there is no colour, a group whose first picture is a Git LFS pointer, if any
};
/// Grey pictures that nothing else shows to be depth count as depth if `is_relative`, or if the folder's name
/// has that word. An error says what the folder has instead.
Result<ChosenPictures> choose_pictures(const std::filesystem::path& folder, bool is_relative,
                                       ReadPictures& pictures);

/// The first of the telling frames that has depth, as cameras may begin blank, or else frame 0. RGB that is
/// grey everywhere becomes grey, depth of 24 bits floats. `files`: one a frame, or one stack. `preset`: may
/// be null.
Result<std::shared_ptr<const StoredImage>> telling_depth(const std::vector<std::filesystem::path>& files,
                                                         ReadPictures& pictures,
                                                         const SourceDescription::Preset* preset);

/// The colour picture whose name is the depth picture's with another extension, with a word for colour in
/// place of depth, or without that word; nothing if there is none.
std::optional<std::filesystem::path> colour_beside(const std::filesystem::path& depth,
                                                   ReadPictures& pictures);

}  // namespace touchable
