#include "engine/picture/npy_stack.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/npz_file.hpp"

namespace touchable {
namespace {

constexpr std::size_t npy_block = std::size_t{1} << 20;

Error interrupted_reading(const std::string& where) {
    return {ErrorKind::interrupted, "interrupted while " + where + " was read"};
}

Result<StoredImage> only_image(Result<ImageStack> stack, const std::string& where) {
    if (!stack) return stack.error();
    if (stack->count() == 1) return stack->image(0);
    return input_error(where + ": is a stack of " + std::to_string(stack->count()) + " pictures of " +
                       std::to_string(stack->width()) + "x" + std::to_string(stack->height()) +
                       ": must be one picture here");
}

/// Of pixel k, row by row. What is no number is least.
float number_at(const StoredImage& picture, std::size_t k) {
    if (picture.values.empty()) {
        const PlaneView codes = picture.image.view();
        const int at = static_cast<int>(k);
        return static_cast<float>(codes.sample(at % codes.width, at / codes.width));
    }
    const float value = picture.values[k];
    return value == value ? value : std::numeric_limits<float>::lowest();
}

std::size_t pixels_of(const StoredImage& picture) {
    return static_cast<std::size_t>(picture.image.width) * static_cast<std::size_t>(picture.image.height);
}

}  // namespace

ImageStack::ImageStack(std::unique_ptr<ByteSource> bytes, std::string where, NpyHeader header,
                       NpyPictures pictures)
    : bytes_(std::move(bytes)), where_(std::move(where)), header_(std::move(header)), pictures_(pictures) {}

Result<ImageStack> ImageStack::of(std::unique_ptr<ByteSource> bytes, std::string where) {
    TRY_ASSIGN(auto header, read_npy_header(*bytes, where));
    TRY_ASSIGN(const auto pictures, npy_pictures(header, where));
    ImageStack stack(std::move(bytes), std::move(where), std::move(header), pictures);
    TRY(stack.check());
    TRY(stack.find_floats());
    return stack;
}

Result<void> ImageStack::check() const {
    if (header_.columns_first && pictures_.count > 1)
        return input_error(where_ + ": is a stack in Fortran order: must be in C order, as " +
                           "numpy.ascontiguousarray makes it");
    const auto needed =
        static_cast<std::uint64_t>(pictures_.count) * static_cast<std::uint64_t>(pictures_.width) *
        static_cast<std::uint64_t>(pictures_.height) * static_cast<std::uint64_t>(header_.format.bytes);
    if (bytes_->size() < header_.data_at || bytes_->size() - header_.data_at < needed)
        return input_error(where_ + ": is cut short: has " + std::to_string(bytes_->size()) + " bytes of " +
                           std::to_string(header_.data_at + needed));
    return {};
}

/// Whether integers that may be beyond 16 bits are, in any picture.
Result<void> ImageStack::find_floats() {
    const bool codes =
        header_.format.kind == NumberFormat::Kind::unsigned_integer && header_.format.bytes <= 2;
    if (codes || header_.format.kind == NumberFormat::Kind::floating) return {};
    for (std::int64_t number = 0; number < count() && count() > 1 && !floats_; ++number) {
        TRY_ASSIGN(const auto picture, read(number));
        floats_ = !picture.has_codes();
    }
    return {};
}

Result<NumberPicture> ImageStack::read(std::int64_t number) {
    const int bytes = header_.format.bytes, width = pictures_.width, height = pictures_.height;
    const bool columns = header_.columns_first;
    const int lines = columns ? width : height, line = bytes * (columns ? height : width);
    const int together = std::max(1, static_cast<int>(npy_block) / line);
    std::vector<char> block(static_cast<std::size_t>(line) *
                            static_cast<std::size_t>(std::min(together, lines)));
    NumberPicture picture(width, height, header_.format);
    std::uint64_t at = header_.data_at + static_cast<std::uint64_t>(number) *
                                             static_cast<std::uint64_t>(line) *
                                             static_cast<std::uint64_t>(lines);
    for (int first = 0; first < lines; first += together) {
        if (stop_requested()) return interrupted_reading(where_);
        const int now = std::min(together, lines - first);
        const std::size_t size = static_cast<std::size_t>(line) * static_cast<std::size_t>(now);
        if (auto got = bytes_->read(at, block.data(), size); !got) return error_at(where_, got.error());
        if (columns)
            picture.put(first, 0, {block.data(), now, height, line, bytes});
        else
            picture.put(0, first, {block.data(), width, now, bytes, line});
        at += size;
    }
    return picture;
}

Result<StoredImage> ImageStack::image(std::int64_t number) {
    if (number < 0 || number >= count())
        return usage_error(where_ + ": has no picture " + std::to_string(number) + ": must be from 0 to " +
                           std::to_string(count() - 1));
    TRY_ASSIGN(auto picture, read(number));
    StoredImage image = std::move(picture).finish("npy", floats_);
    if (stop_requested()) return interrupted_reading(where_);
    if (!confidence_) return image;
    TRY_ASSIGN(const auto confidence, confidence_->image(number));
    const auto bytes = static_cast<std::size_t>(image.image.bytes_per_sample);
    const bool all_trusted = until_stopped(pixels_of(image), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            if (number_at(confidence, k) >= *least_confidence_) continue;
            if (!image.values.empty())
                image.values[k] = std::numeric_limits<float>::quiet_NaN();
            else
                std::fill_n(image.image.samples.begin() + static_cast<std::ptrdiff_t>(k * bytes), bytes,
                            std::uint8_t{0});
        }
    });
    if (!all_trusted) return interrupted_reading(where_);
    return image;
}

