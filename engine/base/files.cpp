// SPDX-License-Identifier: Apache-2.0
#include "engine/base/files.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <sys/vfs.h>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <tuple>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// Bytes per read, so that a series of small reads does not make a system call each.
constexpr std::uint64_t block_bytes = 1 << 16;

/// Describes a file that is not ordinary.
const char* other_kind(mode_t mode) {
    if (S_ISDIR(mode)) return "is a folder";
    if (S_ISFIFO(mode)) return "is a pipe, no ordinary file";
    if (S_ISSOCK(mode)) return "is a socket, no ordinary file";
    return "is a device, no ordinary file";
}

std::string words_of(int error) {
    return error == ENOENT ? "does not exist" : "cannot be read (" + failure_words(error) + ")";
}

/// Puts the file's name, if any, before the message.
Error named_error(const std::string& named, const std::string& why) {
    return input_error(named.empty() ? why : named + ": " + why);
}

/// A file that is open as long as it has readers.
class OpenFile : NonCopyable {
public:
    explicit OpenFile(int number) : number_(number) {
        struct statfs system = {};
        in_memory_ = fstatfs(number, &system) == 0 && system.f_type == TMPFS_MAGIC;
    }
    ~OpenFile() { close(number_); }

    std::ptrdiff_t read(std::uint64_t at, char* to, std::size_t count, bool may_wait) const {
        iovec room{to, count};
        ssize_t got = -1;
        do {
            got = preadv2(number_, &room, 1, static_cast<off_t>(at), may_wait || in_memory_ ? 0 : RWF_NOWAIT);
        } while (got < 0 && errno == EINTR && may_wait);
        return got < 0 ? -errno : got;
    }

private:
    int number_;
    bool in_memory_;  // on tmpfs, which may not support RWF_NOWAIT
};

Result<std::string> all_of(Result<GivenFile> given, const std::string& named, const std::string& right,
                           std::size_t largest) {
    if (!given) return given.error();
    if (given->size() > largest)
        return named_error(named, "is larger than " + in_bytes(largest) + "; expected " + right);
    std::string bytes(static_cast<std::size_t>(given->size()), '\0');
    if (auto read = given->read(0, bytes.data(), bytes.size()); !read)
        return named.empty() ? read.error() : error_at(named, read.error());
    return bytes;
}

class MemoryBytes final : public ByteSource {
public:
    explicit MemoryBytes(std::string_view bytes) : bytes_(bytes) {}
    std::uint64_t size() const override { return bytes_.size(); }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (at > bytes_.size() || count > bytes_.size() - at) return input_error("is cut short");
        std::memcpy(to, bytes_.data() + at, count);
        return {};
    }

private:
    std::string_view bytes_;
};

/// A path that leads to an open file, even to one without a name.
fs::path open_file_name(int file) {
    return "/proc/self/fd/" + std::to_string(file);
}

fs::path folder_of(const fs::path& file) {
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Gives `from` a second name, following it if it leads to an open file. Returns 0 or an errno.
int add_name(const fs::path& from, const fs::path& to) {
    return linkat(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), AT_SYMLINK_FOLLOW) == 0 ? 0 : errno;
}

/// Takes a file's name for this process, so that no other one writes that file, too. The name is that of a
/// socket: the system frees it when the process ends, and nothing is left on the disk. Returns nothing if it
/// is taken, and a Descriptor without a socket if no name can be taken here.
std::optional<Descriptor> hold_name(const fs::path& file) {
    Descriptor held(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const fs::path name = file.filename();
    struct stat known {};
    if (stat(folder_of(file).c_str(), &known) != 0) return Descriptor();
    ByteHash hash;
    hash.add(&known.st_dev, sizeof known.st_dev);
    hash.add(&known.st_ino, sizeof known.st_ino);
    hash.add(name.c_str(), name.native().size());
    sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
    const std::string taken = "touchable-" + hash.hex();
    taken.copy(address.sun_path + 1, sizeof address.sun_path - 1);  // begins with 0: no file's name
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + taken.size());
    if (bind(held.get(), reinterpret_cast<const sockaddr*>(&address), size) == 0) return held;
    return errno == EADDRINUSE ? std::nullopt : std::optional(Descriptor());
}

