#include "engine/clip/hidden_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace touchable {
namespace fs = std::filesystem;

HiddenFolder::HiddenFolder(const fs::path& beside) : path_(hidden_name(beside)) {
    if (!fs::create_directory(path_, failure_)) return;
    opened_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

HiddenFolder::~HiddenFolder() {
    remove();
    if (opened_ >= 0) close(opened_);
}

void HiddenFolder::sync() const {
    if (opened_ >= 0) syncfs(opened_);
}

void HiddenFolder::remove() const {
    std::error_code ignored;
    if (!failure_) fs::remove_all(path_, ignored);
}

Result<void> HiddenFolder::move_to(const fs::path& home, const std::vector<std::string>& names,
                                   Existing existing) const {
    for (auto name = names.begin(); name != names.end(); ++name) {
        const fs::path from = path_ / *name, to = home / *name;
        std::error_code failure;
        if (existing == Existing::replace)
            fs::rename(from, to, failure);
        else
            failure.assign(move_to_free_name(from, to), std::generic_category());
        if (!failure) continue;
        if (existing == Existing::keep)  // nothing of it is left
            for (auto done = names.begin(); done != name; ++done) {
                std::error_code ignored;
                fs::remove(home / *done, ignored);
            }
        return input_error(to.string() + ": cannot be written: " + failure.message());
    }
    sync_folder(home.empty() ? fs::path(".") : home);
    return {};
}

}  // namespace touchable
