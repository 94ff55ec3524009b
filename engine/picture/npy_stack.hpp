#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/npy_header.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

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
