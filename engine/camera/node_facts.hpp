#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/camera/video_system.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A size of pictures that a camera offers, and at which rates.
struct NodeMode {
    int width = 0, height = 0;
    std::vector<FrameRate> rates{};  ///< the fastest first; empty: the camera does not say
};

/// A kind of pictures that a camera offers.
struct NodeFormat {
    std::uint32_t code = 0;         ///< V4L2_PIX_FMT_...
    std::string name;               ///< the driver's words
    std::vector<NodeMode> modes{};  ///< empty: the camera does not say
    bool any_size = false;          ///< sizes between the least and the greatest in `modes`, too
};

/// What a node is, as its driver tells.
struct NodeFacts {
    std::string node, driver, card, bus;
    bool captures = false;  ///< gives pictures by memory that is mapped; nodes of metadata do not
    std::vector<NodeFormat> formats{};
};

/// Of an open device.
Result<NodeFacts> facts_of_node(VideoSystem& system, int descriptor, const std::string& node);
/// Opens it to look, and closes it again. Others may use it meanwhile.
Result<NodeFacts> look_at_node(VideoSystem& system, const std::string& node);

/// Whether pictures of this format can be touched: Z16, and grey of 16 bits in either byte order.
bool is_depth_format(std::uint32_t code);
/// The format by which a node is touched: Z16, which is depth for certain, before grey. An error names what
/// it gives instead.
Result<const NodeFormat*> depth_of_node(const NodeFacts& facts);
/// Whether pictures of this format can be shown as colour.
bool is_colour_format(std::uint32_t code);
/// "Z16", "YUYV"; "Y16 (big-endian)".
std::string format_text(std::uint32_t code);

/// Seconds between pictures the other way round; nothing where it is none, or none that a camera has.
std::optional<FrameRate> rate_of_interval(std::uint32_t numerator, std::uint32_t denominator);
double per_second(const FrameRate& rate);
/// "30", "29.97", of frames a second.
std::string rate_text(const FrameRate& rate);

/// What somebody wants of a stream; nothing: what is usual.
struct ModeWish {
    int width = 0, height = 0;        ///< 0: the largest of usual rate, up to 1280x720
    std::optional<double> rate = {};  ///< frames a second; nothing: 30, or the nearest to that
};
/// The mode to ask for. `rates` of it has one rate, or none where the camera does not say. An error, without
/// the node's name, where the format has no such size.
Result<NodeMode> choose_mode(const NodeFormat& format, const ModeWish& wish);

/// "640x480 at 30, 15 frames/s".
std::string mode_text(const NodeMode& mode);

}  // namespace touchable
