// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading and writing of files that a person names.
//
// Reading: GivenFile is an ordinary file, opened once and never waited for without end: folders, pipes and
// devices are refused, and if a disk does not answer, only a background thread is left waiting. SourceFile
// shares one open file among readers that take turns, such as those that detect its format and the one that
// plays it. ByteSource is what a parser reads from: a file, or bytes in memory. read_given_file reads a whole
// small file. Writing: NewFile has no name until `commit`, so a file appears whole or not at all, however the
// program ends; it replaces only an ordinary file, and only if Existing says so. ScratchFolder is a temporary
// folder. CsvTable reads the tables of motions, logs and forces.
//
// Errors are lines for a person: the file's name, what is wrong, what would be right. Reads end with
// ErrorKind::interrupted once the program is asked to stop.
// Threads: one at a time may use an object.

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// A file descriptor that is closed with its owner; -1: none.
class Descriptor {
public:
    explicit Descriptor(int of = -1) : of_(of) {}
    ~Descriptor() { reset(); }
    Descriptor(Descriptor&& other) noexcept : of_(std::exchange(other.of_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(of_, other.of_);
        return *this;
    }
    int get() const { return of_; }
    void reset() {
        if (of_ >= 0) ::close(of_);
        of_ = -1;
    }

private:
    int of_;
};
/// Ends a wait in poll, from any thread; its descriptor is -1 if the system has none left.
class Wake : NonCopyable {
public:
    int descriptor() const { return event_.get(); }
    void forget() const {
        eventfd_t ignored = 0;
        (void)::eventfd_read(descriptor(), &ignored);
    }
    void wake() const { (void)::eventfd_write(descriptor(), 1); }

private:
    const Descriptor event_{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
};
/// Returns true if a non-blocking call failed with this errno only because it would block, or was
/// interrupted.
inline bool would_wait(int failure) {
    return failure == EAGAIN || failure == EWOULDBLOCK || failure == EINTR;
}

/// The whole number in up to eight bytes, the highest first or last.
inline std::uint64_t number_in_bytes(std::string_view bytes, bool highest_first = true) {
    std::uint64_t number = 0;
    for (std::size_t k = 0; k < bytes.size(); ++k)
        number = number << 8 | static_cast<unsigned char>(bytes[highest_first ? k : bytes.size() - 1 - k]);
    return number;
}

/// Bytes of a file, of a part of one, or in memory. Cheapest to read in order.
class ByteSource {
public:
    virtual ~ByteSource() = default;
    virtual std::uint64_t size() const = 0;
    /// Reads exactly `count` bytes from `at` on. An error does not name the source; the caller does
    /// (error_at).
    virtual Result<void> read(std::uint64_t at, char* to, std::size_t count) = 0;
};

/// An ordinary file that a person names, for reading. A folder, a pipe or a device is refused at once
/// (ErrorKind::input): reading it may have no end, and opening it may never return.
class GivenFile final : public ByteSource {
public:
    /// `named`: the file's name in messages, after the option that names it, if any; empty: the caller puts
    /// the name before the message (error_at). `right`: what was expected instead.
    static Result<GivenFile> open(const std::filesystem::path& file, const std::string& named,
                                  const std::string& right);

    /// Reads up to `count` bytes from `at` on. Returns their number, 0 at the end, or -errno. If it may not
    /// wait, it returns fewer bytes, or -EAGAIN if none is in memory yet. It may run after the GivenFile is
    /// destroyed.
    using Reading =
        std::function<std::ptrdiff_t(std::uint64_t at, char* to, std::size_t count, bool may_wait)>;
    GivenFile(Reading reading, std::uint64_t size) : reading_(std::move(reading)), size_(size) {}

    /// Size in bytes at the time of opening. Bytes appended later are ignored.
    std::uint64_t size() const override { return size_; }
    /// As ByteSource::read. Once the program is asked to stop, it reads no further (ErrorKind::interrupted)
    /// and no longer waits for a disk.
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override;

private:
    Result<void> fill(std::uint64_t at);

    Reading reading_;
    std::uint64_t size_;
    std::uint64_t block_at_ = 0;
    std::string block_;  // the last block read, from block_at_ on
};

/// A file that several readers share, such as those that detect its format and the one that plays it. The
/// first reader opens it; it stays open as long as a copy of this object exists. One thread at a time.
class SourceFile {
public:
    template <class Path>
    requires std::is_convertible_v<Path, std::filesystem::path> SourceFile(Path&& path)
        : opened_(std::make_shared<Opened>(std::filesystem::path(std::forward<Path>(path)))) {}

