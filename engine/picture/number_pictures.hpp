#pragma once

// Pictures that are arrays of numbers: how their numbers are held in a file, and their readers (PGM, PPM,
// PFM, TIFF, NumPy).
//
// A reader finds out the NumberFormat, puts blocks of numbers into a NumberPicture, and finishes it: codes
// stay as they are, and what has other numbers becomes a picture of floats. Readers take the bytes of a file;
// errors begin with `where`. A NumberPicture is one thread's, the functions are any thread's.

#include <cstddef>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// How a file holds the numbers of a picture.
struct NumberFormat {
    enum class Kind { unsigned_integer, signed_integer, floating };
    Kind kind = Kind::unsigned_integer;
    int bytes = 1;  ///< integers 1, 2, 4 or 8; floating 2, 4 or 8
    bool big_endian = false;
};

/// Numbers in memory, with the bytes from one to the next of its row and of its column, which may be
/// negative.
struct NumberBlock {
    const char* first;
    int width, height;
    std::ptrdiff_t column_step, row_step;
};

/// A picture that is filled with numbers block by block.
class NumberPicture {
public:
    /// No side is larger than `largest_picture_side`. Where it is asked to stop meanwhile it takes no
    /// numbers, and is one pixel when it is finished.
    NumberPicture(int width, int height, const NumberFormat& format);
    /// With its upper left number at x, y. The block lies within the picture.
    void put(int x, int y, const NumberBlock& block);
    /// Whether all numbers so far are stored as they are: integers from 0 to 65535.
    bool has_codes() const { return codes_; }
    /// Unsigned integers of 8 and 16 bits as they are. Other integers become 16 bits where all fit, and else
    /// floats, which floating numbers are in any case, rounded to the nearest. Unfinished where it is asked
    /// to stop meanwhile.
    StoredImage finish(const std::string& codec, bool floats_anyway = false) &&;

private:
    template <class Number>
    void put_as(int x, int y, const NumberBlock& block);
    bool stored_as_codes() const {
        return format_.kind == NumberFormat::Kind::unsigned_integer && format_.bytes <= 2;
    }

    NumberFormat format_;
    StoredImage picture_;
    bool codes_, is_whole_ = false;
};

/// PGM and PPM, binary (P5, P6) and text (P2, P3). Samples are as stored, however large the greatest may be.
Result<StoredImage> decode_netpbm(std::string_view bytes, const std::string& where);

/// PFM with one float a pixel ("Pf"), of either byte order. Its scale is not multiplied in.
Result<StoredImage> decode_pfm(std::string_view bytes, const std::string& where);

bool is_tiff(std::string_view begin);

/// The first page: grey of integers or floats of 8 to 64 bits, colour of 8 (of 16 where it is grey). Other
/// samples of a pixel, such as alpha, are dropped.
Result<StoredImage> decode_tiff(std::string_view bytes, const std::string& where);

bool is_npy(std::string_view begin);
/// The one picture of a .npy file.
Result<StoredImage> decode_npy(std::string_view bytes, const std::string& where);

bool is_npz(std::string_view begin);
/// The same of a .npz file, which is a zip archive of .npy files: of the array that depth is read from.
Result<StoredImage> decode_npz(std::string_view bytes, const std::string& where);

}  // namespace touchable
