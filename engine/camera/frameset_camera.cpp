#include "engine/camera/frameset_camera.hpp"

#include <linux/videodev2.h>
#include <poll.h>
#include <zlib.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/camera/depth_meaning.hpp"
#include "engine/camera/live_bytes.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {

namespace {

constexpr std::array<std::uint8_t, 8> magic{'F', 'R', 'A', 'M', 'E', 'S', 'E', 'T'};
constexpr std::uint32_t frameset_version = 1;
// Where the header's own checksum is; it is of all before.
constexpr std::size_t checksum_at = frameset_header_bytes - 4;
constexpr std::size_t most_strays = std::size_t{256} << 20U;
// How often a byte may be checked, at most of so many at once.
constexpr std::size_t checks_per_byte = 4, most_credit = 8 * 5 * most_frameset_pixels;

std::uint64_t number_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
    std::uint64_t number = 0;
    for (std::size_t k = size; k-- > 0;) number = number << 8U | bytes[at + k];
    return number;
}
std::uint32_t whole_at(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<std::uint32_t>(number_at(bytes, at, 4));
}
double real_at(std::span<const std::uint8_t> bytes, std::size_t at) {
    return std::bit_cast<double>(number_at(bytes, at, 8));
}

std::uint32_t checksum(std::span<const std::uint8_t> bytes) {
    return static_cast<std::uint32_t>(::crc32_z(0, bytes.data(), bytes.size()));
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
    return std::to_string(width) + "x" + std::to_string(height);
}
std::string lens_text(const FramesetHeader& header) {
    return formatted("fx %.6g, fy %.6g, cx %.6g, cy %.6g", header.fx, header.fy, header.cx, header.cy);
}

bool is_picture_size(std::uint32_t width, std::uint32_t height) {
    constexpr std::uint32_t largest_side = 16384;
    return width >= 1 && height >= 1 && width <= largest_side && height <= largest_side &&
           std::size_t{width} * height <= most_frameset_pixels;
}

/// Of a lens through which somebody sees. False for what is no number, too.
bool is_lens(const FramesetHeader& header) {
    const auto is_length = [](double focal, double side) {
        return focal >= 0.01 * side && focal <= 1000 * side;
    };
    const auto is_place = [](double at, double side) { return at >= -side && at <= 2 * side; };
    return is_length(header.fx, header.width) && is_length(header.fy, header.height) &&
           is_place(header.cx, header.width) && is_place(header.cy, header.height);
}

/// Of bytes that are as the sender meant them.
Result<FramesetHeader> read_header(std::span<const std::uint8_t> bytes) {
    const std::uint32_t version = whole_at(bytes, 8), length = whole_at(bytes, 12);
    if (version != frameset_version || length != frameset_header_bytes)
        return input_error("gives framesets of version " + std::to_string(version) + " with headers of " +
                           std::to_string(length) + " bytes; read are those of version 1 with 100");
    const std::uint32_t width = whole_at(bytes, 32), height = whole_at(bytes, 36);
    const std::uint32_t colour_width = whole_at(bytes, 80), colour_height = whole_at(bytes, 84);
    const std::uint32_t flags = whole_at(bytes, 88);
    if (!is_picture_size(width, height))
        return input_error("gives depth of " + size_text(width, height) +
                           " pixels; right are sides of 1 to 16384, and 16777216 pixels at most");
    const bool has_colour = colour_width != 0 || colour_height != 0;
    if (has_colour && !is_picture_size(colour_width, colour_height))
        return input_error("gives colour of " + size_text(colour_width, colour_height) +
                           " pixels; right are 0x0 for none, or sides of 1 to 16384, and 16777216 pixels "
                           "at most");
    if (flags > 1)
        return input_error("gives framesets with flags " + std::to_string(flags) + "; known are 0 and 1");
    FramesetHeader header;
    header.number = number_at(bytes, 16, 8);
    header.time_ns = static_cast<std::int64_t>(number_at(bytes, 24, 8));
    header.width = static_cast<int>(width);
    header.height = static_cast<int>(height);
    header.metres_per_unit = real_at(bytes, 40);
    header.fx = real_at(bytes, 48);
    header.fy = real_at(bytes, 56);
    header.cx = real_at(bytes, 64);
    header.cy = real_at(bytes, 72);
    header.colour_width = static_cast<int>(colour_width);
    header.colour_height = static_cast<int>(colour_height);
    header.colour_is_registered = flags == 1;
    if (!(header.metres_per_unit >= 1e-7 && header.metres_per_unit <= 1))
        return input_error(
            formatted("gives a unit of %.6g m; right is 0.0000001 to 1, such as 0.001 for millimetres",
                      header.metres_per_unit));
    if (!is_lens(header))
        return input_error("gives a lens with " + lens_text(header) + ", which no picture of " +
                           size_text(width, height) + " has; right are pixels");
    return header;
}

