// SPDX-License-Identifier: Apache-2.0
// Clips packed for pages in browsers (docs/web.md): samples as RankEncoder codes them, under deflate, which a
// browser inflates and checks by itself; a picture is stored once, however many frames show it. Files are
// named by what they hold, so that neither a cache nor a page takes a part of one clip for that of another.
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/plane_memory.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using Ordered = nlohmann::ordered_json;

constexpr const char* version_key = "touchable_packed";
/// Packets of version 1 have no checksum, and its files no hash in their names.
constexpr int version = 2;
constexpr std::size_t largest_text = std::size_t{64} << 20;
constexpr std::int64_t most_frames = 1'000'000;

std::size_t place(PlaneRole role) {
    return static_cast<std::size_t>(role);
}
std::string file_of(PlaneRole role, const std::string& hash = "") {
    return std::string(role_name(role)) + hash + ".bin";
}
/// "-" and the 16 digits of the hash of a file's content.
std::string hash_in_name(const ByteHash& hash) {
    return '-' + hash.hex();
}
/// A file's name without the hash in it.
std::string unhashed(std::string name) {
    constexpr std::size_t size = 17;
    const std::size_t dot = std::min(name.rfind('.'), name.size()), at = dot - std::min(dot, size);
    const std::size_t other = name.find_first_not_of("0123456789abcdef", at + 1);
    if (name[at] == '-' && other == dot && dot - at == size) name.erase(at, size);
    return name;
}

/// A plane's samples of two bytes; of several channels one picture below the other.
std::vector<std::uint16_t> samples_of(const PlaneView& plane) {
    std::vector<std::uint16_t> samples;
    samples.reserve(pixel_count(plane.width, plane.height * plane.channels));
    for (int channel = 0; channel < plane.channels; ++channel)
        for (int y = 0; y < plane.height; ++y)
            for (int x = 0; x < plane.width; ++x) samples.push_back(plane.sample(x, y, channel));
    return samples;
}

constexpr int window_bits = 15;  // of deflate with a header and a checksum; negative: without

/// Returns its size; 0: it failed.
std::size_t deflated(std::span<const std::uint8_t> from, std::span<std::uint8_t> to, int level) {
    constexpr int memory = 9;
    z_stream stream{};
    if (deflateInit2(&stream, level, Z_DEFLATED, window_bits, memory, Z_DEFAULT_STRATEGY) != Z_OK) return 0;
    stream.next_in = const_cast<std::uint8_t*>(from.data());
    stream.avail_in = static_cast<uInt>(from.size());
    stream.next_out = to.data();
    stream.avail_out = static_cast<uInt>(to.size());
    const bool is_whole = deflate(&stream, Z_FINISH) == Z_STREAM_END;
    deflateEnd(&stream);
    return is_whole ? stream.total_out : 0;
}

/// A packet's head and content, of at most so many bytes; empty: it is damaged. `plain`: bytes of a head that
/// is not deflated, before deflate without a checksum.
std::vector<std::uint8_t> inflated(std::string_view packet, std::size_t plain, std::size_t most) {
    std::vector<std::uint8_t> bytes(most);
    z_stream stream{};
    if (packet.size() < plain || inflateInit2(&stream, plain > 0 ? -window_bits : window_bits) != Z_OK)
        return {};
    std::copy_n(packet.begin(), plain, bytes.begin());
    stream.next_in = reinterpret_cast<std::uint8_t*>(const_cast<char*>(packet.data() + plain));
    stream.avail_in = static_cast<uInt>(packet.size() - plain);
    stream.next_out = bytes.data() + plain;
    stream.avail_out = static_cast<uInt>(most - plain);
    const bool is_whole = inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.avail_in == 0;
    bytes.resize(is_whole ? plain + stream.total_out : 0);
    inflateEnd(&stream);
    return bytes;
}

