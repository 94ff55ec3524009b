#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/plane_view.hpp"

namespace touchable {

/// A picture with its own memory, rows packed.
struct Image {
    int width = 0, height = 0;
    int bytes_per_sample = 1;  ///< 1 or 2 (host order)
    int channels = 1;          ///< 1 or 3
    std::vector<std::uint8_t> samples;

    PlaneView view() const {
        return {samples.data(),
                static_cast<std::ptrdiff_t>(width) * channels * bytes_per_sample,
                width,
                height,
                bytes_per_sample,
                channels};
    }
};

/// Gives memory that is not read again back to the system before its owner is destroyed, as far as it is
/// whole pages: so a picture that is made of another one, row by row, is held once and not twice.
void give_back(void* memory, std::size_t bytes);

/// A picture as stored: grey of 8 or 16 bits, or RGB of 8; palettes become RGB, alpha is dropped.
Result<Image> read_image(const std::filesystem::path& file);
/// Whether red, green and blue are the same everywhere; false where it is asked to stop before it is known.
bool is_grey(const Image& image);
/// Grey, or grey that is stored as RGB: red, green and blue the same everywhere. Nothing of colour.
std::optional<Image> as_grey(const Image& image);
/// How 8-bit RGB is stored: as it is, or, where a picture has at most 256 colours, as indices into a palette
/// of them, which takes fewer bytes where they lie in areas, as materials do. Both keep every value.
enum class PngColours { rgb, indexed_if_few };
/// Lossless. Grey of 8 or 16 bits, or RGB of 8. Whoever owns `file` commits it.
Result<void> write_png(NewFile& file, const PlaneView& image, PngColours colours = PngColours::rgb);
/// Quick: half the time, for 5 % more bytes of a photograph and fewer of smooth depth.
enum class PngEffort { quick, thorough };
/// The same into a file of whatever name; messages speak of `name`.
Result<void> write_png_to(const std::filesystem::path& path, const PlaneView& image,
                          const std::filesystem::path& name, PngEffort effort,
                          PngColours colours = PngColours::rgb);
/// The same, and gives it its name, over an earlier file.
Result<void> write_png(const std::filesystem::path& file, const PlaneView& image);

}  // namespace touchable
