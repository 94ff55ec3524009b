#include "player/commands/staged_folder.hpp"

#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace touchable {
namespace fs = std::filesystem;
namespace {

Error unwritable(const fs::path& place, const std::error_code& why) {
    return input_error(place.string() + " cannot be written: " + why.message() + "; name a folder that can");
}

/// Files of a folder that make room for others; they go back unless `discard` says that they are not needed.
class Aside {
public:
    explicit Aside(fs::path place) : place_(std::move(place)), folder_(hidden_name(place_)) {}
    Aside(const Aside&) = delete;
    Aside& operator=(const Aside&) = delete;
    ~Aside() {
        std::error_code ignored;
        for (const char* name : names_) fs::rename(folder_ / name, place_ / name, ignored);
        if (made_) fs::remove(folder_, ignored);
    }

    /// Takes the file of that name, if there is one.
    Result<void> take(const char* name, Existing existing) {
        std::error_code failure;
        const auto status = fs::symlink_status(place_ / name, failure);
        if (!fs::exists(status)) return {};
        if (existing == Existing::keep)
            return input_error((place_ / name).string() + ": is there by now; it stays as it is");
        if (fs::is_directory(status))
            failure = std::make_error_code(std::errc::is_a_directory);
        else if (!made_)
            made_ = fs::create_directory(folder_, failure);
        if (made_ && !failure) fs::rename(place_ / name, folder_ / name, failure);
        if (failure) return unwritable(place_ / name, failure);
        names_.push_back(name);
        return {};
    }

    void discard() {
        std::error_code ignored;
        for (const char* name : std::exchange(names_, {})) fs::remove(folder_ / name, ignored);
    }

private:
    fs::path place_, folder_;
    bool made_ = false;
    std::vector<const char*> names_;
};

}  // namespace

Result<StagedFolder> StagedFolder::create(const fs::path& place, Existing existing) {
    std::error_code failure;
    fs::path whole = fs::absolute(place, failure).lexically_normal();
    if (!whole.has_filename()) whole = whole.parent_path();
    fs::path ground = whole;
    while (!fs::exists(ground, failure) && ground.has_relative_path()) ground = ground.parent_path();
    if (!fs::is_directory(ground, failure))
        return unwritable(place, std::make_error_code(std::errc::not_a_directory));
    return StagedFolder(whole, ground, existing);
}

StagedFolder::StagedFolder(fs::path place, fs::path ground, Existing existing)
    : place_(std::move(place)), ground_(std::move(ground)), existing_(existing) {}

NewFile& StagedFolder::add(const std::string& name) {
    return *(files_[name] = std::make_unique<NewFile>(place_ / name, Existing::keep, ground_));
}

Result<void> StagedFolder::name_in(const fs::path& folder, std::span<const char* const> names) {
    for (const char* name : names)
        if (const auto file = files_.find(name); file != files_.end())
            if (auto named = file->second->commit_as(folder / name); !named.ok()) return named;
    return {};
}

Result<void> StagedFolder::appear(std::span<const char* const> names) {
    std::error_code failure;
    const fs::path above = place_.parent_path(), hidden = hidden_name(above);
    fs::create_directories(above, failure);
    if (!failure) fs::create_directory(hidden, failure);
    Result<void> done;
    if (failure) done = unwritable(place_, failure);
    if (done.ok()) done = name_in(hidden, names);
    if (done.ok())
        if (const int why = move_to_free_name(hidden, place_))
            done = unwritable(place_, std::error_code(why, std::generic_category()));
    if (done.ok()) {
        sync_folder(above);
        return {};
    }
    fs::remove_all(hidden, failure);
    // The folders made for it go again: remove() refuses those that are somebody's by now.
    for (fs::path p = above; p != ground_; p = p.parent_path()) fs::remove(p, failure);
    return done;
}

Result<void> StagedFolder::replace(std::span<const char* const> names) {
    Aside aside(place_);
    for (auto name = names.rbegin(); name != names.rend(); ++name)
        if (auto taken = aside.take(*name, existing_); !taken.ok()) return taken;
    auto done = name_in(place_, names);
    if (done.ok()) {
        aside.discard();
        return {};
    }
    std::error_code ignored;
    for (const auto& [name, file] : files_)
        if (file->committed()) fs::remove(place_ / name, ignored);
    return done;
}

Result<void> StagedFolder::commit(std::span<const char* const> names) {
    return place_ == ground_ ? replace(names) : appear(names);
}

}  // namespace touchable