/// The members of clip.json that a live source has, too. `numbers` are the scene's once more, by name.
Ordered json_of(const SceneDescription& described, const RawFrame& first) {
    SceneDescription pictures = described;
    pictures.scene.folder.reset();
    pictures.scene.video.reset();
    pictures.scene.stored = {};  // codes
    Ordered json{{version_key, version}, {"name", described.scene.name}};
    for (const Remark& remark : described.scene.remarks) json["remarks"].push_back(remark.what);
    json["scene"] = Ordered::parse(scene_to_json(pictures));
    if (const auto& times = described.scene.rate.own_times)
        pictures.scene.rate = rate_of_own_times(*times).value_or(described.scene.rate);
    for (const SceneNumber& number : numbers_of(pictures.scene))
        json["numbers"][number.name] = std::isnan(number.value) ? Ordered() : Ordered(number.value);
    if (const double to = described.error_bars_to; to > 0)
        json["error_bars_to"] = std::isinf(to) ? Ordered() : Ordered(to);
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(first, role);
        if (plane.empty()) continue;
        Ordered& of = json["planes"][std::string(role_name(role))];
        of = {{"file", file_of(role)}};
        if (role == PlaneRole::colour)
            of["kind"] = "image/jpeg";
        else
            of.update({{"bytes_per_sample", plane.bytes_per_sample}, {"channels", plane.channels}});
    }
    return json;
}

/// A name may be no UTF-8.
std::string text_of(const Ordered& json) {
    return json.dump(-1, ' ', false, Ordered::error_handler_t::replace) + '\n';
}

class PackedWriter final : public ClipWriter {
public:
    PackedWriter(const fs::path& folder, const SceneDescription& described, const std::vector<fs::path>& page,
                 Existing existing)
        : folder_(folder), described_(described), page_(page), existing_(existing), hidden_(folder) {}

    Result<void> open() {
        if (hidden_.failure())
            return input_error(folder_.string() + ": cannot be written: " + hidden_.failure().message());
        return {};
    }

    Result<void> write(const RawFrame& frame) override {
        TRY(check_.check(frame, described_.scene));
        if (check_.frames() == 1) json_ = json_of(described_, frame);
        TRY_ASSIGN(const auto packets, packer_.pack(frame));
        for (const PlaneRole role : all_roles) {
            if (plane_of(frame, role).empty()) continue;
            const std::string& packet = packets[place(role)];
            json_["planes"][std::string(role_name(role))]["sizes"].push_back(packet.size());
            std::ofstream& file = files_[place(role)];
            if (!file.is_open()) file.open(hidden_.path() / file_of(role), std::ios::binary);
            if (!(file << packet)) return unwritten(role);
            hashes_[place(role)].add(packet.data(), packet.size());
        }
        const std::string& colour = packets[place(PlaneRole::colour)];
        if (colour.empty()) return {};
        TRY_ASSIGN(auto seen, decode_stored_image(colour, folder_.string()));
        colour_ = std::move(seen.image);
        return {};
    }
    PlaneView stored_colour() const override {
        return colour_.samples.empty() ? PlaneView() : colour_.view();
    }

    Result<fs::path> complete() override {
        if (check_.frames() == 0) return input_error(folder_.string() + ": not written: no frame was given");
        json_["frames"] = check_.frames();
        if (const auto& times = described_.scene.rate.own_times) json_["times_ns"] = *times;
        for (const PlaneRole role : all_roles) {
            std::ofstream& file = files_[place(role)];
            if (!file.is_open()) continue;
            file.close();
            std::error_code failure;
            names_.push_back(file_of(role, hash_in_name(hashes_[place(role)])));
            fs::rename(hidden_.path() / file_of(role), hidden_.path() / names_.back(), failure);
            if (!file || failure) return unwritten(role);
            json_["planes"][std::string(role_name(role))]["file"] = names_.back();
        }
        for (const fs::path& file : page_) {
            std::error_code failure;
            names_.push_back(file.filename());
            fs::copy_file(file, hidden_.path() / names_.back(), failure);
            if (failure) return input_error(file.string() + ": cannot be copied: " + failure.message());
        }
        // The names that stay the same come last, as they open the others: clip and page are the old or the
        // new.
        std::partition(names_.begin(), names_.end(),
                       [](const std::string& name) { return name != unhashed(name); });
        names_.push_back(packed_clip_name);
        TRY(hidden_.write(folder_, packed_clip_name, text_of(json_)));
        TRY(hidden_.sync(folder_));
        return hidden_.path() / packed_clip_name;
    }

