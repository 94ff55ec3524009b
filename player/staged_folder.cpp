#include "player/staged_folder.hpp"

#include <unistd.h>

#include <string>
#include <system_error>
#include <utility>

namespace touchable {
namespace fs = std::filesystem;
namespace {

Error unwritable(const fs::path& place, const std::error_code& why) {
    return input_error(place.string() + " cannot be written: " + why.message() + "; name a folder that can");
}

}  // namespace

Result<StagedFolder> StagedFolder::create(const fs::path& place) {
    std::error_code failure;
    if (fs::exists(place, failure) && !fs::is_directory(place, failure))
        return unwritable(place, std::make_error_code(std::errc::not_a_directory));
    const fs::path whole = fs::absolute(place, failure).lexically_normal();
    fs::path first_made;
    for (fs::path p = whole; !fs::exists(p, failure) && p.has_relative_path(); p = p.parent_path())
        first_made = p;
    StagedFolder folder(whole, first_made);
    fs::create_directories(folder.staging_, failure);
    if (failure) return unwritable(place, failure);
    return folder;
}

StagedFolder::StagedFolder(fs::path place, fs::path first_made)
    : place_(std::move(place)),
      staging_(place_ / (".partial-" + std::to_string(getpid()))),
      first_made_(std::move(first_made)) {}

StagedFolder::StagedFolder(StagedFolder&& other) noexcept
    : place_(std::move(other.place_)),
      staging_(std::exchange(other.staging_, {})),
      first_made_(std::exchange(other.first_made_, {})) {}

StagedFolder::~StagedFolder() {
    std::error_code ignored;
    if (staging_.empty()) return;
    fs::remove_all(staging_, ignored);
    if (first_made_.empty()) return;
    // Of the folders made for it, those in which nothing was committed go again: remove() refuses the others.
    for (fs::path p = place_; fs::remove(p, ignored) && p != first_made_;) p = p.parent_path();
}

Result<void> StagedFolder::commit(std::span<const char* const> names) {
    std::error_code failure;
    for (const char* name : names) {
        if (fs::exists(staging_ / name, failure))
            fs::rename(staging_ / name, place_ / name, failure);
        else
            fs::remove(place_ / name, failure);
        if (failure) return unwritable(place_ / name, failure);
    }
    return {};
}

}  // namespace touchable
