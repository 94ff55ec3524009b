#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// A folder with a hidden name for files that are to appear together; it goes again with all that is left in
/// it.
class HiddenFolder {
public:
    explicit HiddenFolder(const std::filesystem::path& beside);
    HiddenFolder(const HiddenFolder&) = delete;
    HiddenFolder& operator=(const HiddenFolder&) = delete;
    ~HiddenFolder();

    const std::filesystem::path& path() const { return path_; }
    /// Why it could not be made, if so.
    const std::error_code& failure() const { return failure_; }
    /// All in it safe on the disk, as far as its file system can.
    void sync() const;
    void remove() const;
    /// Gives its files of these names the same names in `home`, in this order, the one that opens the others
    /// last. With `keep` all of them or none.
    Result<void> move_to(const std::filesystem::path& home, const std::vector<std::string>& names,
                         Existing existing) const;

private:
    std::filesystem::path path_;
    std::error_code failure_;
    int opened_ = -1;
};

}  // namespace touchable
