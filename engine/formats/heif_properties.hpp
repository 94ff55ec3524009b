#pragma once

#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

#include "engine/formats/orientation.hpp"

namespace touchable {

/// How each picture of a HEIF file is turned and mirrored, by its number; those without such properties are
/// left out. libheif applies them and does not tell. Of a file that is cut, what is there.
std::map<std::uint32_t, Orientation> read_heif_turns(std::string_view file);

struct CodedSize {
    std::uint32_t width = 0, height = 0;
};
/// Sizes that the decoder of H.265 is set up for, of all pictures and tiles: it takes memory for these,
/// whatever else the file says.
std::vector<CodedSize> read_heif_coded_sizes(std::string_view file);

/// How pictures of a file are put together of others.
struct HeifParts {
    std::map<std::uint32_t, std::vector<std::uint32_t>> tiles;  ///< of a picture, by their numbers
    bool has_layers = false;  ///< one is another one once more (iden), or several over each other (iovl)
};
HeifParts read_heif_parts(std::string_view file);

}  // namespace touchable
