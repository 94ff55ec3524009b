#include "engine/formats/read_pictures.hpp"

#include <algorithm>
#include <string>

#include "engine/base/try.hpp"
#include "engine/picture/exr_image.hpp"

namespace touchable {
namespace {

std::size_t bytes_of(const StoredImage& picture) {
    std::size_t bytes = picture.image.samples.size() + picture.values.size() * sizeof(float);
    if (!picture.beside) return bytes;
    for (const auto* other : {&picture.beside->colour, &picture.beside->materials})
        if (*other) bytes += bytes_of(**other);
    return bytes;
}

}  // namespace

const SourceFile& ReadPictures::source(const std::filesystem::path& file) {
    if (!newest_ || newest_->path().lexically_normal() != file.lexically_normal()) newest_.emplace(file);
    return *newest_;
}

Result<std::shared_ptr<ImageStack>> ReadPictures::stack_in(const std::filesystem::path& file) {
    if (const auto there = stacks_.find(file.lexically_normal()); there != stacks_.end())
        return there->second;
    if (pictures_.contains(file.lexically_normal()) || !is_npy_file(source(file)))
        return std::shared_ptr<ImageStack>();
    TRY_ASSIGN(auto stack, open_npy_stack(source(file), least_confidence_));
    return stacks_[file.lexically_normal()] = std::make_shared<ImageStack>(std::move(stack));
}

Result<std::shared_ptr<const StoredImage>> ReadPictures::look(const std::filesystem::path& file) {
    if (const auto there = pictures_.find(file.lexically_normal()); there != pictures_.end())
        return std::shared_ptr<const StoredImage>(there->second);
    TRY_ASSIGN(const auto stack, stack_in(file));
    TRY_ASSIGN(auto picture, stack ? stack->image(0) : read(file, PictureLayer::own));
    // A stack is read again, which opens nothing.
    return stack ? std::make_shared<const StoredImage>(std::move(picture)) : kept(file, std::move(picture));
}

SourceFile ReadPictures::taken_source(const std::filesystem::path& file) {
    const std::lock_guard lock(mutex_);
    SourceFile taken = source(file);
    newest_.reset();
    return taken;
}

Result<StoredImage> ReadPictures::read(const std::filesystem::path& file, PictureLayer layer) {
    TRY_ASSIGN(auto bytes, read_picture_bytes(taken_source(file)));
    const std::string where = file.string();
    if (!is_exr(bytes)) return decode_stored_image(std::move(bytes), where);
    const auto decode = [layer, wanted = wanted_](std::string_view exr, const std::string& name) {
        if (layer == PictureLayer::own) return decode_exr(exr, name, wanted);
        return layer == PictureLayer::colour ? decode_exr_colour(exr, name) : decode_exr_materials(exr, name);
    };
    return decode_unless_stopped(std::move(bytes), where, decode);
}

std::optional<StoredImage> ReadPictures::taken_beside(const std::filesystem::path& file, PictureLayer layer) {
    if (!beside_ || rendering_ != file.lexically_normal()) return std::nullopt;
    return std::exchange(layer == PictureLayer::colour ? beside_->colour : beside_->materials, std::nullopt);
}

std::optional<StoredImage> ReadPictures::taken_without_reading(const std::filesystem::path& file,
                                                               PictureLayer layer) {
    const std::lock_guard lock(mutex_);
    if (layer != PictureLayer::own)
        if (auto beside = taken_beside(file, layer)) return beside;
    const auto kept = pictures_.find(file.lexically_normal());
    const bool is_kept =
        kept != pictures_.end() && (layer == PictureLayer::own || kept->second->codec != "exr");
    return is_kept ? std::optional(taken(kept)) : std::nullopt;
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

StoredImage ReadPictures::taken(Kept::iterator kept) {
    auto there = pictures_.extract(kept);
    bytes_ -= bytes_of(*there.mapped());
    if (there.mapped().use_count() == 1) return std::move(*there.mapped());
    StoredImage picture = *there.mapped();
    if (picture.beside) picture.beside = std::make_shared<BesideDepth>(*picture.beside);
    return picture;
}

void ReadPictures::keep(const std::filesystem::path& file, StoredImage picture) {
    if (rendering_ == file.lexically_normal()) picture.beside = std::move(beside_);
    kept(file, std::move(picture));
}

std::shared_ptr<const StoredImage> ReadPictures::kept(const std::filesystem::path& file,
                                                      StoredImage picture) {
    const auto shared = std::make_shared<StoredImage>(std::move(picture));
    if (const std::size_t bytes = bytes_of(*shared); pictures_.empty() || bytes_ + bytes <= most_bytes)
        if (pictures_.emplace(file.lexically_normal(), shared).second) bytes_ += bytes;
    return shared;
}

void ReadPictures::keep_only(std::initializer_list<std::filesystem::path> files) {
    const auto is_wanted = [&](const auto& each) {
        return std::any_of(files.begin(), files.end(),
                           [&](const auto& file) { return file.lexically_normal() == each.first; });
    };
    std::erase_if(stacks_, [&](const auto& each) { return !is_wanted(each); });
    std::erase_if(pictures_, [&](const auto& each) {
        if (is_wanted(each)) return false;
        bytes_ -= bytes_of(*each.second);
        return true;
    });
}

}  // namespace touchable
