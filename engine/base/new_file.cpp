#include "engine/base/new_file.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <system_error>
#include <utility>

#include "engine/base/number_words.hpp"

namespace touchable {
namespace {
namespace fs = std::filesystem;

/// A file that is open, by a name that leads to it whatever its own is.
fs::path open_file_name(int file) {
    return "/proc/self/fd/" + std::to_string(file);
}

fs::path folder_of(const fs::path& file) {
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Gives `from` a second name, following it where it leads to an open file: 0 or errno.
int add_name(const fs::path& from, const fs::path& to) {
    return linkat(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), AT_SYMLINK_FOLLOW) == 0 ? 0 : errno;
}

}  // namespace

fs::path hidden_name(const fs::path& folder) {
    std::uint64_t number = 0;
    if (getrandom(&number, sizeof number, 0) != sizeof number) number = static_cast<std::uint64_t>(getpid());
    return folder / formatted(".unfinished-%016llx", static_cast<unsigned long long>(number));
}

int move_to_free_name(const fs::path& from, const fs::path& to) {
    if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
    if (errno != EINVAL && errno != ENOSYS) return errno;
    // A file system that cannot: a file may have two names for a moment, a folder may not.
    std::error_code failure;
    if (fs::is_directory(from, failure)) {
        if (fs::exists(fs::symlink_status(to, failure))) return EEXIST;
        return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
    }
    if (const int why = add_name(from, to)) return why;
    unlink(from.c_str());
    return 0;
}

void sync_folder(const fs::path& folder) {
    const int opened = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (opened < 0) return;
    fsync(opened);
    close(opened);
}

NewFile::NewFile(fs::path target, Existing existing, const fs::path& beside)
    : target_(std::move(target)), existing_(existing) {
    const fs::path folder = beside.empty() ? folder_of(target_) : beside;
    open_unnamed(folder);
    if (file_ < 0) open_named(folder);
}

NewFile::~NewFile() {
    if (file_ >= 0) close(file_);
    if (!hidden_.empty()) unlink(hidden_.c_str());
}

void NewFile::open_unnamed(const fs::path& folder) {
    file_ = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    if (file_ < 0) return;
    path_ = open_file_name(file_);
    if (access(path_.c_str(), W_OK) == 0) return;
    close(std::exchange(file_, -1));  // without /proc nobody could write to it
}

void NewFile::open_named(const fs::path& folder) {
    for (int tries = 0; tries < 8 && file_ < 0; ++tries) {
        path_ = hidden_name(folder);
        file_ = open(path_.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_RDWR | O_CLOEXEC, 0666);
        failure_ = file_ < 0 ? errno : 0;
        if (failure_ != EEXIST) break;
    }
    if (file_ < 0) {
        path_.clear();
        return;
    }
    hidden_ = path_;
    // Whoever may write in the folder could put something else under that name.
    if (const auto opened = open_file_name(file_); access(opened.c_str(), W_OK) == 0) path_ = opened;
}

Error NewFile::failed(int why) const {
    return input_error(target_.string() + ": cannot be written: " + std::generic_category().message(why));
}

Result<void> NewFile::check() const {
    std::error_code failure;
    const auto status = fs::status(target_, failure);
    if (!target_.has_filename() || (fs::exists(status) && !is_regular_file(status)))
        return input_error(target_.string() +
                           ": is not the name of a file; must be one, new or to be replaced");
    if (failure_ != 0) return failed(failure_);
    return {};
}

Result<void> NewFile::write(std::string_view text) {
    if (auto usable = check(); !usable.ok()) return usable;
    while (!text.empty()) {
        const ssize_t taken = ::write(file_, text.data(), text.size());
        if (taken < 0 && errno == EINTR) continue;
        if (taken < 0) return failed(errno);
        text.remove_prefix(static_cast<std::size_t>(taken));
    }
    return {};
}

int NewFile::replace(const fs::path& name) {
    if (hidden_.empty()) {
        // Only a file with a name can take the place of another.
        const fs::path hidden = hidden_name(folder_of(name));
        if (const int why = add_name(path_, hidden)) return why;
        hidden_ = hidden;
    }
    if (std::rename(hidden_.c_str(), name.c_str()) != 0) return errno;
    hidden_.clear();
    return 0;
}

int NewFile::give_name(const fs::path& name) {
    const int why = hidden_.empty() ? add_name(path_, name) : move_to_free_name(hidden_, name);
    if (why == EEXIST && existing_ == Existing::replace) return replace(name);
    if (why == 0) hidden_.clear();
    return why;
}

Result<void> NewFile::commit_as(const fs::path& name) {
    if (auto usable = check(); !usable.ok()) return usable;
    // Some file systems and pipes cannot; that is no fault.
    if (lasts_ && fsync(file_) != 0 && errno != EINVAL && errno != ENOSYS && errno != EROFS)
        return failed(errno);
    const int why = give_name(name);
    if (why == EEXIST)
        return input_error(target_.string() +
                           ": is there by now, and was not when this run began; it stays as it is");
    if (why != 0) return failed(why);
    committed_ = true;
    if (lasts_) sync_folder(folder_of(name));
    return {};
}

}  // namespace touchable