std::string meaning_text(const FramesetHeader& header) {
    return formatted("%dx%d of %.6g m with ", header.width, header.height, header.metres_per_unit) +
           lens_text(header) +
           (header.has_colour() ? " and colour of " + std::to_string(header.colour_width) + "x" +
                                      std::to_string(header.colour_height)
                                : std::string(" without colour"));
}

struct TakenFrameset {
    Frameset frameset;
    std::int64_t at_ns = 0;  ///< of std::chrono::steady_clock
};

std::int64_t ns_now() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// By the middle one of the sender's times from frame to frame; 30 where they cannot be.
FrameRate rate_of(const std::vector<TakenFrameset>& taken) {
    std::vector<double> apart_ns;
    for (std::size_t k = 1; k < taken.size(); ++k)
        apart_ns.push_back(static_cast<double>(taken[k].frameset.header.time_ns) -
                           static_cast<double>(taken[k - 1].frameset.header.time_ns));
    std::sort(apart_ns.begin(), apart_ns.end());
    const double rate = 1e9 / apart_ns[apart_ns.size() / 2];
    if (!(rate >= 0.1 && rate <= 1000)) return {30, 1};
    return {std::llround(1000 * rate), 1000};
}

class FramesetCamera final : public ClipReader {
public:
    explicit FramesetCamera(FramesetChoice choice)
        : choice_(std::move(choice)), name_(printable(choice_.name())), run_(name_) {}
    Result<void> open(const SourceDescription& known, const std::optional<std::filesystem::path>& scene_file);

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return unstated_filters_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return std::nullopt; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override { return run_.seek(frame); }
    void leave_out_colour() override { shows_colour_ = false; }
    bool is_live() const override { return true; }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override;
    void interrupt() override { run_.interrupt(); }
    std::vector<std::string> remarks() const override;

private:
    enum class Which { oldest, newest };
    Result<void> look_first(SourceDescription known, const std::optional<std::filesystem::path>& scene_file);
    Result<std::optional<TakenFrameset>> take(Which which);
    Result<std::optional<TakenFrameset>> wait_for_frameset();
    void wait(std::chrono::milliseconds longest) const;
    std::optional<RawFrame> frame_of(const TakenFrameset& taken);

    const FramesetChoice choice_;
    const std::string name_;
    CameraRun run_;
    std::unique_ptr<LiveBytes> source_;
    FramesetParser parser_;
    SenderClock clock_;
    std::vector<std::uint8_t> chunk_ = std::vector<std::uint8_t>(std::size_t{1} << 18U);
    bool has_said_anything_ = false, shows_colour_ = true;
    Scene scene_;
    UnstatedFilters unstated_filters_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::atomic<std::int64_t> damaged_{0}, repeated_{0};
};

