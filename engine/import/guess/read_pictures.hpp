#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "engine/given_file.hpp"
#include "engine/picture/npy_stack.hpp"
#include "engine/picture/stored_image.hpp"
#include "engine/result.hpp"

namespace touchable {

/// Pictures that were read to find out what they are, kept for whoever reads them as frames, so that none is
/// opened twice. At most 256 MiB of them: what is more is read again.
class ReadPictures {
public:
    ReadPictures() = default;
    /// Of these one was opened already.
    explicit ReadPictures(SourceFile opened) : newest_(std::move(opened)) {}

    /// What a file holds, of a stack the first; keeps it.
    Result<std::shared_ptr<const StoredImage>> look(const std::filesystem::path& file);
    /// What a file holds; keeps it no longer.
    Result<StoredImage> take(const std::filesystem::path& file);
    /// The pictures of a file that is a stack of them (.npy, .npz), which stays open; null of others.
    Result<std::shared_ptr<ImageStack>> stack_in(const std::filesystem::path& file);
    /// Keeps one for `take`.
    void keep(const std::filesystem::path& file, StoredImage picture);
    /// Forgets all but these.
    void keep_only(std::initializer_list<std::filesystem::path> files);

private:
    static constexpr std::size_t most_bytes = std::size_t{256} << 20;

    const SourceFile& source(const std::filesystem::path& file);
    std::shared_ptr<const StoredImage> kept(const std::filesystem::path& file, StoredImage picture);

    // By normal paths: lists and patterns may spell one file in two ways.
    std::map<std::filesystem::path, std::shared_ptr<StoredImage>> pictures_;
    std::map<std::filesystem::path, std::shared_ptr<ImageStack>> stacks_;
    std::optional<SourceFile> newest_;  // stays open until another one is wanted, or it was read
    std::size_t bytes_ = 0;             // of the pictures
};

}  // namespace touchable
