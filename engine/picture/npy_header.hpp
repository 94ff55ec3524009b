#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/number_picture.hpp"

namespace touchable {

/// What a file of NumPy's format 1.0 to 3.0 says before its data.
struct NpyHeader {
    NumberFormat format;
    bool columns_first = false;  ///< Fortran order: the first index runs fastest
    std::vector<std::int64_t> shape;
    std::size_t data_at = 0;  ///< bytes before the data
};

bool is_npy(std::string_view begin);
/// Every extent of the shape is at most 2^31.
Result<NpyHeader> read_npy_header(ByteSource& bytes, const std::string& where);

/// The pictures of an array: height x width, or a stack, count x height x width; also with 1 behind it, and
/// with 1 in any place before height.
struct NpyPictures {
    std::int64_t count = 1;
    int width = 0, height = 0;
};
Result<NpyPictures> npy_pictures(const NpyHeader& header, const std::string& where);

}  // namespace touchable