/// What is there; nothing where no whole one is. An error once no more will come: what happened.
Result<std::optional<TakenFrameset>> FramesetCamera::take(Which which) {
    constexpr std::size_t most_at_once = std::size_t{16} << 20U;  // then somebody may have told it to end
    std::optional<TakenFrameset> best;
    for (std::size_t read = 0; read < most_at_once;) {
        auto whole = parser_.next();
        damaged_ = parser_.damaged();
        repeated_ = parser_.repeated();
        if (!whole && best) break;  // it will say so again
        if (!whole) return whole.error();
        if (*whole) {
            const std::int64_t sent_ns = (*whole)->header.time_ns;
            best = TakenFrameset{std::move(**whole), clock_.taken_at(sent_ns, ns_now())};
            if (which == Which::oldest) break;
            continue;
        }
        const auto got = source_->read(chunk_);
        if (!got && best) break;
        if (!got) return input_error(source_->how_it_ended());
        if (*got == 0) break;
        has_said_anything_ = true;
        read += *got;
        parser_.take(std::span(chunk_).first(*got));
    }
    return best;
}

/// The oldest before the run, the newest in it; nothing once it has ended.
Result<std::optional<TakenFrameset>> FramesetCamera::wait_for_frameset() {
    const auto begun = std::chrono::steady_clock::now();
    std::optional<std::chrono::steady_clock::time_point> heard;
    while (!run_.is_gone()) {
        if (auto end = run_.told_to_end()) return *end;
        auto taken = take(run_.has_begun() ? Which::newest : Which::oldest);
        if (!taken) {
            run_.gone(taken.error().message);
            break;
        }
        if (*taken) return taken;
        const auto now = std::chrono::steady_clock::now();
        if (has_said_anything_ && !heard) heard = now;
        const auto until = heard ? *heard + choice_.patience : begun + choice_.first_patience;
        if (!run_.has_begun() && now > until)
            return input_error(name_ + (heard ? ": sent no whole frameset in " : ": sent nothing in ") +
                               std::to_string((heard ? choice_.patience : choice_.first_patience).count()) +
                               " ms" + (damaged_ > 0 ? ", but damaged ones" : ""));
        constexpr std::chrono::milliseconds look_again(100), ever(-1);
        wait(run_.has_begun() ? ever : look_again);
    }
    return std::optional<TakenFrameset>();
}

void FramesetCamera::wait(std::chrono::milliseconds longest) const {
    const auto sources = source_->waits();
    std::array<pollfd, 3> all{pollfd{run_.descriptor(), POLLIN, 0}, sources[0], sources[1]};
    (void)::poll(all.data(), all.size(), static_cast<int>(longest.count()));
}

/// What it sends, and what that means.
Result<void> FramesetCamera::look_first(SourceDescription known,
                                        const std::optional<std::filesystem::path>& scene_file) {
    constexpr int first_framesets = 8;
    std::vector<TakenFrameset> taken;
    std::vector<PlaneView> views;
    for (int k = 0; k < first_framesets; ++k) {
        TRY_ASSIGN(auto frameset, wait_for_frameset());
        if (!frameset) return input_error(run_.remarks().back());
        views.push_back(frameset->frameset.depth());
        taken.push_back(std::move(*frameset));
    }
    const FramesetHeader& sent = taken.front().frameset.header;
    if (!known.intrinsics && !known.fov && known.preset.empty())
        known.intrinsics = Intrinsics{sent.fx, sent.fy, sent.cx, sent.cy, sent.width, sent.height};
    if (!known.metres_per_code && known.preset.empty()) known.metres_per_code = sent.metres_per_unit;
    NodeFacts facts;
    facts.node = name_;
    facts.card = "a sender of framesets";
    TRY_ASSIGN(auto meaning, scene_file ? meaning_in_file(facts, views, *scene_file)
                                        : meaning_of_depth(facts, V4L2_PIX_FMT_Z16, views, known));
    scene_ = std::move(meaning.scene);
    unstated_filters_ = meaning.unstated_filters;
    scene_.interpolation = FrameInterpolation::hold;
    scene_.rate = rate_of(taken);
    for (const auto& input : meaning.inputs) add_input(input);
    notes_.push_back(name_ + " sends depth of " +
                     formatted("%dx%d, %.6g m a code, fx %.6g, fy %.6g, at %.4g frames/s", sent.width,
                               sent.height, sent.metres_per_unit, sent.fx, sent.fy, per_second(scene_.rate)));
    if (sent.time_ns == 0)
        notes_.emplace_back("the sender does not say when frames are taken: they count from their arrival");
    tracks_.push_back({"depth", "frameset", "gray16le", sent.width, sent.height, true});
    if (!sent.has_colour()) return {};
    tracks_.push_back({"colour", "frameset", "rgb24", sent.colour_width, sent.colour_height, true});
    if (!sent.colour_is_registered)
        notes_.emplace_back(
            "its colour is as another camera sees it: it is not moved to where depth is seen from");
    return {};
}

