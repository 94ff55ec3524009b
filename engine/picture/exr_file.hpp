#pragma once

#include <openexr.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/exr_layers.hpp"
#include "engine/picture/number_picture.hpp"

namespace touchable {

/// A channel of an OpenEXR file with its numbers as they are stored.
struct ExrChannel : ExrChannelName {
    std::string in_part{};  ///< its name there
    NumberFormat format{};
    bool is_of_each_pixel = true;  ///< not subsampled
};

struct ExrWindow {
    int x = 0, y = 0, width = 0, height = 0;
    /// Nothing of one that is empty or too large.
    static std::optional<ExrWindow> of(const exr_attr_box2i_t& box);
    bool holds(const ExrWindow& other) const;
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

/// A file in memory as OpenEXR reads it, and the first that was wrong with it.
struct ExrBytes {
    std::string_view bytes;
    std::string wrong;
};

/// An OpenEXR file in memory.
class ExrFile {
public:
    ExrFile(std::string_view bytes, const std::string& where) : bytes_{bytes, {}}, where_(where) {}
    ~ExrFile() {
        if (context_) exr_finish(&context_);
    }
    ExrFile(const ExrFile&) = delete;
    ExrFile& operator=(const ExrFile&) = delete;

    /// First: its channels, at most 1024, of all parts that are not deep.
    Result<void> open();
    const std::vector<ExrChannel>& channels() const { return channels_; }
    /// Refuses parts that cannot be read.
    Result<ExrPart> part(int number) const;
    /// Unpacks these channels, all of one part, and each once.
    Result<void> read(const ExrPart& part, const std::vector<const ExrChannel*>& channels,
                      const PutExrChunk& put) const;

    Error refused(const std::string& why) const { return input_error(where_ + ": " + why); }

private:
    Result<void> list_channels(int part);
    Error damaged() const;

    ExrBytes bytes_;
    std::string where_;
    exr_context_t context_ = nullptr;
    std::vector<ExrChannel> channels_;
};

}  // namespace touchable
