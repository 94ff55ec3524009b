#pragma once

// Git LFS keeps a small text in place of a large file until that is fetched. Pure functions, for any thread.

#include <string_view>

namespace touchable {

/// Whether a file is such a pointer, by its first 64 bytes.
inline bool is_git_lfs_pointer(std::string_view begin) {
    return begin.starts_with("version https://git-lfs.github.com/spec/") ||
           begin.starts_with("version https://hawser.github.com/spec/");  // its name before 2014
}

/// What is said of such a file behind its name.
inline constexpr const char* git_lfs_words =
    "is a Git LFS pointer in place of the file itself: git lfs pull, in its repository, fetches all of them";

}  // namespace touchable
