#pragma once

#include <initializer_list>
#include <map>
#include <mutex>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Which picture of a file. Only renderings (OpenEXR) and clouds of points have more than one: others are
/// their own, whatever is asked for.
enum class PictureLayer { own, colour, materials };

/// Pictures that were read to find out what they are, kept to be read as frames, so that none is opened
/// twice. At most 256 MiB of them, or one: what is more is read again.
class ReadPictures {
public:
    ReadPictures() = default;
    /// Of these one was opened already.
    explicit ReadPictures(SourceFile opened) : newest_(std::move(opened)) {}

    /// What a file holds, of a stack the first; keeps it.
    Result<std::shared_ptr<const StoredImage>> look(const std::filesystem::path& file);
    /// What a file holds; keeps it no longer. What is wanted beside the newest rendering's own picture is
    /// there to be taken until another one's is. May be called by several threads at once for several files
    /// of which none has such pictures.
    Result<StoredImage> take(const std::filesystem::path& file, PictureLayer layer = PictureLayer::own);
    /// What is unpacked of a rendering with its own picture; at first all.
    void want_beside(const BesideDepth::Wanted& wanted) { wanted_ = wanted; }
    /// The pictures of a file that is a stack of them (.npy, .npz, HDF5, TIFF of several pages), which stays
    /// open; null of others.
    Result<std::shared_ptr<ImageStack>> stack_in(const std::filesystem::path& file);
    /// Of stacks that are opened from now on (open_npy_stack).
    void trust_from(std::optional<double> least_confidence) { least_confidence_ = least_confidence; }
    std::optional<double> least_confidence() const { return least_confidence_; }
    /// Of renderings that are read from now on: the channel that is depth, by name. Empty: found.
    void take_channel(const std::string& channel) { channel_ = channel; }
    const std::string& channel() const { return channel_; }
    /// The same of HDF5 and its data set.
    void take_dataset(const std::string& dataset) { dataset_ = dataset; }
    const std::string& dataset() const { return dataset_; }
    /// Keeps one for `take`, with what is beside it.
    void keep(const std::filesystem::path& file, StoredImage picture) {
        if (rendering_ == file.lexically_normal()) picture.beside = std::move(beside_);
        kept(file, std::move(picture));
    }
    /// The camera that the points of a cloud are of, once one of these was looked at, the first of them.
    std::optional<Intrinsics> camera_in(std::span<const std::filesystem::path> files) const;
    /// Forgets all but these.
    void keep_only(std::initializer_list<std::filesystem::path> files);

private:
    static constexpr std::size_t most_bytes = std::size_t{256} << 20;

    using Kept = std::map<std::filesystem::path, std::shared_ptr<StoredImage>>;

    StoredImage taken(Kept::iterator kept);
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

    std::mutex mutex_;  // guards what `take` uses of all that follows
    // By normal paths: lists and patterns may spell one file in two ways.
    Kept pictures_;
    std::map<std::filesystem::path, std::shared_ptr<ImageStack>> stacks_;
    std::optional<SourceFile> newest_;  // stays open until another one is wanted, or it was read
    std::size_t bytes_ = 0;             // of the pictures
    std::optional<double> least_confidence_;
    BesideDepth::Wanted wanted_{true, true};
    std::string channel_;                                  // depth's in renderings
    std::string dataset_;                                  // depth's in HDF5
    std::filesystem::path rendering_;                      // the newest whose own picture was taken
    std::shared_ptr<BesideDepth> beside_;                  // it; null: nothing
    std::map<std::filesystem::path, Intrinsics> cameras_;  // of clouds, the first ones that were read
};

/// Which pictures of a folder are depth, and which belong to it.
struct ChosenPictures {
    PictureGroup depth{};
    std::optional<PictureGroup> colour{};
    std::string haptic{};  ///< a pattern; empty: there is none
    // Other groups that go as depth as well.
    std::vector<std::string>
        left_out_by_path{};  ///< folders and files that can be opened: "t2/", "old_depth.png"
    std::vector<std::string>
        left_out_by_pattern{};  ///< groups that only a scene file can name: "old_depth_*.png"
    std::string
        unfetched{};  ///< where there is no colour, a group whose first picture is a pointer of Git LFS
};
/// Pictures of grey that nothing else shows to be depth are so where depth `is_relative`, or the folder's
/// name says it. An error says what is there instead.
Result<ChosenPictures> choose_pictures(const std::filesystem::path& folder, const SourceDescription& known,
                                       bool is_relative, ReadPictures& pictures);

/// Cameras may begin blank: the first of the telling frames that has depth, or else the first of all; colour
/// that is grey everywhere as grey, and depth of 24 bits as floats. `files`: one a frame, or one that is a
/// stack of them. `preset`: null where none is known.
Result<std::shared_ptr<const StoredImage>> telling_depth(const std::vector<std::filesystem::path>& files,
                                                         ReadPictures& pictures,
                                                         const SourceDescription::Preset* preset);

/// The picture of colour whose name is that of a picture of depth in another form, or with another word in
/// the place of depth, or without it.
std::optional<std::filesystem::path> colour_beside(const std::filesystem::path& depth,
                                                   ReadPictures& pictures);

/// The whole numbers in a picture of material indices: the first 12 met, sorted.
std::vector<int> indices_in(const StoredImage& picture);

/// Makes haptic pictures of pictures of material indices: each pixel gets its material's properties, by the
/// scene's haptic ranges. An index without an entry, and what is no whole number from 0 to 65535, gets the
/// scene's default properties.
class MaterialPictures {
public:
    explicit MaterialPictures(const SceneDescription& described);
    /// `indices` has one channel. An error does not name the file.
    Result<StoredImage> haptic(const StoredImage& indices) const;

private:
    std::vector<std::uint8_t> samples_;  // red, green, blue of each index, and of all others
};

}  // namespace touchable
