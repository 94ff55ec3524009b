// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/read_pictures.hpp"
#include "engine/picture/image.hpp"

#include "engine/base/try.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/formats/value_evidence.hpp"

namespace touchable {
namespace {

constexpr std::string_view projection = "GPano:ProjectionType";
constexpr std::size_t most_noted = 1000;  // files with a camera or a projection

std::size_t bytes_of(const StoredImage& picture) {
    std::size_t bytes =
        picture.image.samples.size() + picture.alpha.size() + picture.values.size() * sizeof(float);
    if (!picture.beside) return bytes;
    for (const auto* other : {&picture.beside->colour, &picture.beside->materials})
        if (*other) bytes += bytes_of(**other);
    return bytes;
}

/// Opens HDF5 or NumPy's arrays.
Result<std::shared_ptr<ImageStack>> open_arrays(const SourceFile& file, const SourceDescription& known) {
    if (is_hdf5_file(file)) return open_hdf5_stack(file, known.dataset);
    return open_npy_stack(file, known.least_confidence, known.dataset);
}

}  // namespace

Result<void> check_named_depth(const SourceDescription& known, const std::filesystem::path& file) {
    if (!known.channel.empty() && !is_exr(first_bytes(SourceFile(file), 4)))
        return usage_error(file.string() + ": is no OpenEXR file, of which a channel could be named",
                           {{Setting::channel}});
    if (!known.dataset.empty() && !has_named_arrays(SourceFile(file)))
        return usage_error(
            file.string() + ": is no HDF5 file and no .npz, of which a data set could be named",
            {{Setting::dataset}});
    return {};
}

Result<std::shared_ptr<const StoredImage>> ReadPictures::look(const std::filesystem::path& file) {
    if (const auto there = pictures_.find(file.lexically_normal()); there != pictures_.end())
        return std::shared_ptr<const StoredImage>(there->second);
    TRY_ASSIGN(const auto stack, stack_in(file));
    TRY_ASSIGN(auto picture, stack ? stack->image(0) : read(file, PictureLayer::own));
    // A stack's picture is not kept: reading it again opens nothing.
    return stack ? std::make_shared<const StoredImage>(std::move(picture)) : kept(file, std::move(picture));
}

Result<StoredImage> ReadPictures::take(const std::filesystem::path& file, PictureLayer layer) {
    auto there = taken_without_reading(file, layer);
    auto picture = there ? Result<StoredImage>(std::move(*there)) : read(file, layer);
    if (!picture || !picture->beside) return picture;
    const std::lock_guard lock(mutex_);
    rendering_ = file.lexically_normal();
    beside_ = std::move(picture->beside);
    return picture;
}

Result<std::shared_ptr<ImageStack>> ReadPictures::stack_in(const std::filesystem::path& file) {
    const auto name = file.lexically_normal();
    if (const auto there = stacks_.find(name); there != stacks_.end()) return there->second;
    if (pictures_.contains(name)) return std::shared_ptr<ImageStack>();
    const SourceFile& opened = source(file);
    const bool is_tiff = picture_kind(first_bytes(opened, 8)) == "TIFF";
    if (!is_tiff && !is_hdf5_file(opened) && !is_npy_file(opened)) return std::shared_ptr<ImageStack>();
    TRY_ASSIGN(auto stack, is_tiff ? open_tiff_stack(opened) : open_arrays(opened, known_));
    if (stack) stacks_[name] = stack;
    return stack;
}

void ReadPictures::keep_only(std::initializer_list<std::filesystem::path> files) {
    const auto is_wanted = [&](const auto& each) {
        return std::ranges::any_of(files,
                                   [&](const auto& file) { return file.lexically_normal() == each.first; });
    };
    std::erase_if(stacks_, [&](const auto& each) { return !is_wanted(each); });
    std::erase_if(pictures_, [&](const auto& each) {
        if (is_wanted(each)) return false;
        bytes_ -= bytes_of(*each.second);
        return true;
    });
}

std::shared_ptr<const StoredImage> ReadPictures::kept(const std::filesystem::path& file,
                                                      StoredImage picture) {
    const auto shared = std::make_shared<StoredImage>(std::move(picture));
    if (const std::size_t bytes = bytes_of(*shared); pictures_.empty() || bytes_ + bytes <= most_bytes)
        if (pictures_.emplace(file.lexically_normal(), shared).second) bytes_ += bytes;
    return shared;
}

Result<StoredImage> ReadPictures::read(const std::filesystem::path& file, PictureLayer layer) {
    if (realsense_metadata_of(file)) return read_realsense_raw(taken_source(file));
    const SourceFile opened = taken_source(file);
    const std::string where = file.string();
    if (is_hdf5_file(opened) || (!known_.dataset.empty() && has_named_arrays(opened))) {
        TRY_ASSIGN(const auto stack, open_arrays(opened, known_));
        return stack->image(0);  // each file of several is one frame
    }
    TRY_ASSIGN(auto bytes, read_picture_bytes(opened));
    if (begins_organised_cloud(bytes)) return read_cloud(std::move(bytes), file, layer);
    const std::string_view xmp =
        std::string_view(bytes).substr(std::min(bytes.size(), bytes.find(projection)), 64);
    if (const std::lock_guard lock(mutex_);
        panoramas_.size() < most_noted && xmp.find("equirectangular") != std::string_view::npos)
        panoramas_.insert(file.lexically_normal());
    if (!is_exr(bytes)) return decode_stored_image(std::move(bytes), where);
    const auto decode = [layer, wanted = wanted_, channel = known_.channel](std::string_view exr,
                                                                            const std::string& name) {
        if (layer == PictureLayer::own) return decode_exr(exr, name, wanted, channel);
        return layer == PictureLayer::colour ? decode_exr_colour(exr, name) : decode_exr_materials(exr, name);
    };
    return decode_unless_stopped(std::move(bytes), where, decode);
}

Result<StoredImage> ReadPictures::read_cloud(std::string bytes, const std::filesystem::path& file,
                                             PictureLayer layer) {
    // Decoding may go on after a stop, when this object no longer exists.
    const auto camera = std::make_shared<std::optional<Intrinsics>>();
    const auto decode = [camera](std::string_view cloud, const std::string& name) -> Result<StoredImage> {
        TRY_ASSIGN(auto decoded, decode_organised_cloud(cloud, name));
        *camera = decoded.camera;
        return std::move(decoded.depth);
    };
    TRY_ASSIGN(auto picture, decode_unless_stopped(std::move(bytes), file.string(), decode));
    const std::lock_guard lock(mutex_);
    if (*camera && cameras_.size() < most_noted) cameras_.emplace(file.lexically_normal(), **camera);
    if (layer != PictureLayer::colour || !picture.beside) return picture;
    return std::move(*picture.beside->colour);
}

std::optional<Intrinsics> ReadPictures::camera_in(std::span<const std::filesystem::path> files) const {
    for (const auto& file : cameras_.empty() ? std::span<const std::filesystem::path>() : files)
        if (const auto found = cameras_.find(file.lexically_normal()); found != cameras_.end())
            return found->second;
    return {};
}

std::optional<StoredImage> ReadPictures::taken_without_reading(const std::filesystem::path& file,
                                                               PictureLayer layer) {
    const std::lock_guard lock(mutex_);
    const auto name = file.lexically_normal();
    if (layer != PictureLayer::own && beside_ && rendering_ == name) {
        auto& beside = layer == PictureLayer::colour ? beside_->colour : beside_->materials;
        if (beside) return std::exchange(beside, std::nullopt);
    }
    const auto kept = pictures_.find(name);
    const bool is_kept = kept != pictures_.end() && (layer == PictureLayer::own ||
                                                     (kept->second->codec != "exr" && !is_named_cloud(name)));
    if (!is_kept) return {};
    const auto there = pictures_.extract(kept).mapped();
    bytes_ -= bytes_of(*there);
    if (there.use_count() == 1) return std::move(*there);
    StoredImage picture = *there;
    if (picture.beside) picture.beside = std::make_shared<BesideDepth>(*picture.beside);
    return picture;
}

}  // namespace touchable
