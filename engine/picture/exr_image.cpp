#include "engine/picture/exr_image.hpp"

#include <openexr.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "engine/picture/number_picture.hpp"
#include "engine/printable.hpp"

namespace touchable {
namespace {

constexpr std::size_t largest_exr_piece = std::size_t{256} << 20;  // of memory that OpenEXR takes at once

/// A file in memory as OpenEXR reads it, and the first that was wrong with it.
struct ExrBytes {
    std::string_view bytes;
    std::string wrong;
};

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

/// A channel that is to be read, with those that have to be the same.
struct ExrChannel {
    int part = 0;
    std::string name;
    NumberFormat format;
    std::vector<std::string> same;
};

class ExrFile {
public:
    ExrFile(std::string_view bytes, const std::string& where) : bytes_{bytes, {}}, where_(where) {}
    ~ExrFile() {
        if (context_) exr_finish(&context_);
    }
    ExrFile(const ExrFile&) = delete;
    ExrFile& operator=(const ExrFile&) = delete;

    Result<StoredImage> read();

private:
    Result<void> open();
    Result<ExrChannel> choose() const;
    Error damaged() const {
        return input_error(where_ + ": is damaged" + (bytes_.wrong.empty() ? "" : ": " + bytes_.wrong));
    }
    Error refused(const std::string& why) const { return input_error(where_ + ": " + why); }

    ExrBytes bytes_;
    std::string where_;
    exr_context_t context_ = nullptr;
};

Result<void> ExrFile::open() {
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
    return {};
}

std::string lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return lower;
}

/// What a channel is called in its layer, of which dots part its name, and whether a layer or it is depth.
std::string_view own_name(std::string_view channel) {
    return channel.substr(channel.rfind('.') + 1);  // of no dot: all
}
bool is_named_depth(std::string_view channel) {
    return ('.' + lower_case(channel) + '.').find(".depth.") != std::string::npos;
}

/// The place among a part's channels of the one to read.
std::optional<int> depth_channel(const exr_attr_chlist_t& channels) {
    const auto name = [&](int k) { return std::string_view(channels.entries[k].name.str); };
    const auto first = [&](auto&& fits) -> std::optional<int> {
        for (int k = 0; k < channels.num_channels; ++k)
            if (fits(name(k))) return k;
        return std::nullopt;
    };
    const auto called = [](std::string_view wanted) {
        return [wanted](std::string_view channel) { return lower_case(own_name(channel)) == wanted; };
    };
    if (auto found = first(called("z"))) return found;
    if (auto found = first(is_named_depth)) return found;
    if (auto found = first(called("y"))) return found;
    if (auto found = first(called("r"))) return found;
    return channels.num_channels == 1 ? std::optional(0) : std::nullopt;
}

Result<ExrChannel> ExrFile::choose() const {
    int parts = 0;
    std::string names;
    if (exr_get_count(context_, &parts) != EXR_ERR_SUCCESS) return damaged();
    for (int part = 0; part < parts; ++part) {
        exr_storage_t storage;
        const exr_attr_chlist_t* channels = nullptr;
        if (exr_get_storage(context_, part, &storage) != EXR_ERR_SUCCESS ||
            exr_get_channels(context_, part, &channels) != EXR_ERR_SUCCESS)
            return damaged();
        if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) continue;  // deep
        for (int k = 0; k < channels->num_channels; ++k)
            names += (names.empty() ? "" : ", ") + std::string(channels->entries[k].name.str);
        const auto found = depth_channel(*channels);
        if (!found) continue;
        const exr_attr_chlist_entry_t& entry = channels->entries[*found];
        ExrChannel channel{part, entry.name.str, {}, {}};
        if (entry.x_sampling != 1 || entry.y_sampling != 1)
            return refused("has channel " + printable(channel.name) +
                           " for some pixels only: must be for all");
        channel.format = {entry.pixel_type == EXR_PIXEL_UINT ? NumberFormat::Kind::unsigned_integer
                                                             : NumberFormat::Kind::floating,
                          entry.pixel_type == EXR_PIXEL_HALF ? 2 : 4,
                          std::endian::native == std::endian::big};
        const std::string layer = channel.name.substr(0, channel.name.size() - own_name(channel.name).size());
        for (int other = 0; other < channels->num_channels; ++other) {
            const std::string name = channels->entries[other].name.str;
            if (own_name(channel.name) == "Y" && (name == layer + "RY" || name == layer + "BY"))
                return refused("is in colour: a picture of depth has a channel Z, depth, Y or R");
            if (own_name(channel.name) == "R" && (name == layer + "G" || name == layer + "B")) {
                if (channels->entries[other].pixel_type != entry.pixel_type)
                    return refused("is in colour: a picture of depth has a channel Z, depth, Y or R");
                channel.same.push_back(name);
            }
        }
        return channel;
    }
    return refused("has no channel Z, depth, Y or R for each pixel, but " + printable(names, 300));
}

struct ExrWindow {
    int x = 0, y = 0, width = 0, height = 0;
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

/// A picture without data: NaN, of integers 0.
void fill_with_nothing(NumberPicture& picture, const NumberFormat& format, const ExrWindow& window) {
    const bool half = format.bytes == 2;
    const std::uint16_t half_nan = 0x7e00;
    const std::uint32_t nan = format.kind == NumberFormat::Kind::floating ? 0x7fc00000 : 0;
    const char* number =
        half ? reinterpret_cast<const char*>(&half_nan) : reinterpret_cast<const char*>(&nan);
    picture.put(0, 0, {number, window.width, window.height, 0, 0});
}

/// Unpacks a part's chunks, one after the other: rows, or a tile.
class ExrChunks {
public:
    ExrChunks(exr_const_context_t context, const ExrChannel& channel)
        : context_(context), channel_(channel) {}
    ~ExrChunks() {
        if (begun_) exr_decoding_destroy(context_, &pipeline_);
    }
    ExrChunks(const ExrChunks&) = delete;
    ExrChunks& operator=(const ExrChunks&) = delete;