    Result<void> finish() override {
        if (names_.empty()) TRY(complete());
        const std::set<std::string> plain = plain_names();
        // Earlier files stay until the disk has the new names: before that, a power failure may bring back
        // the clip.json that names them.
        TRY(hidden_.move_to(folder_, names_, existing_));
        hidden_.remove();
        if (existing_ == Existing::replace) remove_earlier(plain);
        return {};
    }

private:
    /// The names without a hash that the folder's clip.json gives to planes: those of version 1.
    std::set<std::string> plain_names() const {
        std::set<std::string> plain;
        const auto text = SourceFile(folder_ / packed_clip_name).read("a packed clip", largest_text);
        const auto read = [&plain](const checked_json::Node& node) {
            if (node[version_key].integer(1, version) == 1)
                for (const PlaneRole role : all_roles)
                    if (node["planes"].has(std::string(role_name(role)).c_str())) plain.insert(file_of(role));
            return true;
        };
        if (text) (void)checked_json::read_checked(*text, largest_text, "", read);
        return plain;
    }
    /// Removes the files of an earlier clip and page, which clip.json and page no longer name. Without a hash
    /// in its name, a file is a person's own unless it is one of `plain`.
    void remove_earlier(const std::set<std::string>& plain) const {
        std::set<std::string> kinds;
        for (const std::string& name : names_) kinds.insert(unhashed(name));
        for (const PlaneRole role : all_roles) kinds.insert(file_of(role));
        std::error_code ignored;
        for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
            const std::string name = entry.path().filename().string(), kind = unhashed(name);
            if ((name == kind ? plain : kinds).contains(kind) &&
                std::ranges::find(names_, name) == names_.end())
                fs::remove(entry.path(), ignored);
        }
    }
    Error unwritten(PlaneRole role) const {
        return input_error((folder_ / file_of(role)).string() + ": cannot be written: is the disk full?");
    }

    fs::path folder_;
    SceneDescription described_;
    std::vector<fs::path> page_;
    Existing existing_;
    HiddenFolder hidden_;
    FrameCheck check_;
    FramePacker packer_;
    Ordered json_;
    std::array<std::ofstream, all_roles.size()> files_;
    std::array<ByteHash, all_roles.size()> hashes_;
    Image colour_;
    std::vector<std::string> names_;
};

/// Where a plane's packets are in its file.
struct PackedPlane {
    SourceFile file{fs::path()};
    int bytes_per_sample = 1, channels = 1;
    /// Of each frame: the frame that has its packet, and where that begins; one more for the file's end.
    std::vector<std::pair<std::int64_t, std::uint64_t>> packets{};
    /// Of the packets before this place, if they were read in order.
    ByteHash hash{};
    std::uint64_t hashed = 0;
};

class PackedPictures final : public FrameSource {
public:
    PackedPictures(int width, int height, bool is_checked)
        : width_(width), height_(height), is_checked_(is_checked) {}

    PackedPlane& plane(PlaneRole role) { return planes_[place(role)]; }
    std::string where(PlaneRole role, std::int64_t frame) const override {
        return planes_[place(role)].file.string() + ": frame " + std::to_string(frame);
    }
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        return planes_[place(role)].packets[static_cast<std::size_t>(frame)].first;
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        PackedPlane& plane = planes_[place(role)];
        const auto own = static_cast<std::size_t>(picture_number(role, frame));
        const std::uint64_t at = plane.packets[own].second;
        const std::string where = this->where(role, frame);
        TRY_ASSIGN(const auto bytes, bytes_of_file(plane.file));
        if (plane.packets[own + 1].second > bytes->size())
            return input_error(where + ": is cut: the file ends before it does");
        std::string packet(plane.packets[own + 1].second - at, '\0');
        TRY(error_at(where, bytes->read(at, packet.data(), packet.size())));
        TRY(check_hash(plane, role, at, packet));
        TrackPicture read;
        if (role == PlaneRole::colour) {
            TRY(assign(read.image, decode_stored_image(std::move(packet), where)));
            return read;
        }
        read.lossless = true;
        read.image.codec = "deflate";
        read.image.bits = 8 * plane.bytes_per_sample;
        read.image.pixel_format = plane.channels == 3           ? "rgb24"
                                  : plane.bytes_per_sample == 2 ? "gray16le"
                                                                : "gray";
        TRY(assign(read.image.image, error_at(where, unpacked(plane, packet))));
        return read;
    }

