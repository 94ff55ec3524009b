#pragma once

#include <zip.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace touchable::test {

/// The header of a .npy file, as NumPy writes it.
inline std::string npy_header(const std::string& type, const std::string& shape) {
    std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    text.resize(117, ' ');
    return std::string("\x93NUMPY\1\0v\0", 10) + text + '\n';
}

/// A .npy file of floats of 32 bits.
inline std::string npy_bytes(const std::string& shape, const std::vector<float>& numbers) {
    return npy_header("<f4", shape).append(reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size());
}

/// A .npz file of such arrays, packed.
inline void write_npz(const std::filesystem::path& file,
                      const std::vector<std::pair<std::string, std::string>>& arrays) {
    zip_t* const archive = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
    for (const auto& [name, bytes] : arrays)
        zip_file_add(archive, (name + ".npy").c_str(),
                     zip_source_buffer(archive, bytes.data(), bytes.size(), 0), ZIP_FL_OVERWRITE);
    zip_close(archive);
}

}  // namespace touchable::test