    /// A file that is already open; its bytes may come from anywhere.
    SourceFile(std::filesystem::path path, const GivenFile& file) : SourceFile(std::move(path)) {
        opened_->file = std::make_unique<const GivenFile>(file);
    }

    const std::filesystem::path& path() const { return opened_->path; }
    std::string string() const { return path().string(); }
    /// As GivenFile::open, but opens the file only the first time.
    Result<GivenFile> open(const std::string& right) const;
    /// Returns the whole file, as read_given_file does.
    Result<std::string> read(const std::string& right, std::size_t largest) const;

private:
    struct Opened {
        explicit Opened(std::filesystem::path of) : path(std::move(of)) {}
        const std::filesystem::path path;
        std::unique_ptr<const GivenFile> file;  // null: not opened yet
    };
    std::shared_ptr<Opened> opened_;
};

/// Returns the whole file; an error if it has more than `largest` bytes.
Result<std::string> read_given_file(const std::filesystem::path& file, const std::string& named,
                                    const std::string& right, std::size_t largest);

/// Returns "256 MiB", for example: the number in the largest unit that divides it.
std::string in_bytes(std::uint64_t bytes);

/// Reads from `bytes`, which must outlive the source.
std::unique_ptr<ByteSource> bytes_in_memory(std::string_view bytes);
/// Reads from an ordinary file, up to the size that it had when it was opened (GivenFile).
Result<std::unique_ptr<ByteSource>> bytes_of_file(const SourceFile& file);

/// Returns the first `count` bytes, fewer if the source is shorter, none if it cannot be read.
std::string first_bytes(ByteSource& bytes, std::size_t count);
std::string first_bytes(const SourceFile& file, std::size_t count);

/// What happens to an existing file with the name of an output.
enum class Existing { keep, replace };

/// A file being written that has no name until it is complete, so that the program leaves nothing behind,
/// however it ends. On a file system that requires names it has a hidden, random one beside its target, and
/// is removed unless it becomes complete.
class NewFile : NonCopyable {
public:
    /// `beside`: an existing folder on the target's file system, to write in; default: the target's own
    /// folder.
    explicit NewFile(std::filesystem::path target, Existing existing = Existing::replace,
                     const std::filesystem::path& beside = {});
    ~NewFile();

    const std::filesystem::path& target() const { return target_; }
    /// Where to write until `commit`. Before that, the writer closes its own descriptors.
    const std::filesystem::path& path() const { return path_; }
    /// Refuses a target that is a folder or a device (only a file is ever replaced), and a folder in which no
    /// file can be written. `commit` checks again.
    Result<void> check() const;
    /// As `check`, and takes the target's name: until `commit`, this object's destructor or its process's
    /// end, `hold` refuses it to others. For files that take long to write.
    Result<void> hold();
    /// Writes the whole content. An error names the target and the reason.
    Result<void> write(std::string_view text);
    /// Makes `commit` skip the wait for the disk, for a file that is soon replaced or removed.
    void need_not_last() { lasts_ = false; }
    /// Flushes the file to the disk, then names it. Fails if Existing is `keep` and a file with that name
    /// exists by now.
    Result<void> commit() { return commit_as(target_); }
    /// As `commit`, but under another name than the target's; messages still name the target.
    Result<void> commit_as(const std::filesystem::path& name);
    bool committed() const { return committed_; }

private:
    void open_unnamed(const std::filesystem::path& folder);
    void open_named(const std::filesystem::path& folder);
    /// Returns 0, or the errno that says why the file cannot have that name.
    int give_name(const std::filesystem::path& name);
    int replace(const std::filesystem::path& name);
    Error failed(int why) const;

    std::filesystem::path target_, path_;
    std::filesystem::path hidden_;  ///< its name until `commit`; empty: it has none
    Existing existing_;
    int file_ = -1;
    int failure_ = 0;  ///< errno of opening it
    Descriptor held_;  ///< the target's name
    bool committed_ = false;
    bool lasts_ = true;
};

/// A private folder for temporary files, in TMPDIR. Its destructor removes it in the process that made it;
/// the folder of a program that was killed is removed by the next one that makes one of its kind: it is this
/// user's, and no process holds its lock.
class ScratchFolder : NonCopyable {
public:
    /// An empty file in each folder, made once the folder is locked, removed last.
    static constexpr const char* mark = ".touchable";
    /// `kind`: a part of the folder's name, of plain letters.
    static Result<std::unique_ptr<ScratchFolder>> create(std::string_view kind);
    ~ScratchFolder();

