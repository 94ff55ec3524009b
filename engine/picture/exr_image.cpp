#include "engine/picture/exr_image.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/exr_file.hpp"
#include "engine/picture/linear_light.hpp"

namespace touchable {
namespace {

std::vector<ExrChannelName> names_of(const ExrFile& file) {
    return {file.channels().begin(), file.channels().end()};
}

std::string channel_list(const ExrFile& file) {
    std::string names;
    for (const ExrChannel& channel : file.channels()) names += (names.empty() ? "" : ", ") + channel.name;
    return printable(names, 300);
}

std::string quoted_channel(const std::string& name) {
    return printable(name, 60);
}

Error in_colour(const ExrFile& file) {
    return file.refused("is in colour: a picture of depth has a channel Z, depth, Y or R");
}

/// A picture that is made of one or several channels of a part, of which there may be others.
class ExrPicture {
public:
    virtual ~ExrPicture() = default;
    virtual std::vector<const ExrChannel*> channels() const = 0;
    /// Numbers of a chunk; those of its own channels begin at `first`.
    virtual Result<void> put(const ExrChunk& chunk, std::size_t first) = 0;
    /// Before any: of this size.
    virtual void begin(const ExrPart& part) = 0;
    virtual StoredImage finish() = 0;

    int part() const { return channels().front()->part; }
};

/// Numbers as they are: depth, with channels that have to be the same, or material indices.
class ExrNumbers final : public ExrPicture {
public:
    ExrNumbers(const ExrFile& file, const ExrChannel& channel) : file_(file), channels_{&channel} {}
    void add_same(const ExrChannel& channel) { channels_.push_back(&channel); }

    std::vector<const ExrChannel*> channels() const override { return channels_; }
    void begin(const ExrPart& part) override {
        picture_.emplace(part.display.width, part.display.height, format());
        if (!(part.data == part.display)) fill_with_nothing(part.display);
    }
    Result<void> put(const ExrChunk& chunk, std::size_t first) override {
        for (std::size_t k = 1; k < channels_.size(); ++k)
            if (chunk.numbers[first + k] != chunk.numbers[first]) return in_colour(file_);
        const int bytes = format().bytes;
        picture_->put(chunk.x, chunk.y,
                      {chunk.numbers[first].data(), chunk.width, chunk.height, bytes,
                       std::ptrdiff_t{bytes} * chunk.width});
        return {};
    }
    StoredImage finish() override { return std::move(*picture_).finish("exr"); }

private:
    const NumberFormat& format() const { return channels_.front()->format; }
    /// A picture without data: NaN, of integers 0.
    void fill_with_nothing(const ExrWindow& window) {
        const std::uint16_t half_nan = 0x7e00;
        const std::uint32_t nan = format().kind == NumberFormat::Kind::floating ? 0x7fc00000 : 0;
        const char* number = format().bytes == 2 ? reinterpret_cast<const char*>(&half_nan)
                                                 : reinterpret_cast<const char*>(&nan);
        picture_->put(0, 0, {number, window.width, window.height, 0, 0});
    }

    const ExrFile& file_;
    std::vector<const ExrChannel*> channels_;  // the first is the one to read
    std::optional<NumberPicture> picture_;
};

/// Linear light as sRGB of 8 bits.
class ExrColourPicture final : public ExrPicture {
public:
    explicit ExrColourPicture(const std::array<const ExrChannel*, 3>& channels) : channels_(channels) {}

    std::vector<const ExrChannel*> channels() const override { return {channels_.begin(), channels_.end()}; }
    void begin(const ExrPart& part) override {
        image_ = {part.display.width, part.display.height, 1, 3, {}};
        image_.samples.resize(3 * static_cast<std::size_t>(image_.width) *
                              static_cast<std::size_t>(image_.height));
    }
    Result<void> put(const ExrChunk& chunk, std::size_t first) override {
        for (std::size_t c = 0; c < 3; ++c) {
            const char* from = chunk.numbers[first + c].data();
            for (int row = 0; row < chunk.height; ++row) {
                std::uint8_t* to =
                    image_.samples.data() + c +
                    3 * (static_cast<std::size_t>(chunk.y + row) * static_cast<std::size_t>(image_.width) +
                         static_cast<std::size_t>(chunk.x));
                from = channels_[c]->format.bytes == 2 ? put_row<std::uint16_t>(from, chunk.width, to)
                                                       : put_row<float>(from, chunk.width, to);
            }
        }
        return {};
    }
    StoredImage finish() override {
        const int bits = 8 * channels_[0]->format.bytes;
        return {std::move(image_), "exr", "rgbf" + std::to_string(bits)};
    }

private:
    template <class Number>
    static const char* put_row(const char* from, int count, std::uint8_t* to) {
        for (int k = 0; k < count; ++k, from += sizeof(Number), to += 3) {
            Number number;
            std::memcpy(&number, from, sizeof number);
            *to = srgb_sample(number);
        }
        return from;
    }

