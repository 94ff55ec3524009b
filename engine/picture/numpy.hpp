#pragma once

// Arrays of numbers as NumPy writes them: .npy, and .npz, which is a zip archive of these.
//
// open_npy_stack opens either as an ImageStack, whose pictures are read one by one: height x width, or a
// stack of such. Of an archive the array that depth is read from is found by its name and shape, and a
// confidence beside it leaves out what is not to be trusted (ImageStack::trust). decode_npy and decode_npz
// are the one picture of a file in memory. What a header says is checked before memory is taken for it.
//
// An ImageStack is one thread's. Errors begin with the file's name (ErrorKind::input).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"

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

/// The pictures of an array of numbers, read one by one.
class ImageStack {
public:
    /// Of the bytes of a .npy file; messages begin with `where`.
    static Result<ImageStack> of(std::unique_ptr<ByteSource> bytes, std::string where);

    std::int64_t count() const { return pictures_.count; }
    int width() const { return pictures_.width; }
    int height() const { return pictures_.height; }
    /// From 0 on. All are alike: floats where any picture has a number that is no integer from 0 to 65535.
    Result<StoredImage> image(std::int64_t number);

    /// Where `confidence`, which is of the same pictures, is below `least` there is no depth: NaN, of
    /// integers 0. Without `least` that is half of the median of the first picture's. Of other pictures it is
    /// refused.
    Result<void> trust(ImageStack confidence, std::optional<double> least);
    /// It, where there is a confidence.
    std::optional<double> least_confidence() const { return least_confidence_; }

private:
    ImageStack(std::unique_ptr<ByteSource> bytes, std::string where, NpyHeader header, NpyPictures pictures);
    Result<void> check() const;
    Result<void> find_floats();
    Result<NumberPicture> read(std::int64_t number);

    std::unique_ptr<ByteSource> bytes_;
    std::string where_;
    NpyHeader header_;
    NpyPictures pictures_;
    bool floats_ = false;
    std::unique_ptr<ImageStack> confidence_;
    std::optional<double> least_confidence_;
};

/// Of a .npy file, or of the member of a .npz file that holds depth, which is found out by its bytes. An
/// array of one picture is a stack of one. `least_confidence`: ImageStack::trust, where a .npz has one.
Result<ImageStack> open_npy_stack(const SourceFile& file, std::optional<double> least_confidence = {});

/// Whether a file begins as such a one.
bool is_npy_file(const SourceFile& file);

/// The one picture of a .npy file.
Result<StoredImage> decode_npy(std::string_view bytes, const std::string& where);
/// The same of a .npz file.
Result<StoredImage> decode_npz(std::string_view bytes, const std::string& where);

}  // namespace touchable
