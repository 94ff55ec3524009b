// SPDX-License-Identifier: Apache-2.0
#include "tests/import/bag_bytes.hpp"

#include <bzlib.h>
#include <lz4frame.h>

#include <algorithm>
#include <utility>

namespace touchable::test {
namespace {

constexpr char md5_of_image[] = "060021388200f6f0f447d0fcd9c64743";

std::string md5_of(const std::string& type) {
    const std::map<std::string, std::string> sums{
        {"sensor_msgs/Image", md5_of_image},
        {"sensor_msgs/CompressedImage", "8f7a12909da2c9d3332d540a0977563f"},
        {"sensor_msgs/CameraInfo", "c9a58c1b0b154e0e6da7578cb991d214"},
        {"std_msgs/Float32", "73fcbf46b49191e672908e50842a83d4"},
        {"geometry_msgs/Transform", "ac9eff44abf714214112b05d54a3cf9b"},
        {"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec"}};
    const auto found = sums.find(type);
    return found == sums.end() ? "00000000000000000000000000000000" : found->second;
}

std::string field(const std::string& name, const std::string& value) {
    std::string bytes;
    put_text(bytes, name + "=" + value);
    return bytes;
}
template <class Number>
std::string number_field(const std::string& name, Number number) {
    std::string value;
    put(value, number);
    return field(name, value);
}
std::string time_bytes(std::int64_t ns) {
    std::string bytes;
    put(bytes, static_cast<std::uint32_t>(ns / 1'000'000'000));
    put(bytes, static_cast<std::uint32_t>(ns % 1'000'000'000));
    return bytes;
}
std::string record(int op, const std::string& fields, const std::string& data) {
    std::string bytes;
    put_text(bytes, fields + number_field("op", static_cast<std::uint8_t>(op)));
    put_text(bytes, data);
    return bytes;
}

std::string packed(const std::string& bytes, const std::string& compression) {
    if (compression == "none") return bytes;
    std::string to;
    if (compression == "bz2") {
        to.resize(bytes.size() + bytes.size() / 50 + 700);
        auto size = static_cast<unsigned>(to.size());
        BZ2_bzBuffToBuffCompress(to.data(), &size, const_cast<char*>(bytes.data()),
                                 static_cast<unsigned>(bytes.size()), 9, 0, 0);
        to.resize(size);
    } else {
        to.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
        to.resize(LZ4F_compressFrame(to.data(), to.size(), bytes.data(), bytes.size(), nullptr));
    }
    return to;
}

void put_header(std::string& bytes, std::int64_t stamp_ns) {
    put(bytes, std::uint32_t{7});
    bytes += time_bytes(stamp_ns);
    put_text(bytes, "a_frame");
}

}  // namespace

void put_text(std::string& bytes, std::string_view text) {
    put(bytes, static_cast<std::uint32_t>(text.size()));
    bytes += text;
}

std::string ImageMessage::bytes() const {
    std::string all;
    put_header(all, stamp_ns);
    put(all, static_cast<std::uint32_t>(height));
    put(all, static_cast<std::uint32_t>(width));
    put_text(all, encoding);
    put(all, static_cast<std::uint8_t>(is_big_endian));
    put(all, step);
    put_text(all, data);
    return all;
}

std::string compressed_message(std::int64_t stamp_ns, const std::string& format, const std::string& data) {
    std::string all;
    put_header(all, stamp_ns);
    put_text(all, format);
    put_text(all, data);
    return all;
}

std::string camera_message(int width, int height, const std::vector<double>& camera,
                           const std::vector<double>& projection, const std::vector<double>& distortion) {
    std::string all;
    put_header(all, 0);
    put(all, static_cast<std::uint32_t>(height));
    put(all, static_cast<std::uint32_t>(width));
    put_text(all, "plumb_bob");
    put(all, static_cast<std::uint32_t>(distortion.size()));
    for (const double term : distortion) put(all, term);
    const std::vector<double>& p = projection.empty() ? camera : projection;
    for (const double term : {camera[0], 0., camera[2], 0., camera[1], camera[3], 0., 0., 1.}) put(all, term);
    for (const double term : {1., 0., 0., 0., 1., 0., 0., 0., 1.}) put(all, term);
    for (const double term : {p[0], 0., p[2], 0., 0., p[1], p[3], 0., 0., 0., 1., 0.}) put(all, term);
    all += std::string(4 * 6 + 1, '\0');
    return all;
}

std::string transform_message(const std::vector<double>& translation, const std::vector<double>& quaternion) {
    std::string all;
    for (const double term : translation) put(all, term);
    for (const double term : quaternion) put(all, term);
    return all;
}

void BagBytes::add(const std::string& topic, const std::string& type, std::int64_t time_ns,
                   const std::string& message) {
    const auto there = std::find_if(connections_.begin(), connections_.end(), [&](const Connection& each) {
        return each.topic == topic && each.type == type;
    });
    const auto id = static_cast<std::uint32_t>(there - connections_.begin());
    if (there == connections_.end()) connections_.push_back({topic, type});
    messages_.push_back({id, time_ns, message});
}

std::string BagBytes::connection_record(std::uint32_t id) const {
    const Connection& connection = connections_[id];
    return record(7, number_field("conn", id) + field("topic", connection.topic),
                  field("topic", connection.topic) + field("type", connection.type) +
                      field("md5sum", md5_of(connection.type)) + field("message_definition", ""));
}

std::string BagBytes::file(const std::string& compression, std::size_t messages_per_chunk) const {
    std::string chunks, infos;
    const std::string begin = "#ROSBAG V2.0\n";
    constexpr std::size_t header_size = 4096;
    std::uint32_t count = 0;
    for (std::size_t first = 0; first < messages_.size(); first += messages_per_chunk, ++count) {
        const std::size_t end = std::min(first + messages_per_chunk, messages_.size());
        std::string chunk;
        std::map<std::uint32_t, std::string> entries;
        for (std::size_t n = first; n < end; ++n) {
            const Message& message = messages_[n];
            if (entries.find(message.connection) == entries.end())
                chunk += connection_record(message.connection);
            std::string& index = entries[message.connection];
            index += time_bytes(message.time_ns);
            put(index, static_cast<std::uint32_t>(chunk.size()));
            chunk += record(
                2, number_field("conn", message.connection) + field("time", time_bytes(message.time_ns)),
                message.bytes);
        }
        const std::uint64_t at = begin.size() + header_size + chunks.size();
        chunks += record(5,
                         field("compression", compression) +
                             number_field("size", static_cast<std::uint32_t>(chunk.size())),
                         packed(chunk, compression));
        std::string counts;
        for (const auto& [id, index] : entries) {
            const auto messages = static_cast<std::uint32_t>(index.size() / 12);
            chunks += record(4,
                             number_field("ver", std::uint32_t{1}) + number_field("conn", id) +
                                 number_field("count", messages),
                             index);
            put(counts, id);
            put(counts, messages);
        }
        infos += record(6,
                        number_field("ver", std::uint32_t{1}) + number_field("chunk_pos", at) +
                            field("start_time", time_bytes(messages_[first].time_ns)) +
                            field("end_time", time_bytes(messages_[end - 1].time_ns)) +
                            number_field("count", static_cast<std::uint32_t>(entries.size())),
                        counts);
    }
    const std::string fields =
        number_field("index_pos", std::uint64_t{begin.size() + header_size + chunks.size()}) +
        number_field("conn_count", static_cast<std::uint32_t>(connections_.size())) +
        number_field("chunk_count", count);
    const std::size_t unpadded = record(3, fields, "").size();
    std::string all = begin + record(3, fields, std::string(header_size - unpadded, ' ')) + chunks;
    for (std::uint32_t id = 0; id < connections_.size(); ++id) all += connection_record(id);
    return all + infos;
}

}  // namespace touchable::test