    std::array<const ExrChannel*, 3> channels_;
    Image image_;
};

/// What can be seen or counted: floats of each pixel; of `integers` those as well.
bool is_usable(const ExrChannel& channel, bool integers) {
    return channel.is_of_each_pixel && (integers || channel.format.kind == NumberFormat::Kind::floating);
}

std::optional<ExrColourPicture> colour_of(const ExrFile& file,
                                          const std::optional<std::array<std::size_t, 3>>& places) {
    if (!places) return std::nullopt;
    std::array<const ExrChannel*, 3> channels{};
    for (std::size_t c = 0; c < 3; ++c) {
        channels[c] = &file.channels()[(*places)[c]];
        if (!is_usable(*channels[c], false)) return std::nullopt;
    }
    return ExrColourPicture(channels);
}

std::optional<ExrNumbers> materials_of(const ExrFile& file, const std::optional<std::size_t>& place) {
    if (!place || !is_usable(file.channels()[*place], true)) return std::nullopt;
    return ExrNumbers(file, file.channels()[*place]);
}

Result<ExrNumbers> depth_of(const ExrFile& file, const ExrLayers& layers) {
    if (!layers.depth)
        return file.refused("has no channel Z, depth, Y or R for each pixel, but " + channel_list(file));
    const ExrChannel& channel = file.channels()[*layers.depth];
    if (!channel.is_of_each_pixel)
        return file.refused("has channel " + quoted_channel(channel.name) +
                            " for some pixels only: must be for all");
    ExrNumbers depth(file, channel);
    if (layers.depth_is_luminance) return in_colour(file);
    for (const std::size_t place : layers.same_as_depth) {
        const ExrChannel& other = file.channels()[place];
        if (!other.is_of_each_pixel || other.format.kind != channel.format.kind ||
            other.format.bytes != channel.format.bytes)
            return in_colour(file);
        depth.add_same(other);
    }
    return depth;
}

/// Those of one part, together.
Result<void> read_together(const ExrFile& file, const std::vector<ExrPicture*>& pictures) {
    TRY_ASSIGN(const auto part, file.part(pictures.front()->part()));
    std::vector<const ExrChannel*> channels;
    std::vector<std::size_t> first;
    for (ExrPicture* picture : pictures) {
        picture->begin(part);
        first.push_back(channels.size());
        for (const ExrChannel* channel : picture->channels()) channels.push_back(channel);
    }
    return file.read(part, channels, [&](const ExrChunk& chunk) -> Result<void> {
        for (std::size_t k = 0; k < pictures.size(); ++k)
            if (auto taken = pictures[k]->put(chunk, first[k]); !taken) return taken;
        return {};
    });
}

Result<StoredImage> read_alone(const ExrFile& file, ExrPicture& picture) {
    TRY(read_together(file, {&picture}));
    return picture.finish();
}

/// Of another part than depth's it may be what cannot be read: then there is none.
std::optional<StoredImage> read_beside(const ExrFile& file, ExrPicture& picture, bool is_read) {
    if (is_read) return picture.finish();
    auto read = read_alone(file, picture);
    return read ? std::optional(std::move(*read)) : std::nullopt;
}

Result<StoredImage> depth_with(const ExrFile& file, const BesideDepth::Wanted& wanted) {
    const ExrLayers layers = exr_layers(names_of(file));
    TRY_ASSIGN(auto depth, depth_of(file, layers));
    auto colour = wanted.colour ? colour_of(file, layers.colour) : std::nullopt;
    auto materials = wanted.materials ? materials_of(file, layers.materials) : std::nullopt;
    std::vector<ExrPicture*> together{&depth};
    const auto is_beside = [&](const auto& picture) { return picture && picture->part() == depth.part(); };
    if (is_beside(colour)) together.push_back(&*colour);
    if (is_beside(materials)) together.push_back(&*materials);
    TRY(read_together(file, together));
    StoredImage picture = depth.finish();
    if (!colour && !materials) return picture;
    picture.beside = std::make_shared<BesideDepth>();
    BesideDepth& beside = *picture.beside;
    const auto name = [&](std::size_t place) { return quoted_channel(file.channels()[place].name); };
    beside.depth_name = name(*layers.depth);
    beside.depths = layers.depths;
    if (colour) {
        beside.colour = read_beside(file, *colour, is_beside(colour));
        beside.colour_name = quoted_channel(exr_layer_of(file.channels()[(*layers.colour)[0]].name));
    }
    if (materials) {
        beside.materials = read_beside(file, *materials, is_beside(materials));
        beside.materials_name = name(*layers.materials);
    }
    return picture;
}

}  // namespace

bool is_exr(std::string_view begin) {
    return begin.starts_with("\x76\x2f\x31\x01");
}

Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where) {
    return decode_exr(bytes, where, {});
}

Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where,
                               const BesideDepth::Wanted& wanted) {
    ExrFile file(bytes, where);
    TRY(file.open());
    return depth_with(file, wanted);
}

Result<StoredImage> decode_exr_colour(std::string_view bytes, const std::string& where) {
    ExrFile file(bytes, where);
    TRY(file.open());
    auto colour = colour_of(file, exr_colour(names_of(file)));
    if (!colour)
        return file.refused("has no colour: must have channels R, G and B, floats of each pixel, but has " +
                            channel_list(file));
    return read_alone(file, *colour);
}

Result<StoredImage> decode_exr_materials(std::string_view bytes, const std::string& where) {
    ExrFile file(bytes, where);
    TRY(file.open());
    auto materials = materials_of(file, exr_materials(names_of(file)));
    if (!materials)
        return file.refused("has no material indices: must have a layer IndexMA of each pixel, but has " +
                            channel_list(file));
    return read_alone(file, *materials);
}

}  // namespace touchable
