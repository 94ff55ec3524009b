#pragma once

#include <filesystem>

#include "engine/result.hpp"

namespace touchable {

/// What FFmpeg's demuxer does not tell: whether a Matroska file is whole (its segment is as long as it says),
/// and whether its headers, tags and attachments are as they were written (their CRC-32, where they carry
/// one). Clusters are skipped: decoding finds what is wrong with them. Says "file: what is wrong".
Result<void> check_matroska(const std::filesystem::path& file);

}  // namespace touchable