Result<void> FramesetCamera::open(const SourceDescription& known,
                                  const std::optional<std::filesystem::path>& scene_file) {
    if (run_.descriptor() < 0) return Error{ErrorKind::internal, "no event can be made to wait for"};
    TRY_ASSIGN(auto source,
               choice_.command.empty() ? connect_to(choice_.address) : start_command(choice_.command));
    source_ = std::move(source);
    return look_first(known, scene_file);
}

/// Nothing: it was taken before the run.
std::optional<RawFrame> FramesetCamera::frame_of(const TakenFrameset& taken) {
    const Frameset& frameset = taken.frameset;
    const auto place = run_.place(static_cast<std::uint32_t>(frameset.header.number), taken.at_ns);
    if (!place) return std::nullopt;
    RawFrame frame;
    frame.number = place->number;
    frame.time_ns = place->time_ns;
    add_plane(frame, PlaneRole::depth, {frameset.depth(), frameset.payload, 16});
    if (!shows_colour_ || !frameset.header.has_colour()) return frame;
    auto colour = fit_plane(PlaneRole::colour, {frameset.colour(), frameset.payload, 8}, scene_, name_);
    if (colour) add_plane(frame, PlaneRole::colour, std::move(*colour));
    return frame;
}

Result<std::optional<RawFrame>> FramesetCamera::next() {
    while (true) {
        TRY_ASSIGN(const auto taken, wait_for_frameset());
        if (!taken && !run_.has_begun()) return input_error(run_.remarks().back());
        if (!taken) return std::optional<RawFrame>();
        if (auto frame = frame_of(*taken)) return frame;
    }
}

Result<void> FramesetCamera::begin(std::chrono::steady_clock::time_point zero) {
    run_.begin(zero);
    // Those that wait are of before. How it ended it will say again.
    if (!run_.is_gone()) (void)take(Which::newest);
    return {};
}

std::vector<std::string> FramesetCamera::remarks() const {
    std::vector<std::string> all = run_.remarks();
    const auto tell = [&all](std::int64_t count, const char* what) {
        if (count > 0) all.insert(all.begin(), std::to_string(count) + " of the camera's frames " + what);
    };
    tell(repeated_, "came twice, and were left out once");
    tell(damaged_, "were damaged or cut short, and left out");
    return all;
}

}  // namespace

std::size_t FramesetHeader::depth_bytes() const {
    return std::size_t{2} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

std::size_t FramesetHeader::payload_bytes() const {
    return depth_bytes() +
           std::size_t{3} * static_cast<std::size_t>(colour_width) * static_cast<std::size_t>(colour_height);
}

bool FramesetHeader::means_the_same_as(const FramesetHeader& other) const {
    return width == other.width && height == other.height && metres_per_unit == other.metres_per_unit &&
           fx == other.fx && fy == other.fy && cx == other.cx && cy == other.cy &&
           colour_width == other.colour_width && colour_height == other.colour_height &&
           colour_is_registered == other.colour_is_registered;
}

PlaneView Frameset::depth() const {
    return {
        payload->data(), 2 * static_cast<std::ptrdiff_t>(header.width), header.width, header.height, 2, 1};
}

PlaneView Frameset::colour() const {
    if (!header.has_colour()) return {};
    return {payload->data() + header.depth_bytes(),
            3 * static_cast<std::ptrdiff_t>(header.colour_width),
            header.colour_width,
            header.colour_height,
            1,
            3};
}

void FramesetParser::take(std::span<const std::uint8_t> bytes) {
    if (begin_ > 0 && begin_ >= bytes_.size() / 2) {
        bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin_));
        begin_ = 0;
    }
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    credit_ = std::min(credit_ + checks_per_byte * bytes.size(), most_credit);
}

