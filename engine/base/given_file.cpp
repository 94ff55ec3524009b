#include "engine/base/given_file.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <tuple>
#include <utility>

#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"

namespace touchable {
namespace {

/// Read at once, so that a few bytes after the other are not a call of the system each.
constexpr std::uint64_t block_bytes = 1 << 16;

/// What it is, where it is no ordinary file.
const char* other_kind(mode_t mode) {
    if (S_ISDIR(mode)) return "is a folder";
    if (S_ISFIFO(mode)) return "is a pipe, no ordinary file";
    if (S_ISSOCK(mode)) return "is a socket, no ordinary file";
    return "is a device, no ordinary file";
}

std::string words_of(int error) {
    return error == ENOENT ? "is not there"
                           : "cannot be read (" + std::generic_category().message(error) + ")";
}

/// Behind the file's name, where there is one.
Error named_error(const std::string& named, const std::string& why) {
    return input_error(named.empty() ? why : named + ": " + why);
}

Error interrupted_reading() {
    return {ErrorKind::interrupted, "interrupted while it was read"};
}

/// A file that is open as long as anybody reads it.
class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {
        struct statfs system = {};
        in_memory_ = fstatfs(number, &system) == 0 && system.f_type == TMPFS_MAGIC;
    }
    ~Descriptor() { close(number_); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

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
    bool in_memory_;  // its file system is, and need not know how to read without waiting
};

}  // namespace

Result<GivenFile> GivenFile::open(const std::filesystem::path& file, const std::string& named,
                                  const std::string& right) {
    const auto refused = [&](const std::string& why) {
        return named_error(named, why + "; right would be " + right);
    };
    // Opening a device may do something to it, so first a look; then another, at what was opened.
    struct stat about = {};
    if (stat(file.c_str(), &about) != 0) return refused(words_of(errno));
    if (!S_ISREG(about.st_mode)) return refused(other_kind(about.st_mode));
    const int number = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (number < 0) return refused(words_of(errno));
    const auto opened = std::make_shared<const Descriptor>(number);
    if (fstat(number, &about) != 0) return refused(words_of(errno));
    if (!S_ISREG(about.st_mode)) return refused(other_kind(about.st_mode));
    return GivenFile([opened](std::uint64_t at, char* to, std::size_t count,
                              bool may_wait) { return opened->read(at, to, count, may_wait); },
                     static_cast<std::uint64_t>(about.st_size));
}

/// What is in memory already comes at once. For a disk, which may be at the other end of a network that has
/// failed, another thread waits.
Result<void> GivenFile::fill(std::uint64_t at) {
    if (stop_requested()) return interrupted_reading();
    const auto count = static_cast<std::size_t>(std::min(block_bytes, size_ - at));
    std::string block(count, '\0');
    std::ptrdiff_t got = reading_(at, block.data(), count, false);
    if (got < 0) {
        auto came = unless_stopped([reading = reading_, at, count] {
            std::string bytes(count, '\0');
            const std::ptrdiff_t here = reading(at, bytes.data(), count, true);
            return std::pair(std::move(bytes), here);
        });
        if (!came) return interrupted_reading();
        std::tie(block, got) = std::move(*came);
    }
    block.resize(static_cast<std::size_t>(std::max<std::ptrdiff_t>(got, 0)));
    block_ = std::move(block);
    block_at_ = at;
    if (got == -ETIMEDOUT) return input_error("cannot be read: its server sends it too slowly");
    if (got < 0)
        return input_error("cannot be read: " + std::generic_category().message(static_cast<int>(-got)));
    return got > 0 ? Result<void>() : input_error("is cut short");
}

Result<void> GivenFile::read(std::uint64_t at, char* to, std::size_t count) {
    if (at > size_ || count > size_ - at) return input_error("is cut short");
    while (count > 0) {
        if (at < block_at_ || at - block_at_ >= block_.size())
            if (auto filled = fill(at); !filled) return filled;
        const auto from = static_cast<std::size_t>(at - block_at_);
        const std::size_t some = std::min(count, block_.size() - from);
        std::memcpy(to, block_.data() + from, some);
        at += some;
        to += some;
        count -= some;
    }
    return {};
}

namespace {

Result<std::string> all_of(Result<GivenFile> given, const std::string& named, const std::string& right,
                           std::size_t largest) {
    if (!given) return given.error();
    if (given->size() > largest)
        return named_error(named, "is larger than " + in_bytes(largest) + "; right would be " + right);
    std::string bytes(static_cast<std::size_t>(given->size()), '\0');
    if (auto read = given->read(0, bytes.data(), bytes.size()); !read)
        return named.empty() ? read.error() : error_at(named, read.error());
    return bytes;
}

}  // namespace

Result<std::string> read_given_file(const std::filesystem::path& file, const std::string& named,
                                    const std::string& right, std::size_t largest) {
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

}  // namespace touchable
