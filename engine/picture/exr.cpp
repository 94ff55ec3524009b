// SPDX-License-Identifier: Apache-2.0
#include <openexr.h>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <functional>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/picture/exr_layers.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"

namespace touchable {
namespace {

/// A channel of an OpenEXR file with its numbers as they are stored.
struct ExrChannel : ExrChannelName {
    std::string in_part{};  ///< its name in the part
    NumberFormat format{};
    bool is_of_each_pixel = true;  ///< not subsampled
};

struct ExrWindow {
    int x = 0, y = 0, width = 0, height = 0;
    /// Nullopt if the box is empty or too large.
    static std::optional<ExrWindow> of(const exr_attr_box2i_t& box) {
        const auto width = std::int64_t{box.max.x} - box.min.x + 1,
                   height = std::int64_t{box.max.y} - box.min.y + 1;
        if (width < 1 || height < 1 || width > largest_picture_side || height > largest_picture_side)
            return std::nullopt;
        return ExrWindow{box.min.x, box.min.y, static_cast<int>(width), static_cast<int>(height)};
    }

    bool holds(const ExrWindow& other) const {
        return other.x >= x && other.y >= y &&
               std::int64_t{other.x} + other.width <= std::int64_t{x} + width &&
               std::int64_t{other.y} + other.height <= std::int64_t{y} + height;
    }

    bool operator==(const ExrWindow&) const = default;
};

/// The windows of a part: its picture is the display window, and has numbers in the data window inside.
struct ExrPart {
    ExrWindow data, display;
};

/// Rows or a tile of a part, at x, y of its display window; `numbers` are those of each channel, row by row.
struct ExrChunk {
    int x, y, width, height;
    const std::vector<std::vector<char>>& numbers;
};
using PutExrChunk = std::function<Result<void>(const ExrChunk&)>;

/// A file in memory as OpenEXR reads it, and the first error in it.
struct ExrBytes {
    std::string_view bytes;
    std::string wrong;
};

// Limits for all parts together. OpenEXR's time grows with the square of either.
constexpr std::size_t most_channels = 1024, most_attributes = 8192;

constexpr std::size_t largest_exr_piece = std::size_t{256} << 20;  // of one allocation by OpenEXR

void* take_memory(std::size_t size) {
    return size <= largest_exr_piece ? std::malloc(size) : nullptr;
}

std::int64_t read_exr(exr_const_context_t, void* file, void* to, std::uint64_t size, std::uint64_t offset,
                      exr_stream_error_func_ptr_t) {
    const std::string_view bytes = static_cast<const ExrBytes*>(file)->bytes;
    if (offset >= bytes.size()) return 0;
    const std::size_t count = std::min<std::uint64_t>(size, bytes.size() - offset);
    std::memcpy(to, bytes.data() + offset, count);
    return static_cast<std::int64_t>(count);
}
std::int64_t size_of_exr(exr_const_context_t, void* file) {
    return static_cast<std::int64_t>(static_cast<const ExrBytes*>(file)->bytes.size());
}
void keep_first_exr_error(exr_const_context_t context, exr_result_t, const char* text) {
    void* file = nullptr;
    if (exr_get_user_data(context, &file) != EXR_ERR_SUCCESS || !file) return;
    std::string& wrong = static_cast<ExrBytes*>(file)->wrong;
    if (wrong.empty()) wrong = printable(text, 200);
}

/// Scans the headers of a file before OpenEXR does, to limit its work. Damage is left to OpenEXR to report.
class ExrHeaders {
public:
    explicit ExrHeaders(std::string_view bytes) : rest_(bytes) {}
    /// Which limit is exceeded; empty if none is.
    std::string refusal() {
        constexpr std::size_t before_headers = 8, version_at = 5;
        constexpr unsigned several_parts = 0x10;
        if (rest_.size() < before_headers) return "";
        const bool has_parts = (static_cast<unsigned char>(rest_[version_at]) & several_parts) != 0;
        rest_.remove_prefix(before_headers);
        while (one_header() && has_parts && !rest_.starts_with('\0')) {
        }
        if (attributes_ > most_attributes)
            return "has more than " + std::to_string(most_attributes) + " attributes in its header";
        if (channels_ > most_channels) return "has more than " + std::to_string(most_channels) + " channels";
        return "";
    }

private:
    /// Reads one part's header; false if it is damaged or exceeds a limit.
    bool one_header() {
        while (!rest_.starts_with('\0')) {
            std::string_view name, type, content;
            if (!word(name) || !word(type) || !sized(content)) return false;
            ++attributes_;
            if (type == "chlist") count_channels(content);
            if (attributes_ > most_attributes || channels_ > most_channels) return false;
        }
        rest_.remove_prefix(1);
        return !rest_.empty();
    }
    void count_channels(std::string_view list) {
        constexpr std::size_t behind_name = 16;  // type, linearity, sampling
        while (!list.empty() && !list.starts_with('\0') && channels_ <= most_channels) {
            const auto end = list.find('\0');
            list.remove_prefix(std::min(list.size(), std::min(end, list.size()) + 1 + behind_name));
            ++channels_;
        }
    }
    /// Takes bytes up to a zero byte.
    bool word(std::string_view& found) {
        const auto end = rest_.find('\0');
        if (end == std::string_view::npos) return false;
        found = rest_.substr(0, end);
        rest_.remove_prefix(end + 1);
        return true;
    }
    /// Takes as many bytes as the four before them state, the lowest first.
    bool sized(std::string_view& found) {
        if (rest_.size() < 4) return false;
        const std::size_t size = number_in_bytes(rest_.substr(0, 4), false);
        if (size > rest_.size() - 4) return false;
        found = rest_.substr(4, size);
        rest_.remove_prefix(4 + size);
        return true;
    }