private:
    /// Once all packets were read, their file has to be what its name says. Colour has no other checksum.
    Result<void> check_hash(PackedPlane& plane, PlaneRole role, std::uint64_t at,
                            std::string_view packet) const {
        if (!is_checked_ || at != plane.hashed) return {};
        plane.hash.add(packet.data(), packet.size());
        plane.hashed += packet.size();
        if (plane.hashed != plane.packets.back().second ||
            plane.file.path().filename() == file_of(role, hash_in_name(plane.hash)))
            return {};
        return input_error(plane.file.string() + ": is damaged: holds other bytes than its name stands for");
    }
    Result<Image> unpacked(const PackedPlane& plane, std::string_view packet) const {
        constexpr std::size_t most_distinct = 65536, longest_head = 3;
        const std::size_t count = pixel_count(width_, height_ * plane.channels);
        const std::size_t most = longest_head + 2 * (std::min(count, most_distinct) + count);
        TRY(check_expansion(most, packet.size(), "it"));
        const std::size_t plain = is_checked_ ? 0 : packet.starts_with('\0') ? 1 : longest_head;
        const std::vector<std::uint8_t> bytes = inflated(packet, plain, most);
        const auto head = rank_head(bytes, count);
        Image image{width_, height_, plane.bytes_per_sample, plane.channels, {}};
        if (!head ||
            !take_rank_plane(*head, std::span(bytes).subspan(head->bytes), image.view(), image.samples))
            return input_error("is damaged: is no picture of the clip");
        return image;
    }

    int width_, height_;
    bool is_checked_;
    std::array<PackedPlane, all_roles.size()> planes_;
};

using checked_json::Node;

/// The plane's sizes become places. Packets are of one picture each, so none is larger than `largest`.
void read_plane(const Node& node, PlaneRole role, const fs::path& folder, std::int64_t frames,
                PackedPlane& plane) {
    constexpr int largest = 1 << 30;
    const std::string name = node["file"].text();
    if (unhashed(name) != file_of(role)) node["file"].refuse(file_of(role, "-HASH"));
    plane.file = SourceFile(folder / name);
    if (role != PlaneRole::colour) {
        plane.bytes_per_sample = node["bytes_per_sample"].whole(1, 2);
        plane.channels = node["channels"].whole(1, 3);
        if (plane.channels == 2 || plane.channels * plane.bytes_per_sample == 6)
            node["channels"].refuse("1, or 3 of one byte");
    }
    const auto count = static_cast<std::size_t>(frames);
    const auto sizes = node["sizes"].elements(count, count, "a size for each frame");
    std::uint64_t at = 0;
    for (std::size_t frame = 0; frame < count; ++frame) {
        const int size = sizes[frame].whole(frame == 0 ? 1 : 0, largest);
        const std::int64_t own = size > 0 ? static_cast<std::int64_t>(frame) : plane.packets.back().first;
        plane.packets.emplace_back(own, at);
        at += static_cast<std::uint64_t>(size);
    }
    plane.packets.emplace_back(frames, at);
}