constexpr int folder_flags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;

/// Removes all in a folder but `kept`, and follows no link. False: a stop was requested first.
bool empty_folder(int folder, std::string_view kept) {
    const int own = openat(folder, ".", folder_flags);
    const std::unique_ptr<DIR, ReleasedBy<closedir>> list(own < 0 ? nullptr : fdopendir(own));
    while (const dirent* const each = list ? readdir(list.get()) : nullptr) {
        if (stop_requested()) return false;
        const std::string_view name = each->d_name;
        if (name == "." || name == ".." || name == kept || unlinkat(folder, each->d_name, 0) == 0) continue;
        const Descriptor inner(openat(folder, each->d_name, folder_flags));
        if (inner.get() >= 0 && !empty_folder(inner.get(), {})) return false;
        unlinkat(folder, each->d_name, AT_REMOVEDIR);
    }
    return true;
}

/// Removes a ScratchFolder, or part of it if a stop is requested.
void remove_scratch(const fs::path& path, int folder) {
    if (!empty_folder(folder, ScratchFolder::mark)) return;
    unlinkat(folder, ScratchFolder::mark, 0);
    rmdir(path.c_str());
}

/// Removes this user's folders that no process holds any more: their program was killed. In a shared folder
/// another user could give any folder such a name; only the mark in it, which is this user's, tells.
void remove_abandoned(const fs::path& parent, const std::string& prefix) {
    std::error_code failure;
    for (fs::directory_iterator each(parent, failure), end; !failure && each != end;
         each.increment(failure)) {
        if (stop_requested()) return;
        if (!each->path().filename().string().starts_with(prefix)) continue;
        const Descriptor folder(open(each->path().c_str(), folder_flags));
        struct stat mark {};
        if (fstatat(folder.get(), ScratchFolder::mark, &mark, AT_SYMLINK_NOFOLLOW) == 0 &&
            S_ISREG(mark.st_mode) && mark.st_uid == geteuid() && flock(folder.get(), LOCK_EX | LOCK_NB) == 0)
            remove_scratch(each->path(), folder.get());
    }
}

}  // namespace

Result<GivenFile> GivenFile::open(const fs::path& file, const std::string& named, const std::string& right) {
    const auto refused = [&](const std::string& why) {
        return named_error(named, why + "; expected " + right);
    };
    // Opening a device may change its state, so check first; then check what was opened.
    struct stat about = {};
    if (stat(file.c_str(), &about) != 0) return refused(words_of(errno));
    if (!S_ISREG(about.st_mode)) return refused(other_kind(about.st_mode));
    const int number = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (number < 0) return refused(words_of(errno));
    const auto opened = std::make_shared<const OpenFile>(number);
    if (fstat(number, &about) != 0) return refused(words_of(errno));
    if (!S_ISREG(about.st_mode)) return refused(other_kind(about.st_mode));
    return GivenFile([opened](std::uint64_t at, char* to, std::size_t count,
                              bool may_wait) { return opened->read(at, to, count, may_wait); },
                     static_cast<std::uint64_t>(about.st_size));
}

/// Reads bytes that are in memory at once. For a disk, which may be at the other end of a failed network,
/// another thread waits.
Result<void> GivenFile::fill(std::uint64_t at) {
    if (stop_requested()) return interrupted_error();
    const auto count = static_cast<std::size_t>(std::min(block_bytes, size_ - at));
    std::string block(count, '\0');
    std::ptrdiff_t got = reading_(at, block.data(), count, false);
    if (got < 0) {
        auto came = unless_stopped([reading = reading_, at, count] {
            std::string bytes(count, '\0');
            const std::ptrdiff_t here = reading(at, bytes.data(), count, true);
            return std::pair(std::move(bytes), here);
        });
        if (!came) return interrupted_error();
        std::tie(block, got) = std::move(*came);
    }
    block.resize(static_cast<std::size_t>(std::max<std::ptrdiff_t>(got, 0)));
    block_ = std::move(block);
    block_at_ = at;
    if (got == -ETIMEDOUT) return input_error("cannot be read: its server sends it too slowly");
    if (got < 0) return input_error("cannot be read: " + failure_words(static_cast<int>(-got)));
    return got > 0 ? Result<void>() : input_error("is cut short");
}