    std::string_view rest_;
    std::size_t channels_ = 0, attributes_ = 0;
};

/// Unpacks channels of a part, chunk by chunk: rows, or a tile.
class ExrChunks : NonCopyable {
public:
    ExrChunks(exr_const_context_t context, const std::vector<const ExrChannel*>& channels)
        : context_(context), channels_(channels), numbers_(channels.size()) {}
    ~ExrChunks() {
        if (begun_) exr_decoding_destroy(context_, &pipeline_);
    }

    bool unpack(const exr_chunk_info_t& chunk) {
        if (chunk.width < 1 || chunk.height < 1 || chunk.width > largest_picture_side ||
            chunk.height > largest_picture_side || chunk.unpacked_size > largest_exr_piece)
            return false;
        const int part = channels_.front()->part;
        const exr_result_t begun = begun_ ? exr_decoding_update(context_, part, &chunk, &pipeline_)
                                          : exr_decoding_initialize(context_, part, &chunk, &pipeline_);
        begun_ = begun_ || begun == EXR_ERR_SUCCESS;
        if (begun != EXR_ERR_SUCCESS) return false;
        std::size_t found = 0;
        for (int k = 0; k < pipeline_.channel_count; ++k) {
            exr_coding_channel_info_t& one = pipeline_.channels[k];
            one.decode_to_ptr = nullptr;
            const auto wanted = std::ranges::find_if(
                channels_, [&](const auto* channel) { return channel->in_part == one.channel_name; });
            if (wanted == channels_.end()) continue;
            if (one.width != chunk.width || one.height != chunk.height) return false;
            const int bytes = (*wanted)->format.bytes, row = chunk.width * bytes;
            std::vector<char>& to = numbers_[static_cast<std::size_t>(wanted - channels_.begin())];
            to.assign(static_cast<std::size_t>(row) * static_cast<std::size_t>(chunk.height), '\0');
            one.decode_to_ptr = reinterpret_cast<std::uint8_t*>(to.data());
            one.user_pixel_stride = bytes;
            one.user_line_stride = row;
            ++found;
        }
        return found == channels_.size() &&
               exr_decoding_choose_default_routines(context_, part, &pipeline_) == EXR_ERR_SUCCESS &&
               exr_decoding_run(context_, part, &pipeline_) == EXR_ERR_SUCCESS;
    }
    const std::vector<std::vector<char>>& numbers() const { return numbers_; }

private:
    exr_const_context_t context_;
    const std::vector<const ExrChannel*>& channels_;
    exr_decode_pipeline_t pipeline_{};
    bool begun_ = false;
    std::vector<std::vector<char>> numbers_;  // the chunk's, of each channel
};

/// How a part is cut into chunks: tiles of the first level, or runs of whole rows.
struct ExrGrid {
    bool tiles = false;
    std::uint32_t across = 0, down = 0;

