// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

/// The input of h5import for a data set.
struct Hdf5Numbers {
    std::string path;  ///< without the slash before it
    std::vector<int> shape;
    std::string kind = "UIN";  ///< UIN, IN or FP
    int bits = 16;
    std::string order = "LE";  ///< of the numbers in the file: LE or BE
    std::string more{};        ///< further lines for h5import
};

/// The numbers first, first + 1, ... as native ones, as h5import takes them.
inline std::string counted(const Hdf5Numbers& of, int first) {
    std::size_t count = 1;
    for (const int extent : of.shape) count *= static_cast<std::size_t>(extent);
    std::string bytes;
    for (std::size_t k = 0; k < count; ++k) {
        const auto add = [&](auto number) {
            bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
        };
        const auto number = static_cast<std::int64_t>(k) + first;
        if (of.kind == "FP" && of.bits == 32)
            add(static_cast<float>(number));
        else if (of.kind == "FP")
            add(static_cast<double>(number));
        else
            bytes.append(reinterpret_cast<const char*>(&number), static_cast<std::size_t>(of.bits / 8));
    }
    return bytes;
}

/// Adds a data set of these native numbers to an HDF5 file, which need not be there, by h5import. False: that
/// is not installed.
inline bool add_data_set(const std::filesystem::path& file, const Hdf5Numbers& of,
                         const std::string& numbers) {
    static_assert(std::endian::native == std::endian::little);
    const TemporaryFolder folder;
    std::ostringstream lines;
    lines << "PATH " << of.path << "\nINPUT-CLASS " << of.kind << "\nINPUT-SIZE " << of.bits << "\nRANK "
          << of.shape.size() << "\nDIMENSION-SIZES";
    for (const int extent : of.shape) lines << ' ' << extent;
    lines << "\nOUTPUT-CLASS " << of.kind << "\nOUTPUT-SIZE " << of.bits << "\nOUTPUT-ARCHITECTURE "
          << (of.kind == "FP" ? "IEEE" : "STD") << "\nOUTPUT-BYTE-ORDER " << of.order << '\n'
          << of.more;
    write_bytes(folder / "numbers", numbers);
    write_bytes(folder / "settings", lines.str());
    const std::string command = "h5import '" + (folder / "numbers").string() + "' -c '" +
                                (folder / "settings").string() + "' -o '" + file.string() +
                                "' >/dev/null 2>&1";
    return std::system(command.c_str()) == 0;
}

/// The same of first, first + 1, ...
inline bool add_data_set(const std::filesystem::path& file, const Hdf5Numbers& of, int first = 1) {
    return add_data_set(file, of, counted(of, first));
}

/// Puts a block of 512 bytes before an HDF5 file, as MATLAB's 7.3 does.
inline void put_matlab_before(const std::filesystem::path& hdf5, const std::filesystem::path& file) {
    const TemporaryFolder folder;
    std::string block =
        "MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Fri Nov 27 2026 HDF5 schema 1.00 .";
    block.resize(512, ' ');
    write_bytes(folder / "block", block);
    const std::string command = "h5jam -u '" + (folder / "block").string() + "' -i '" + hdf5.string() +
                                "' -o '" + file.string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
}

}  // namespace touchable::test