void FramesetParser::pass_over(std::size_t count) {
    begin_ += count;
    strays_ += count;
    if (count > 0 && !is_lost_) ++damaged_;
    is_lost_ = is_lost_ || count > 0;
}

/// False: bytes that say again and again that a frameset begins here, and none does, would keep this busy.
/// What waits is passed over.
bool FramesetParser::may_check(std::size_t count) {
    if (count <= credit_) {
        credit_ -= count;
        return true;
    }
    pass_over(rest().size());
    return false;
}

/// Passes over what is none. False: more bytes are needed.
bool FramesetParser::find_header() {
    while (true) {
        const auto left = rest();
        const void* const found =
            left.empty() ? nullptr : ::memmem(left.data(), left.size(), magic.data(), magic.size());
        if (found == nullptr) {
            // Of a magic number that goes on in the next bytes.
            const std::size_t kept = std::min(left.size(), magic.size() - 1);
            pass_over(left.size() - kept);
            return false;
        }
        pass_over(static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - left.data()));
        const auto header = rest();
        if (header.size() < frameset_header_bytes) return false;
        if (checksum(header.first(checksum_at)) == whole_at(header, checksum_at)) return true;
        pass_over(magic.size());
    }
}

Result<std::optional<Frameset>> FramesetParser::next() {
    while (find_header()) {
        TRY_ASSIGN(const auto header, read_header(rest()));
        const std::size_t length = header.payload_bytes();
        if (rest().size() < frameset_header_bytes + length) break;
        if (!may_check(length)) continue;
        const auto payload = rest().subspan(frameset_header_bytes, length);
        if (checksum(payload) != whole_at(rest(), checksum_at - 4)) {
            pass_over(magic.size());
            continue;
        }
        if (first_ && !first_->means_the_same_as(header))
            return input_error("gives " + meaning_text(header) + " where it gave " + meaning_text(*first_) +
                               "; a new run takes it as it is now");
        begin_ += frameset_header_bytes + length;
        strays_ = 0;
        is_lost_ = false;
        if (first_ && header.number == last_number_) {
            ++repeated_;
            continue;
        }
        if (!first_) first_ = header;
        last_number_ = header.number;
        Frameset whole{header, std::make_shared<std::vector<std::uint8_t>>(payload.begin(), payload.end())};
        if constexpr (std::endian::native == std::endian::big)
            for (std::size_t k = 0; k < header.depth_bytes(); k += 2)
                std::swap((*whole.payload)[k], (*whole.payload)[k + 1]);
        return std::optional(std::move(whole));
    }
    if (strays_ > most_strays)
        return input_error("gave " + std::to_string(most_strays >> 20U) +
                           " MiB in which no whole frameset is (docs/camera.md has what one is)");
    return std::optional<Frameset>();
}

Result<std::unique_ptr<ClipReader>> open_frameset_camera(
    const FramesetChoice& choice, const std::optional<SourceDescription>& known,
    const std::optional<std::filesystem::path>& scene_file) {
    auto camera = std::make_unique<FramesetCamera>(choice);
    TRY(camera->open(known.value_or(SourceDescription()), scene_file));
    return std::unique_ptr<ClipReader>(std::move(camera));
}

}  // namespace touchable