Result<void> GivenFile::read(std::uint64_t at, char* to, std::size_t count) {
    if (at > size_ || count > size_ - at) return input_error("is cut short");
    while (count > 0) {
        if (at < block_at_ || at - block_at_ >= block_.size()) TRY(fill(at));
        const auto from = static_cast<std::size_t>(at - block_at_);
        const std::size_t some = std::min(count, block_.size() - from);
        std::memcpy(to, block_.data() + from, some);
        at += some;
        to += some;
        count -= some;
    }
    return {};
}

Result<std::string> read_given_file(const fs::path& file, const std::string& named, const std::string& right,
                                    std::size_t largest) {
    return all_of(GivenFile::open(file, named, right), named, right, largest);
}

Result<GivenFile> SourceFile::open(const std::string& right) const {
    if (!opened_->file) {
        TRY_ASSIGN(auto given, GivenFile::open(path(), string(), right));
        opened_->file = std::make_unique<const GivenFile>(std::move(given));
    }
    return *opened_->file;
}

Result<std::string> SourceFile::read(const std::string& right, std::size_t largest) const {
    return all_of(open(right), string(), right, largest);
}

std::string in_bytes(std::uint64_t bytes) {
    const char* unit = " bytes";
    for (const char* larger : {" KiB", " MiB", " GiB"}) {
        if (bytes == 0 || bytes % 1024 != 0) break;
        bytes /= 1024;
        unit = larger;
    }
    return std::to_string(bytes) + unit;
}

std::unique_ptr<ByteSource> bytes_in_memory(std::string_view bytes) {
    return std::make_unique<MemoryBytes>(bytes);
}

Result<std::unique_ptr<ByteSource>> bytes_of_file(const SourceFile& file) {
    TRY_ASSIGN(auto given, file.open("an ordinary file"));
    return std::unique_ptr<ByteSource>(std::make_unique<GivenFile>(std::move(given)));
}

std::string first_bytes(ByteSource& bytes, std::size_t count) {
    std::string begin(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), count)), '\0');
    if (!bytes.read(0, begin.data(), begin.size())) begin.clear();
    return begin;
}

std::string first_bytes(const SourceFile& file, std::size_t count) {
    const auto bytes = bytes_of_file(file);
    return bytes ? first_bytes(**bytes, count) : std::string();
}

fs::path hidden_name(const fs::path& folder) {
    std::uint64_t number = 0;
    if (getrandom(&number, sizeof number, 0) != sizeof number) number = static_cast<std::uint64_t>(getpid());
    return folder / formatted(".unfinished-%016llx", static_cast<unsigned long long>(number));
}

std::string shown_as(std::string message, const fs::path& hidden, const fs::path& name) {
    for (auto at = message.find(hidden); at != message.npos;
         at = message.find(hidden, at + name.native().size()))
        message.replace(at, hidden.native().size(), name);
    return message;
}

int move_to_free_name(const fs::path& from, const fs::path& to) {
    if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
    if (errno != EINVAL && errno != ENOSYS) return errno;
    // Without RENAME_NOREPLACE: a file may have two names for a moment, a folder may not.
    std::error_code failure;
    if (fs::is_directory(from, failure)) {
        if (fs::exists(fs::symlink_status(to, failure))) return EEXIST;
        return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
    }
    if (const int why = add_name(from, to)) return why;
    unlink(from.c_str());
    return 0;
}