    bool read(exr_const_context_t context, int part, const ExrWindow& data) {
        exr_storage_t storage;
        if (exr_get_storage(context, part, &storage) != EXR_ERR_SUCCESS) return false;
        tiles = storage == EXR_STORAGE_TILED;
        across = static_cast<std::uint32_t>(data.width);
        if (tiles) {
            exr_tile_level_mode_t levels;
            exr_tile_round_mode_t rounding;
            if (exr_get_tile_descriptor(context, part, &across, &down, &levels, &rounding) != EXR_ERR_SUCCESS)
                return false;
        } else {
            std::int32_t lines = 0;
            if (exr_get_scanlines_per_chunk(context, part, &lines) != EXR_ERR_SUCCESS || lines < 1)
                return false;
            down = static_cast<std::uint32_t>(lines);
        }
        return across >= 1 && down >= 1 && across <= largest_picture_side && down <= largest_picture_side;
    }
    /// The chunk whose upper left pixel is x, y of the data window.
    bool find(exr_const_context_t context, int part, const ExrWindow& data, int x, int y,
              exr_chunk_info_t& chunk) const {
        if (!tiles) return exr_read_scanline_chunk_info(context, part, data.y + y, &chunk) == EXR_ERR_SUCCESS;
        return exr_read_tile_chunk_info(context, part, x / static_cast<int>(across),
                                        y / static_cast<int>(down), 0, 0, &chunk) == EXR_ERR_SUCCESS;
    }
};

/// An OpenEXR file in memory.
class ExrFile : NonCopyable {
public:
    ExrFile(std::string_view bytes, const std::string& where) : bytes_{bytes, {}}, where_(where) {}
    ~ExrFile() {
        if (context_) exr_finish(&context_);
    }

    /// Call first. Lists the channels, at most 1024, of all parts that are not deep.
    Result<void> open() {
        if (const std::string refusal = ExrHeaders(bytes_.bytes).refusal(); !refusal.empty())
            return refused(refusal);
        exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
        how.error_handler_fn = keep_first_exr_error;
        how.alloc_fn = take_memory;
        how.free_fn = std::free;
        how.user_data = &bytes_;
        how.read_fn = read_exr;
        how.size_fn = size_of_exr;
        how.max_image_width = how.max_image_height = how.max_tile_width = how.max_tile_height =
            largest_picture_side;
        if (exr_start_read(&context_, "picture", &how) != EXR_ERR_SUCCESS) return damaged();
        int parts = 0;
        if (exr_get_count(context_, &parts) != EXR_ERR_SUCCESS) return damaged();
        for (int part = 0; part < parts; ++part) TRY(list_channels(part));
        return {};
    }

