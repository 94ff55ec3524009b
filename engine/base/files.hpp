#pragma once

// Files that a person names, read and written.
//
// Reading: GivenFile is an ordinary file, opened once and never waited for without end: folders, pipes and
// devices are refused, and a disk that does not answer keeps only a thread that is left behind. SourceFile is
// the same file for several readers one after the other, such as those that find out what it is and the one
// that plays it. ByteSource is where a parser reads from: a file, or bytes in memory. read_given_file takes
// all of a small file at once. Writing: NewFile has no name until `commit`, so a file appears whole or not at
// all, however the program ends; it replaces nothing but an ordinary file, and only where it was told to
// (Existing).
//
// Errors are lines for a person: the file's name, what is wrong, what would be right. Reads end with
// ErrorKind::interrupted once the program is asked to stop. One thread at a time may use an object.

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>
#include <type_traits>

#include "engine/base/result.hpp"

namespace touchable {

/// A descriptor of the system that is closed with its owner; -1: none.
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
/// Whether a call on one that does not wait failed, with this errno, only because it would have had to.
inline bool would_wait(int failure) {
    return failure == EAGAIN || failure == EWOULDBLOCK || failure == EINTR;
}

/// Bytes of a file, of a part of one, or in memory. Cheapest to read in order.
class ByteSource {
public:
    virtual ~ByteSource() = default;
    virtual std::uint64_t size() const = 0;
    /// All of `count` bytes from `at` on, or what went wrong, after a colon behind the name (error_at).
    virtual Result<void> read(std::uint64_t at, char* to, std::size_t count) = 0;
};

/// An ordinary file that a person names, to be read. What is a folder, a pipe or a device is refused at once
/// (ErrorKind::input): reading it may have no end, and opening it may never return.
class GivenFile final : public ByteSource {
public:
    /// `named`: the file as messages name it, behind the option that names it, if one does; empty: the caller
    /// puts the name before the message (error_at). `right`: what would be right.
    static Result<GivenFile> open(const std::filesystem::path& file, const std::string& named,
                                  const std::string& right);

    /// Up to `count` bytes from `at` on: how many, 0 at the end, or -errno. Where it may not wait, less than
    /// there is, or -EAGAIN of what is not in memory yet. It may be called when the file is gone.
    using Reading =
        std::function<std::ptrdiff_t(std::uint64_t at, char* to, std::size_t count, bool may_wait)>;
    GivenFile(Reading reading, std::uint64_t size) : reading_(std::move(reading)), size_(size) {}

    /// Bytes that there were when it was opened. What is written behind them later is not of it.
    std::uint64_t size() const override { return size_; }
    /// As of any ByteSource. Once the program is asked to stop it reads no further (ErrorKind::interrupted),
    /// and waits for no disk either.
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override;

private:
    Result<void> fill(std::uint64_t at);

    Reading reading_;
    std::uint64_t size_;
    std::uint64_t block_at_ = 0;
    std::string block_;  // what was read last, from there on
};

/// A file that several readers share, such as those that find out what it is and the one that plays it: the
/// first of them opens it, and it stays open as long as a copy of this is there. One thread at a time.
class SourceFile {
public:
    template <class Path>
    requires std::is_convertible_v<Path, std::filesystem::path> SourceFile(Path&& path)
        : opened_(std::make_shared<Opened>(std::filesystem::path(std::forward<Path>(path)))) {}

    /// One that is open already, wherever its bytes are.
    SourceFile(std::filesystem::path path, const GivenFile& file) : SourceFile(std::move(path)) {
        opened_->file = std::make_unique<const GivenFile>(file);
    }

    const std::filesystem::path& path() const { return opened_->path; }
    std::string string() const { return path().string(); }
    /// As GivenFile::open, of what was there when it was opened first.
    Result<GivenFile> open(const std::string& right) const;
    /// All of it, as read_given_file.
    Result<std::string> read(const std::string& right, std::size_t largest) const;

private:
    struct Opened {
        explicit Opened(std::filesystem::path of) : path(std::move(of)) {}
        const std::filesystem::path path;
        std::unique_ptr<const GivenFile> file;  // null: not opened yet
    };
    std::shared_ptr<Opened> opened_;
};

/// All of such a file; of more than `largest` bytes nothing.
Result<std::string> read_given_file(const std::filesystem::path& file, const std::string& named,
                                    const std::string& right, std::size_t largest);

/// "256 MiB" of a number of bytes, in the largest unit of which they are a whole number.
std::string in_bytes(std::uint64_t bytes);

/// Bytes that outlive it.
std::unique_ptr<ByteSource> bytes_in_memory(std::string_view bytes);
/// Of an ordinary file, as long as it was when it was opened (GivenFile).
Result<std::unique_ptr<ByteSource>> bytes_of_file(const SourceFile& file);

/// What a source begins with, `count` bytes or all that there are; nothing where it cannot be read.
std::string first_bytes(ByteSource& bytes, std::size_t count);
std::string first_bytes(const SourceFile& file, std::size_t count);

/// What becomes of a file that has an output's name already.
enum class Existing { keep, replace };

/// A file being written that has no name until it is complete, so that the program leaves
/// nothing behind, however it ends. Where a file system knows only files with names, it has a hidden, random
/// one beside its target, and is removed where it never becomes complete.
class NewFile : NonCopyable {
public:
    /// `beside`: an existing folder of the target's file system; the target's own where it is left out.
    explicit NewFile(std::filesystem::path target, Existing existing = Existing::replace,
                     const std::filesystem::path& beside = {});
    ~NewFile();

    const std::filesystem::path& target() const { return target_; }
    /// Where to write until `commit`. The writer closes what it opened before that.
    const std::filesystem::path& path() const { return path_; }
    /// Refuses a target that is a folder or a device: only a file is ever replaced; and a place where nothing
    /// can be written. `commit` looks again.
    Result<void> check() const;
    /// All that it shall hold, at once. An error names the target and the reason.
    Result<void> write(std::string_view text);
    /// `commit` does not wait for the disk: of a file that is soon replaced or removed.
    void need_not_last() { lasts_ = false; }
    /// Safe on the disk first, then named. Refused where `keep` was asked for and there is such a file by
    /// now.
    Result<void> commit() { return commit_as(target_); }
    /// The same under another name than the target's, which messages still speak of.
    Result<void> commit_as(const std::filesystem::path& name);
    bool committed() const { return committed_; }

private:
    void open_unnamed(const std::filesystem::path& folder);
    void open_named(const std::filesystem::path& folder);
    /// 0, or why it cannot have that name (errno).
    int give_name(const std::filesystem::path& name);
    int replace(const std::filesystem::path& name);
    Error failed(int why) const;

    std::filesystem::path target_, path_;
    std::filesystem::path hidden_;  ///< its name until `commit`; empty: it has none
    Existing existing_;
    int file_ = -1;
    int failure_ = 0;  ///< errno of opening it
    bool committed_ = false;
    bool lasts_ = true;
};

/// This program's folder of a person: `touchable` in the folder that the environment's `variable` names,
/// else in `in_home` of the home folder. It need not exist. Fails if there is neither.
Result<std::filesystem::path> own_folder(const char* variable, const char* in_home);
/// A name in `folder` that no other file has and no other program can foresee.
std::filesystem::path hidden_name(const std::filesystem::path& folder);
/// Moves a file or folder to a name that must be free: 0, or why not (errno).
int move_to_free_name(const std::filesystem::path& from, const std::filesystem::path& to);
/// Makes names in `folder` last, as far as its file system can.
void sync_folder(const std::filesystem::path& folder);

}  // namespace touchable