StoredClip read_packed(const Node& node, const fs::path& file) {
    const bool is_checked = node[version_key].integer(1, version) > 1;
    if (node.has("live")) node["live"].refuse("left out: a live page's frames are not beside it");
    auto described = parse_scene(node["scene"].json(), "scene");
    if (!described) throw checked_json::Refusal{described.error().message};
    StoredClip clip{file.string(), std::move(*described)};
    Scene& scene = clip.described.scene;
    clip.count = node["frames"].integer(1, most_frames);
    if (node.has("times_ns")) {
        std::vector<std::int64_t> times;
        const auto count = static_cast<std::size_t>(clip.count);
        for (const Node& time : node["times_ns"].elements(count, count, "a time for each frame"))
            times.push_back(time.integer(0, std::numeric_limits<std::int64_t>::max() / 2));
        auto rate = rate_of_own_times(std::move(times));
        if (!rate) node["times_ns"].refuse("times that increase");
        scene.rate = std::move(*rate);
        clip.described.unstated.rate = false;
    }
    std::size_t same = 0;
    const auto numbers = numbers_of(scene);
    const Node stated = node["numbers"];
    for (const SceneNumber& number : numbers)
        if (stated.has(number.name.c_str())) {
            const std::string text = stated[number.name.c_str()].json();
            same += std::isnan(number.value) ? text == "null" : parsed_number(text) == number.value;
        }
    if (same != numbers.size()) stated.refuse("the numbers of its scene: one of the two was changed");
    clip.inputs = {file};
    auto pictures = std::make_shared<PackedPictures>(scene.width, scene.height, is_checked);
    for (const PlaneRole role : all_roles) {
        const std::string name(role_name(role));
        if (!node["planes"].has(name.c_str())) continue;
        read_plane(node["planes"][name.c_str()], role, file.parent_path(), clip.count, pictures->plane(role));
        clip.roles.push_back(role);
        clip.inputs.push_back(pictures->plane(role).file.path());
    }
    if (clip.roles.empty() || clip.roles.front() != PlaneRole::depth)
        node["planes"].refuse("a depth plane, and others beside it");
    clip.pictures = std::move(pictures);
    return clip;
}

}  // namespace

Result<std::array<std::string, all_roles.size()>> FramePacker::pack(const RawFrame& frame) {
    std::array<std::string, all_roles.size()> packets;
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(frame, role);
        if (stop_requested()) return interrupted_error();
        if (plane.empty() || same_samples(plane_of(before_, role), plane)) continue;
        if (role == PlaneRole::colour) {
            TRY(assign(packets[place(role)], jpeg_bytes(plane)));
            continue;
        }
        auto& encoder = encoders_[place(role)];
        if (!encoder)
            encoder.emplace([level = level_](auto from, auto to) { return deflated(from, to, level); }, true);
        const auto samples = samples_of(plane);
        const auto packet = encoder->encode(
            plane_of_codes(samples.data(), plane.width, plane.height * plane.channels), false);
        if (packet.empty()) return internal_error("memory does not suffice to deflate a picture");
        packets[place(role)].assign(packet.begin(), packet.end());
    }
    before_ = kept_frame(frame);
    return packets;
}

std::string packed_live_json(const SceneDescription& described, const RawFrame& first,
                             const std::string& live) {
    Ordered json = json_of(described, first);
    json["live"] = live;
    return text_of(json);
}

bool is_packed_clip(const SourceFile& file) {
    constexpr std::size_t telling = 32;
    return first_bytes(file, telling).find(version_key) != std::string::npos;
}

Opened open_packed_clip(const Candidate& candidate) {
    const fs::path& file = candidate.source.path();
    TRY_ASSIGN(const auto text, candidate.source.read("a packed clip", largest_text));
    TRY_ASSIGN(auto clip,
               checked_json::read_checked(text, largest_text, file.string(),
                                          [&](const Node& node) { return read_packed(node, file); }));
    return open_stored_clip(std::move(clip), candidate.wanted.colour);
}

Result<std::unique_ptr<ClipWriter>> create_packed_clip(const fs::path& folder,
                                                       const SceneDescription& described,
                                                       const std::vector<fs::path>& page, Existing existing) {
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (!fs::is_directory(folder, failure))
        return input_error(folder.string() + ": cannot be made a folder" +
                           (failure ? ": " + failure.message() : ": a file has that name"));
    return opened_as<ClipWriter>(std::make_unique<PackedWriter>(folder, described, page, existing));
}

}  // namespace touchable