    const std::vector<ExrChannel>& channels() const { return channels_; }
    /// Refuses parts that cannot be read.
    Result<ExrPart> part(int number) const {
        exr_attr_box2i_t data_box, display_box;
        if (exr_get_data_window(context_, number, &data_box) != EXR_ERR_SUCCESS ||
            exr_get_display_window(context_, number, &display_box) != EXR_ERR_SUCCESS)
            return damaged();
        const auto data = ExrWindow::of(data_box), display = ExrWindow::of(display_box);
        if (!data || !display) return refused("has a window that is empty or larger than 16384x16384 pixels");
        if (!display->holds(*data))
            return refused("has a data window beyond its display window: must be inside");
        // Bytes of depth, colour and material indices, which may all be unpacked at once.
        const std::uint64_t needed = pixel_count(display->width, display->height) * (4 + 3 + 4);
        TRY(check_expansion(needed, bytes_.bytes.size(), where_));
        exr_compression_t packing;
        if (exr_get_compression(context_, number, &packing) != EXR_ERR_SUCCESS) return damaged();
        if (packing == EXR_COMPRESSION_DWAA || packing == EXR_COMPRESSION_DWAB)
            return refused("is compressed by DWA: must be by ZIP, PIZ or another that loses nothing");
        return ExrPart{*data, *display};
    }

    /// Unpacks these channels, all of one part, and each once.
    Result<void> read(const ExrPart& part, const std::vector<const ExrChannel*>& channels,
                      const PutExrChunk& put) const {
        const ExrWindow& data = part.data;
        const int number = channels.front()->part;
        ExrGrid grid;
        if (!grid.read(context_, number, data)) return damaged();
        ExrChunks chunks(context_, channels);
        const int across = static_cast<int>(grid.across), down = static_cast<int>(grid.down);
        for (int y = 0; y < data.height; y += down)
            for (int x = 0; x < data.width; x += across) {
                if (stop_requested()) return interrupted_error();
                exr_chunk_info_t chunk;
                const int width = std::min(across, data.width - x), height = std::min(down, data.height - y);
                if (!grid.find(context_, number, data, x, y, chunk) || chunk.width != width ||
                    chunk.height != height || !chunks.unpack(chunk))
                    return damaged();
                const ExrChunk unpacked{data.x - part.display.x + x, data.y - part.display.y + y, width,
                                        height, chunks.numbers()};
                TRY(put(unpacked));
            }
        return {};
    }

    Error refused(const std::string& why, Hints hints = {}) const {
        return input_error(where_ + ": " + why, std::move(hints));
    }

private:
    /// Lists the channels of a part that is not deep.
    Result<void> list_channels(int part) {
        exr_storage_t storage;
        const exr_attr_chlist_t* list = nullptr;
        if (exr_get_storage(context_, part, &storage) != EXR_ERR_SUCCESS ||
            exr_get_channels(context_, part, &list) != EXR_ERR_SUCCESS)
            return damaged();
        if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) return {};
        int parts = 1;
        const char* name = nullptr;  // which each of several parts has
        if (exr_get_count(context_, &parts) != EXR_ERR_SUCCESS) return damaged();
        if (parts > 1 && exr_get_name(context_, part, &name) != EXR_ERR_SUCCESS) return damaged();
        for (int k = 0; k < list->num_channels; ++k) {
            const exr_attr_chlist_entry_t& entry = list->entries[k];
            const NumberFormat format{
                entry.pixel_type == EXR_PIXEL_UINT ? NumberFormat::Kind::unsigned_integer
                                                   : NumberFormat::Kind::floating,
                entry.pixel_type == EXR_PIXEL_HALF ? 2 : 4, std::endian::native == std::endian::big};
            channels_.push_back({{part, exr_name_in_part(name ? name : "", entry.name.str)},
                                 entry.name.str,
                                 format,
                                 entry.x_sampling == 1 && entry.y_sampling == 1});
        }
        return {};
    }

    Error damaged() const {
        return input_error(where_ + ": is damaged" + (bytes_.wrong.empty() ? "" : ": " + bytes_.wrong));
    }