    const std::filesystem::path& path() const { return path_; }

private:
    explicit ScratchFolder(std::filesystem::path path);
    std::filesystem::path path_;
    int owner_;        ///< process that made it
    Descriptor held_;  ///< the folder, locked
};

/// The user's folder for this program: `touchable` in the folder that environment variable `variable` names,
/// else in `in_home` of the home folder. It need not exist. Fails if neither is set.
Result<std::filesystem::path> own_folder(const char* variable, const char* in_home);
/// A name in `folder` that no other file has and no other program can foresee.
std::filesystem::path hidden_name(const std::filesystem::path& folder);
/// A message that calls a hidden or temporary path by the name that a person knows.
std::string shown_as(std::string message, const std::filesystem::path& hidden,
                     const std::filesystem::path& name);
/// Moves a file or folder to a name that must be free. Returns 0 or an errno.
int move_to_free_name(const std::filesystem::path& from, const std::filesystem::path& to);
/// The errno of a flush to the disk that returned `done`; 0 where a pipe or a file system cannot flush.
inline int failed_sync(int done) {
    const bool cannot = errno == EINVAL || errno == ENOSYS || errno == EOPNOTSUPP || errno == EROFS;
    return done == 0 || cannot ? 0 : errno;
}
/// Flushes a file, or the names in a folder, to the disk. Returns 0 or an errno.
[[nodiscard]] int sync_path(const std::filesystem::path& path);
/// Flushes the names in `folder` to the disk, where `what` has its name by now. An error says so.
Result<void> sync_names(const std::filesystem::path& folder, const std::filesystem::path& what);

/// A table of numbers in text, with or without a header, its fields separated by commas, semicolons, tabs or
/// blanks. Every row has the same number of fields; a field may stand in double quotes; columns that are not
/// read may hold anything; blank lines at the end do not count.
class CsvTable {
public:
    /// Refuses (ErrorKind::input, with file and line) a file that cannot be read, exceeds 256 MiB or ten
    /// million rows, is no text, or has rows of different lengths or no row of data. The first line is a
    /// header if one of its fields is not a number.
    static Result<CsvTable> read(const std::string& file);

    std::size_t rows() const { return lines_.size() - (has_header_ ? 1 : 0); }
    std::size_t columns() const { return first_.size(); }
    /// Whether the header has this column.
    bool names(std::string_view column) const {
        return has_header_ && std::ranges::find(first_, column) != first_.end();
    }
    /// Index of a column by its name in the header or its number, from 1. Refuses others, listing the legal
    /// ones.
    Result<std::size_t> column(std::string_view name_or_number) const;
    /// All values of a column, in order. Refuses (file, line, column) a value that is not a finite number.
    /// `may_be_empty`: an empty field is NaN.
    Result<std::vector<double>> numbers(std::size_t column, bool may_be_empty = false) const;
    /// "FILE: line N" of row `row`, for messages.
    std::string place(std::size_t row) const {
        return file_ + ": line " + std::to_string(row + (has_header_ ? 2 : 1));
    }
    const std::string& file() const { return file_; }

private:
    CsvTable() = default;
    Result<void> find_lines();
    Result<void> check_fields();
    std::size_t fields_by(char separator);
    void choose_separator();
    std::string_view line(std::size_t number) const {
        std::string_view line(*text_);
        line.remove_prefix(lines_[number]);
        line = line.substr(0, line.find('\n'));
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }
    /// Splits a line into `fields`, replacing them. Error: what is wrong with the line.
    Result<void> split(std::string_view line, std::vector<std::string_view>& fields) const;

    std::string file_;
    std::shared_ptr<const std::string> text_;  // its address stays, copied or moved
    std::vector<std::uint32_t> lines_;         // start of each line
    std::vector<std::string_view> first_;      // fields of the first line
    char separator_ = ',';                     // a blank: any number of blanks and tabs
    bool has_header_ = false;
};

}  // namespace touchable