Result<void> ImageStack::trust(ImageStack confidence, std::optional<double> least) {
    if (confidence.count() != count() || confidence.width() != width() || confidence.height() != height())
        return input_error(confidence.where_ + ": is of " + std::to_string(confidence.count()) +
                           " pictures of " + std::to_string(confidence.width()) + "x" +
                           std::to_string(confidence.height()) + ", but depth of " + std::to_string(count()) +
                           " of " + std::to_string(width()) + "x" + std::to_string(height()));
    if (!least) {
        TRY_ASSIGN(const auto first, confidence.image(0));
        std::vector<float> numbers(pixels_of(first));
        for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = number_at(first, k);
        const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
        std::nth_element(numbers.begin(), middle, numbers.end());
        least = *middle / 2.0;
    }
    least_confidence_ = least;
    confidence_ = std::make_unique<ImageStack>(std::move(confidence));
    return {};
}

Result<ImageStack> open_npy_stack(const SourceFile& file, std::optional<double> least_confidence) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    if (!is_npz(first_bytes(*bytes, 4))) return ImageStack::of(std::move(bytes), file.string());
    TRY_ASSIGN(auto member, open_npz(std::move(bytes), file.string()));
    auto stack = ImageStack::of(std::move(member.bytes), member.where);
    if (!stack || !member.confidence) return stack;
    auto confidence = ImageStack::of(std::move(member.confidence), file.string() + ": conf");
    if (!confidence) return confidence;
    TRY(stack->trust(std::move(*confidence), least_confidence));
    return stack;
}

bool is_npy_file(const SourceFile& file) {
    const std::string begin = first_bytes(file, 8);
    const std::string_view kind = picture_kind(begin);
    return kind == "npy" || kind == "npz";
}

Result<StoredImage> decode_npy(std::string_view bytes, const std::string& where) {
    return only_image(ImageStack::of(bytes_in_memory(bytes), where), where);
}

Result<StoredImage> decode_npz(std::string_view bytes, const std::string& where) {
    TRY_ASSIGN(auto member, depth_member(bytes, where));
    return only_image(ImageStack::of(std::move(member.bytes), member.where), member.where);
}

}  // namespace touchable
