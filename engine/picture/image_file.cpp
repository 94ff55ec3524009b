#include "engine/picture/image_file.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "engine/base/stop_request.hpp"
#include "engine/picture/png_bytes.hpp"

namespace touchable {
namespace {

Error file_error(const std::filesystem::path& file, const std::string& what) {
    return input_error(file.string() + ": " + what);
}
}  // namespace

void give_back(void* memory, std::size_t bytes) {
    static const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto begin = std::bit_cast<std::uintptr_t>(memory);
    const auto first_page = (begin + page - 1) / page * page, last_page = (begin + bytes) / page * page;
    if (first_page < last_page)
        madvise(std::bit_cast<void*>(first_page), last_page - first_page, MADV_DONTNEED);
}

bool is_grey(const Image& image) {
    if (image.channels == 1) return true;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    bool grey = true;
    const bool all_seen =
        until_stopped(image.samples.size() / (3 * bytes), [&](std::size_t first, std::size_t last) {
            const std::uint8_t* at = image.samples.data() + 3 * bytes * first;
            for (std::size_t k = first; k < last && grey; ++k, at += 3 * bytes)
                grey = std::memcmp(at, at + bytes, 2 * bytes) == 0;
        });
    return grey && all_seen;
}

std::optional<Image> as_grey(const Image& image) {
    if (image.channels == 1) return image;
    if (!is_grey(image)) return std::nullopt;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    Image grey{image.width, image.height, image.bytes_per_sample, 1, {}};
    grey.samples.resize(image.samples.size() / 3);
    const bool all_copied =
        until_stopped(grey.samples.size() / bytes, [&](std::size_t first, std::size_t last) {
            for (std::size_t k = first; k < last; ++k)
                std::memcpy(grey.samples.data() + k * bytes, image.samples.data() + 3 * k * bytes, bytes);
        });
    return all_copied ? std::optional(std::move(grey)) : std::nullopt;
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
