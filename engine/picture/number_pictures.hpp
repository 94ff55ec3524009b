// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures that are arrays of numbers: how their numbers are held in a file, and their readers (PGM, PPM,
// PFM, dpt, TIFF, NumPy, HDF5).
//
// A reader finds out the NumberFormat, puts blocks of numbers into a NumberPicture, and finishes it: codes
// stay as they are, and what has other numbers becomes a picture of floats. Readers take the bytes of a file;
// errors begin with `where`. A NumberPicture is one thread's, the functions are any thread's.

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/base/words.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// How a file holds the numbers of a picture.
struct NumberFormat {
    enum class Kind { unsigned_integer, signed_integer, floating };
    Kind kind = Kind::unsigned_integer;
    int bytes = 1;  ///< integers 1, 2, 4 or 8; floating 2, 4 or 8
    bool big_endian = false;

    /// Whether a picture of these numbers stays as it is stored: integers from 0 to 65535.
    bool is_codes() const { return kind == Kind::unsigned_integer && bytes <= 2; }
    /// Whether these numbers tell alone how pictures of them are stored: as codes or as floats.
    bool is_decided() const { return is_codes() || kind == Kind::floating; }
};

/// A number as a file holds it; NaN for a floating number of two bytes.
double stored_number(const char* bytes, const NumberFormat& format);

/// The pictures of an array: height x width, or a stack, count x height x width; also with a last extent of
/// 1, and with extents of 1 before height.
struct ArrayPictures {
    std::int64_t count = 1;
    int width = 0, height = 0;
};
/// What makes a picture of an array of points.
inline constexpr std::string_view depth_of_points = "numpy.save('depth.npy', array[..., 2]) keeps depth";
/// The pictures of an array with these extents. Refuses other shapes, and sides beyond
/// `largest_picture_side`.
Result<ArrayPictures> pictures_of_array(const std::vector<std::int64_t>& extents, const std::string& where);
/// "3x480x640".
std::string shape_text(const std::vector<std::int64_t>& extents);

/// An array of a file that has several: a data set of HDF5, or a member of a .npz.
struct NamedArray {
    std::string name;  ///< in HDF5 a path, whose last part counts
    std::vector<std::int64_t> shape;
    std::optional<NumberFormat> format;  ///< nullopt: it has no numbers that are read
    bool is_boolean = false;

    std::string in_words() const { return printable(name) + " of " + shape_text(shape); }
};
/// Whether the last part of its name has the word depth.
bool has_depth_in_name(const NamedArray& array);
/// Whether it is, by name or type, a confidence or a mask of depth.
bool is_trust_of_depth(const NamedArray& array);
/// Whether it may be depth by its name, its shape and its numbers: not colour, camera, normals, confidence or
/// mask, and not a narrow table, unless that is named depth.
bool may_be_depth(const NamedArray& array);
/// The places of depth's arrays. One: the only one named depth; else the only one whose name begins with it;
/// else the only one with depth in its name; else the only one that may be depth. Several: a row of one
/// picture each, of one size and type, whose names differ by a number alone, in the order of their numbers.
/// Empty if none may be depth. The error of several begins with "has", and calls each a `what`.
Result<std::vector<std::size_t>> depth_among(std::span<const NamedArray> arrays, const std::string& what);
/// Whether it may be colour, which is not read.
bool is_colour(const NamedArray& array);
/// Names of at most eight arrays, in words.
std::string some_of(std::span<const NamedArray> arrays);

/// Numbers in memory, with the bytes to the next number of a row and of a column, which may be negative.
struct NumberBlock {
    const char* first;
    int width, height;
    std::ptrdiff_t column_step, row_step;
};

/// A picture that is filled with numbers block by block.
class NumberPicture {
public:
    /// Sides are `largest_picture_side` at most. After a stop meanwhile it takes no numbers, and finishes as
    /// one pixel.
    NumberPicture(int width, int height, const NumberFormat& format);
    /// Puts the block's upper left number at x, y. The block lies within the picture.
    void put(int x, int y, const NumberBlock& block);
    /// Unsigned integers of 8 and 16 bits stay as they are. Other integers become 16 bits if all fit and not
    /// `floats_anyway`, otherwise floats; floating numbers become floats, rounded to the nearest. Unfinished
    /// if a stop comes meanwhile.
    StoredImage finish(const std::string& codec, bool floats_anyway = false) &&;

private:
    template <class Number>
    void put_as(int x, int y, const NumberBlock& block);

    NumberFormat format_;
    StoredImage picture_;
    bool codes_, is_whole_ = false;
};

/// PGM and PPM, binary (P5, P6) and text (P2, P3). Samples stay as stored, whatever the greatest value.
Result<StoredImage> decode_netpbm(std::string_view bytes, const std::string& where);

/// PFM with one float a pixel ("Pf"), of either byte order. Its scale is not multiplied in.
Result<StoredImage> decode_pfm(std::string_view bytes, const std::string& where);

/// Sintel's and Middlebury's floats: "PIEH", width, height, floats of one channel, the lowest byte first.
Result<StoredImage> decode_dpt(std::string_view bytes, const std::string& where);

bool is_tiff(std::string_view begin);

/// The first page, or if that is in colour the first in grey of more than 8 bits, if any: grey of integers or
/// floats of 8 to 64 bits, colour of 8 (of 16 if it is grey). Further samples of a pixel, such as alpha, are
/// dropped.
Result<StoredImage> decode_tiff(std::string_view bytes, const std::string& where);

bool is_npy(std::string_view begin);
/// The one picture of a .npy file.
Result<StoredImage> decode_npy(std::string_view bytes, const std::string& where);

bool is_npz(std::string_view begin);
/// The same for a .npz file, a zip archive of .npy files: the array that depth is read from.
Result<StoredImage> decode_npz(std::string_view bytes, const std::string& where);

/// A data set of an HDF5 file, as h5ls (-r -v) lists it.
struct Hdf5DataSet {
    std::string path;                      ///< from the root on: "/data/demo_0/obs/depth"
    std::vector<std::int64_t> shape{};     ///< each extent 2^31 at most
    std::optional<NumberFormat> format{};  ///< nullopt: it has no numbers of 8 to 64 bits
    std::string type{};                    ///< h5ls's words for it
    std::string packed_by{};               ///< h5ls's words for its filters
    bool is_elsewhere = false;             ///< its numbers are in other files
    std::uint64_t chunk_bytes = 0;         ///< of a chunk, unpacked; 0: it has none
};
/// All data sets that are arrays, in order. Refuses a listing with a name twice, or in no group.
Result<std::vector<Hdf5DataSet>> hdf5_data_sets(std::string_view listing);

bool is_hdf5(std::string_view begin);
/// Refuses: HDF5 is only read as a file (open_hdf5_stack).
Result<StoredImage> refuse_hdf5(std::string_view bytes, const std::string& where);

}  // namespace touchable