int sync_path(const fs::path& path) {
    const Descriptor opened(open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (opened.get() < 0) return errno == EACCES ? 0 : errno;  // not every folder can be listed
    return failed_sync(fsync(opened.get()));
}

Result<void> sync_names(const fs::path& folder, const fs::path& what) {
    const int why = sync_path(folder.empty() ? "." : folder);
    if (why == 0) return {};
    return input_error(what.string() + ": is there, but its disk may lose it: " + failure_words(why) +
                       "; write it again, or elsewhere");
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
    close(std::exchange(file_, -1));  // without /proc no other code could write to it
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
    // Another program that may write in the folder could put something else under that name.
    if (const auto opened = open_file_name(file_); access(opened.c_str(), W_OK) == 0) path_ = opened;
}

Error NewFile::failed(int why) const {
    return input_error(target_.string() + ": cannot be written: " + failure_words(why));
}

Result<void> NewFile::check() const {
    std::error_code failure;
    const auto status = fs::status(target_, failure);
    if (!target_.has_filename() || fs::is_directory(status))
        return input_error(target_.string() + ": is a folder; name a file");
    if (fs::exists(status) && !is_regular_file(status))
        return input_error(target_.string() + ": is no regular file; name a new file, or one to replace");
    if (failure_ != 0) return failed(failure_);
    return {};
}

Result<void> NewFile::hold() {
    TRY(check());
    auto held = hold_name(target_);
    if (!held)
        return input_error(target_.string() +
                           ": another run writes it; name another file, or let that run end");
    held_ = std::move(*held);
    return {};
}

Result<void> NewFile::write(std::string_view text) {
    TRY(check());
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
    TRY(check());
    int why = lasts_ ? failed_sync(fsync(file_)) : 0;
    if (why != 0) return failed(why);
    why = give_name(name);
    if (why == EEXIST)
        return input_error(target_.string() +
                           ": is there by now, and was not when this run began; it stays as it is");
    if (why != 0) return failed(why);
    committed_ = true;
    held_ = Descriptor();
    return lasts_ ? sync_names(name.parent_path(), target_) : Result<void>();
}

Result<std::unique_ptr<ScratchFolder>> ScratchFolder::create(std::string_view kind) {
    const std::string prefix = "touchable-" + std::string(kind) + '-';
    std::error_code failure;
    const fs::path parent = fs::canonical(fs::temp_directory_path(failure), failure);
    const char* const typed = std::getenv("TMPDIR");
    if (!failure) remove_abandoned(parent, prefix);
    std::string name = (parent / prefix).string() + "XXXXXX";
    if (failure || mkdtemp(name.data()) == nullptr)
        return input_error("no folder of temporary files can be made in " +
                           in_quotes(failure && typed ? typed : parent.string()) +
                           "; TMPDIR may name another place");
    std::unique_ptr<ScratchFolder> folder(new ScratchFolder(name));
    // Where no lock can be had the folder gets no mark, so that no other process removes it.
    if (flock(folder->held_.get(), LOCK_EX | LOCK_NB) == 0)
        Descriptor(openat(folder->held_.get(), mark, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    return folder;
}

ScratchFolder::ScratchFolder(fs::path path)
    : path_(std::move(path)), owner_(getpid()), held_(open(path_.c_str(), folder_flags)) {}

ScratchFolder::~ScratchFolder() {
    if (owner_ != getpid()) return;
    const StopScope for_all = StopScope::for_all();  // the clip of an opening that is given up goes, too
    // A program that is to stop removes all of it, too: a second request ends even that, and the next one
    // that makes such a folder then removes the rest.
    const StopScope after_stop = StopScope::after_stop();
    remove_scratch(path_, held_.get());
}

Result<fs::path> own_folder(const char* variable, const char* in_home) {
    const auto folder = [](const char* of) {
        const char* const value = std::getenv(of);
        return fs::path(value ? value : "");
    };
    // A path that is not absolute counts as not set.
    if (const auto stated = folder(variable); stated.is_absolute()) return stated / "touchable";
    if (const auto home = folder("HOME"); home.is_absolute()) return home / in_home / "touchable";
    return usage_error(std::string("neither HOME nor ") + variable + " says where to keep them");
}

}  // namespace touchable
