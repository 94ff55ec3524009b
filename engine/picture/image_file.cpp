#include "engine/picture/image_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "engine/picture/png_bytes.hpp"

namespace touchable {
namespace {

Error file_error(const std::filesystem::path& file, const std::string& what) {
    return input_error(file.string() + ": " + what);
}
}  // namespace

bool is_grey(const Image& image) {
    if (image.channels == 1) return true;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    for (std::size_t at = 0; at < image.samples.size(); at += 3 * bytes)
        if (std::memcmp(image.samples.data() + at, image.samples.data() + at + bytes, 2 * bytes) != 0)
            return false;
    return true;
}

std::optional<Image> as_grey(const Image& image) {
    if (image.channels == 1) return image;
    if (!is_grey(image)) return std::nullopt;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    Image grey{image.width, image.height, image.bytes_per_sample, 1, {}};
    grey.samples.resize(image.samples.size() / 3);
    const std::uint8_t* from = image.samples.data();
    for (std::size_t at = 0; at < grey.samples.size(); at += bytes, from += 3 * bytes)
        std::memcpy(grey.samples.data() + at, from, bytes);
    return grey;
}

Result<void> write_png_to(const std::filesystem::path& path, const PlaneView& image,
                          const std::filesystem::path& name, PngEffort effort, PngColours colours) {
    const auto png = png_bytes(image, effort, colours);
    if (!png) return Error{png.error().kind, name.string() + ": " + png.error().message};
    std::ofstream out(path, std::ios::binary);
    out << *png;
    out.close();
    if (!out) return file_error(name, std::string("cannot be written: ") + std::strerror(errno));
    return {};
}

Result<void> write_png(NewFile& file, const PlaneView& image, PngColours colours) {
    if (auto usable = file.check(); !usable) return usable;
    return write_png_to(file.path(), image, file.target(), PngEffort::thorough, colours);
}

Result<void> write_png(const std::filesystem::path& file, const PlaneView& image) {
    NewFile output(file);
    if (auto written = write_png(output, image); !written) return written;
    return output.commit();
}

}  // namespace touchable
