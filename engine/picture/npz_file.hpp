#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// A .npy file inside a .npz file, which is a zip archive.
struct NpzMember {
    std::unique_ptr<ByteSource> bytes;  ///< keeps the archive open
    std::string where;                  ///< both names, as messages begin
    /// An array of pictures named conf or confidence, which networks write beside depth; null: there is none.
    std::unique_ptr<ByteSource> confidence{};
};

bool is_npz(std::string_view begin);

/// The array that depth is read from: the only one; else the one that is named depth, or the only one whose
/// name begins so; else the only one of pictures. Otherwise the error names all. Messages begin with `where`.
Result<NpzMember> open_npz(std::unique_ptr<ByteSource> archive, const std::string& where);
/// The same of an archive in memory, which outlives it.
Result<NpzMember> depth_member(std::string_view archive, const std::string& where);

}  // namespace touchable
