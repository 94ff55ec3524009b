#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "engine/base/result.hpp"

namespace touchable {

/// An ordinary file that a person names, to be read. What is a folder, a pipe or a device is refused at once
/// (ErrorKind::input): reading it may have no end, and opening it may wait for somebody for ever.
class GivenFile {
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
    std::uint64_t size() const { return size_; }
    /// All of `count` bytes from `at` on, or what went wrong, after a colon behind the name. Once somebody
    /// asks the program to stop it reads no further (ErrorKind::interrupted), and waits for no disk either.
    Result<void> read(std::uint64_t at, char* to, std::size_t count);

private:
    Result<void> fill(std::uint64_t at);

    Reading reading_;
    std::uint64_t size_;
    std::uint64_t block_at_ = 0;
    std::string block_;  // what was read last, from there on
};

/// A file that several read, such as those who find out what it is and the one who plays it: the first of
/// them opens it, and nobody does again as long as a copy of this is there. One thread at a time.
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
        std::unique_ptr<const GivenFile> file;  // null: nobody did yet
    };
    std::shared_ptr<Opened> opened_;
};

/// All of such a file; of more than `largest` bytes nothing.
Result<std::string> read_given_file(const std::filesystem::path& file, const std::string& named,
                                    const std::string& right, std::size_t largest);

/// "256 MiB" of a number of bytes, in the largest unit of which they are a whole number.
std::string in_bytes(std::uint64_t bytes);

}  // namespace touchable
