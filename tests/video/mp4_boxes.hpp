// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace touchable::test {

/// A box of an MP4 file, as ISO/IEC 14496-12 has it and not as the code under test does.
struct FoundBox {
    std::string type;
    std::size_t at = 0, content = 0, end = 0;  ///< of the whole file, with the first byte of what is in it
};

/// The boxes between two places of a file; fails the test where they are not boxes that fill it.
std::vector<FoundBox> boxes_between(const std::string& file, std::size_t begin, std::size_t end);
std::vector<FoundBox> boxes_of(const std::string& file);
/// In a box, by types; fails the test where there is none. Of a table with a head, `skipped` bytes later.
FoundBox box_at(const std::string& file, const FoundBox& in, const std::vector<std::string>& path);
std::vector<FoundBox> boxes_named(const std::string& file, const FoundBox& in, std::string_view type);

std::uint64_t number_in(const std::string& file, std::size_t at, int bytes);
std::string bytes_in(const std::string& file, const FoundBox& box);
std::string hex_digits(const std::string& bytes);

/// The tracks of a file (trak), in order; and one's handler ("vide").
std::vector<FoundBox> tracks_in(const std::string& file);
std::string handler_of(const std::string& file, const FoundBox& track);
std::uint64_t id_of(const std::string& file, const FoundBox& track);
/// The only sample of a track of MPEG-4 Systems.
std::string sample_of(const std::string& file, const FoundBox& track);

/// A file without boxes of these types in its movie box, which is the last.
std::string without_in_movie(const std::string& file, const std::vector<std::string>& types);

/// Four bytes, the highest first.
std::string word(std::size_t value);

}  // namespace touchable::test