    bool unpack(const exr_chunk_info_t& chunk) {
        if (chunk.width < 1 || chunk.height < 1 || chunk.width > largest_picture_side ||
            chunk.height > largest_picture_side || chunk.unpacked_size > largest_exr_piece)
            return false;
        const exr_result_t begun = begun_
                                       ? exr_decoding_update(context_, channel_.part, &chunk, &pipeline_)
                                       : exr_decoding_initialize(context_, channel_.part, &chunk, &pipeline_);
        begun_ = begun_ || begun == EXR_ERR_SUCCESS;
        if (begun != EXR_ERR_SUCCESS) return false;
        const int row = chunk.width * channel_.format.bytes;
        numbers_.resize(1 + channel_.same.size());
        std::size_t found = 0;
        for (int k = 0; k < pipeline_.channel_count; ++k) {
            exr_coding_channel_info_t& one = pipeline_.channels[k];
            one.decode_to_ptr = nullptr;
            const auto place = place_of(one.channel_name);
            if (!place) continue;
            if (one.width != chunk.width || one.height != chunk.height) return false;
            numbers_[*place].assign(static_cast<std::size_t>(row) * static_cast<std::size_t>(chunk.height),
                                    '\0');
            one.decode_to_ptr = reinterpret_cast<std::uint8_t*>(numbers_[*place].data());
            one.user_pixel_stride = channel_.format.bytes;
            one.user_line_stride = row;
            ++found;
        }
        return found == numbers_.size() &&
               exr_decoding_choose_default_routines(context_, channel_.part, &pipeline_) == EXR_ERR_SUCCESS &&
               exr_decoding_run(context_, channel_.part, &pipeline_) == EXR_ERR_SUCCESS;
    }
    /// Whether all channels that have to be are the same.
    bool is_grey() const {
        return std::all_of(numbers_.begin(), numbers_.end(),
                           [&](const auto& one) { return one == numbers_[0]; });
    }
    NumberBlock block(int width, int height) const {
        const int bytes = channel_.format.bytes;
        return {numbers_[0].data(), width, height, bytes, std::ptrdiff_t{bytes} * width};
    }

private:
    std::optional<std::size_t> place_of(std::string_view name) const {
        if (name == channel_.name) return 0;
        const auto found = std::find(channel_.same.begin(), channel_.same.end(), name);
        if (found == channel_.same.end()) return std::nullopt;
        return static_cast<std::size_t>(found - channel_.same.begin()) + 1;
    }

    exr_const_context_t context_;
    const ExrChannel& channel_;
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

Result<StoredImage> ExrFile::read() {
    if (auto opened = open(); !opened) return opened.error();
    const auto channel = choose();
    if (!channel) return channel.error();
    exr_attr_box2i_t data_box, display_box;
    if (exr_get_data_window(context_, channel->part, &data_box) != EXR_ERR_SUCCESS ||
        exr_get_display_window(context_, channel->part, &display_box) != EXR_ERR_SUCCESS)
        return damaged();
    const auto data = ExrWindow::of(data_box), display = ExrWindow::of(display_box);
    if (!data || !display) return refused("has a window that is empty or larger than 16384x16384 pixels");
    if (!display->holds(*data)) return refused("has a data window beyond its display window: must be inside");
    const auto needed =
        static_cast<std::uint64_t>(display->width) * static_cast<std::uint64_t>(display->height) * 4;
    if (auto likely = check_expansion(needed, bytes_.bytes.size(), where_); !likely) return likely.error();
    exr_compression_t packing;
    if (exr_get_compression(context_, channel->part, &packing) != EXR_ERR_SUCCESS) return damaged();
    if (packing == EXR_COMPRESSION_DWAA || packing == EXR_COMPRESSION_DWAB)
        return refused("is compressed by DWA: must be by ZIP, PIZ or another that loses nothing");
    ExrGrid grid;
    if (!grid.read(context_, channel->part, *data)) return damaged();

    NumberPicture picture(display->width, display->height, channel->format);
    if (!(*data == *display)) fill_with_nothing(picture, channel->format, *display);
    ExrChunks chunks(context_, *channel);
    const int across = static_cast<int>(grid.across), down = static_cast<int>(grid.down);
    for (int y = 0; y < data->height; y += down)
        for (int x = 0; x < data->width; x += across) {
            exr_chunk_info_t chunk;
            const int width = std::min(across, data->width - x), height = std::min(down, data->height - y);
            if (!grid.find(context_, channel->part, *data, x, y, chunk) || chunk.width != width ||
                chunk.height != height || !chunks.unpack(chunk))
                return damaged();
            if (!chunks.is_grey())
                return refused("is in colour: a picture of depth has a channel Z, depth, Y or R");
            picture.put(data->x - display->x + x, data->y - display->y + y, chunks.block(width, height));
        }
    return std::move(picture).finish("exr");
}

}  // namespace

bool is_exr(std::string_view begin) {
    return begin.starts_with("\x76\x2f\x31\x01");
}

Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where) {
    return ExrFile(bytes, where).read();
}

}  // namespace touchable
