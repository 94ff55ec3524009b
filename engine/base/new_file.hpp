#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

/// What becomes of a file that has an output's name already.
enum class Existing { keep, replace };

/// A file being written that has no name until it is complete, so that whatever ends the program leaves
/// nothing behind. Where a file system knows only files with names, it has a hidden, random one beside its
/// target, and is removed where it never becomes complete.
class NewFile {
public:
    /// `beside`: an existing folder of the target's file system; the target's own where it is left out.
    explicit NewFile(std::filesystem::path target, Existing existing = Existing::replace,
                     const std::filesystem::path& beside = {});
    ~NewFile();
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    const std::filesystem::path& target() const { return target_; }
    /// Where to write until `commit`. Closed by whoever opened it before that.
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

/// A name that nobody else has or can foresee, in `folder`.
std::filesystem::path hidden_name(const std::filesystem::path& folder);
/// Moves a file or folder to a name that must be free: 0, or why not (errno).
int move_to_free_name(const std::filesystem::path& from, const std::filesystem::path& to);
/// Makes names in `folder` last, as far as its file system can.
void sync_folder(const std::filesystem::path& folder);

}  // namespace touchable