    ExrBytes bytes_;
    std::string where_;
    exr_context_t context_ = nullptr;
    std::vector<ExrChannel> channels_;
};

std::vector<ExrChannelName> names_of(const ExrFile& file) {
    return {file.channels().begin(), file.channels().end()};
}

std::string channel_list(const ExrFile& file) {
    return printable(listed(file.channels(), &ExrChannel::name), 300);
}

std::string quoted_channel(const std::string& name) {
    return printable(name, 60);
}

Error in_colour(const ExrFile& file) {
    return file.refused("is in colour: a picture of depth has a channel Z, depth, Y or R");
}

/// A picture made of one or several channels of a part, which may have others.
class ExrPicture {
public:
    virtual ~ExrPicture() = default;
    virtual std::vector<const ExrChannel*> channels() const = 0;
    /// Numbers of a chunk; those of its own channels begin at `first`.
    virtual Result<void> put(const ExrChunk& chunk, std::size_t first) = 0;
    /// Called before `put`, with the part's size.
    virtual void begin(const ExrPart& part) = 0;
    virtual StoredImage finish() = 0;

    int part() const { return channels().front()->part; }
};

/// Numbers as stored: depth, with channels that must be the same, or material indices.
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
    /// Fills the picture with the number for no data: NaN, or 0 for integers.
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
        image_ = blank_image(part.display.width, part.display.height, 1, 3);
    }
    Result<void> put(const ExrChunk& chunk, std::size_t first) override {
        for (std::size_t c = 0; c < 3; ++c) {
            const char* from = chunk.numbers[first + c].data();
            for (int row = 0; row < chunk.height; ++row) {
                std::uint8_t* to =
                    image_.samples.data() + c + 3 * (pixel_place(chunk.x, chunk.y + row, image_.width));
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

/// Whether a channel can be read: floats for each pixel; with `integers` these as well.
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
        return file.refused("has no channel Z, depth, Y or R for each pixel, but " + channel_list(file),
                            {{Setting::channel, "NAME"}});
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

/// Reads pictures of one part together.
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
        for (std::size_t k = 0; k < pictures.size(); ++k) TRY(pictures[k]->put(chunk, first[k]));
        return {};
    });
}

Result<StoredImage> read_alone(const ExrFile& file, ExrPicture& picture) {
    TRY(read_together(file, {&picture}));
    return picture.finish();
}

/// A picture beside depth; nullopt if it is in another part than depth's and cannot be read.
std::optional<StoredImage> read_beside(const ExrFile& file, ExrPicture& picture, bool is_read) {
    if (is_read) return picture.finish();
    auto read = read_alone(file, picture);
    return read ? std::optional(std::move(*read)) : std::nullopt;
}

Result<StoredImage> depth_with(const ExrFile& file, const BesideDepth::Wanted& wanted,
                               const std::string& named) {
    const ExrLayers layers = exr_layers(names_of(file), named);
    if (!named.empty() && !layers.depth)
        return file.refused("has no channel " + in_quotes(named) + ", but " + channel_list(file),
                            {{Setting::channel, "NAME"}});
    TRY_ASSIGN(auto depth, depth_of(file, layers));
    auto colour = wanted.colour ? colour_of(file, layers.colour) : std::nullopt;
    auto materials = wanted.materials ? materials_of(file, layers.materials) : std::nullopt;
    std::vector<ExrPicture*> together{&depth};
    const auto is_beside = [&](const auto& picture) { return picture && picture->part() == depth.part(); };
    if (is_beside(colour)) together.push_back(&*colour);
    if (is_beside(materials)) together.push_back(&*materials);
    TRY(read_together(file, together));
    StoredImage picture = depth.finish();
    const std::string& channel = file.channels()[*layers.depth].name;
    picture.is_rendered = is_exr_depth_of_renderer(channel);
    const bool tells_its_unit = is_exr_depth_of_unreal(channel);
    if (!colour && !materials && !tells_its_unit) return picture;
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

Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where,
                               const BesideDepth::Wanted& wanted, const std::string& channel) {
    ExrFile file(bytes, where);
    TRY(file.open());
    return depth_with(file, wanted, channel);
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
