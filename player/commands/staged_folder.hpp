#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// A folder whose files appear together: until `commit` nothing is to be seen of them, and a folder that was
/// not there appears with all of them in it. Where it is there already, an error half-way puts back what was
/// there before.
class StagedFolder {
public:
    /// `place`: where the files shall be; made, with its parents, where it does not exist.
    static Result<StagedFolder> create(const std::filesystem::path& place, Existing existing);

    /// A file that shall have this name there: written to and closed before `commit`.
    NewFile& add(const std::string& name);
    std::size_t count() const { return files_.size(); }
    /// Of `names`, all that such a folder may hold, those not added go, too, where an earlier run left them.
    /// They are replaced from the last to the first and appear from the first to the last.
    Result<void> commit(std::span<const char* const> names);

private:
    StagedFolder(std::filesystem::path place, std::filesystem::path ground, Existing existing);
    Result<void> appear(std::span<const char* const> names);
    Result<void> replace(std::span<const char* const> names);
    /// Gives the files their names in `folder`.
    Result<void> name_in(const std::filesystem::path& folder, std::span<const char* const> names);

    std::filesystem::path place_;
    std::filesystem::path ground_;  ///< the nearest folder that was there: `place_` or one above it
    Existing existing_;
    std::map<std::string, std::unique_ptr<NewFile>> files_;
};

}  // namespace touchable
