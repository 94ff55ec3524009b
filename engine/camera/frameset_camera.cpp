// SPDX-License-Identifier: Apache-2.0
// Programs that send framesets: the bytes of a command or a connection, the framesets found in them, and
// these as a clip.
#include "engine/camera/frameset_camera.hpp"

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/socket.h>
#include <zlib.h>

#include <bit>
#include <cerrno>
#include <variant>

#include "engine/base/child_process.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/camera/v4l2_camera.hpp"
#include "engine/clip/readers.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {
namespace {

constexpr std::array<std::uint8_t, 8> magic{'F', 'R', 'A', 'M', 'E', 'S', 'E', 'T'};
constexpr std::uint32_t frameset_version = 1;
// Place of the header's own checksum, which covers all before it.
constexpr std::size_t checksum_at = frameset_header_bytes - 4;
constexpr std::size_t most_strays = std::size_t{256} << 20U;
// Checks allowed for each byte that came, and the most bytes of credit.
constexpr std::size_t checks_per_byte = 4, most_credit = 8 * 5 * most_frameset_pixels;

std::uint64_t number_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
    return number_in_bytes({reinterpret_cast<const char*>(&bytes[at]), size}, false);
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

std::string lens_text(const FramesetHeader& header) {
    return formatted("fx %.6g, fy %.6g, cx %.6g, cy %.6g", header.fx, header.fy, header.cx, header.cy);
}

bool is_picture_size(std::uint32_t width, std::uint32_t height) {
    constexpr std::uint32_t largest_side = 16384;
    return width >= 1 && height >= 1 && width <= largest_side && height <= largest_side &&
           std::size_t{width} * height <= most_frameset_pixels;
}

/// Whether a lens can have made the picture; false also for NaN.
bool is_lens(const FramesetHeader& header) {
    const auto is_length = [](double focal, double side) {
        return focal >= 0.01 * side && focal <= 1000 * side;
    };
    const auto is_place = [](double at, double side) { return at >= -side && at <= 2 * side; };
    return is_length(header.fx, header.width) && is_length(header.fy, header.height) &&
           is_place(header.cx, header.width) && is_place(header.cy, header.height);
}

/// Reads a header whose checksum is right.
Result<FramesetHeader> read_header(std::span<const std::uint8_t> bytes) {
    const std::uint32_t version = whole_at(bytes, 8), length = whole_at(bytes, 12);
    if (version != frameset_version || length != frameset_header_bytes)
        return input_error("gives framesets of version " + std::to_string(version) + " with headers of " +
                           std::to_string(length) + " bytes; must be version 1 with 100");
    const std::uint32_t width = whole_at(bytes, 32), height = whole_at(bytes, 36);
    const std::uint32_t colour_width = whole_at(bytes, 80), colour_height = whole_at(bytes, 84);
    const std::uint32_t flags = whole_at(bytes, 88);
    if (!is_picture_size(width, height))
        return input_error("gives depth of " + size_text(width, height) +
                           " pixels; must have sides of 1 to 16384, and 16777216 pixels at most");
    const bool has_colour = colour_width != 0 || colour_height != 0;
    if (has_colour && !is_picture_size(colour_width, colour_height))
        return input_error(
            "gives colour of " + size_text(colour_width, colour_height) +
            " pixels; must be 0x0 for none, or sides of 1 to 16384, and 16777216 pixels at most");
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
            formatted("gives a unit of %.6g m; must be 0.0000001 to 1, such as 0.001 for millimetres",
                      header.metres_per_unit));
    if (!is_lens(header))
        return input_error("gives a lens with " + lens_text(header) + ", which no picture of " +
                           size_text(width, height) + " has; must be pixels");
    return header;
}

std::string meaning_text(const FramesetHeader& header) {
    return formatted("%dx%d of %.6g m with ", header.width, header.height, header.metres_per_unit) +
           lens_text(header) +
           (header.has_colour() ? " and colour of " + size_text(header.colour_width, header.colour_height)
                                : " without colour");
}

/// The rate by the median of the sender's times from frame to frame; 30 if that cannot be.
FrameRate rate_of(const std::vector<std::int64_t>& sent_ns) {
    std::vector<double> apart_ns;
    for (std::size_t k = 1; k < sent_ns.size(); ++k)
        apart_ns.push_back(static_cast<double>(sent_ns[k]) - static_cast<double>(sent_ns[k - 1]));
    std::sort(apart_ns.begin(), apart_ns.end());
    const double apart = apart_ns[apart_ns.size() / 2];
    if (!(apart >= 1e6 && apart <= 1e10)) return {30, 1};
    return {std::llround(1e12 / apart), 1000};
}

constexpr std::int64_t longest_way_ns = 100'000'000;  // believed from being taken to arrival

/// What a connection sends, to be read like the output of a ChildProcess.
class Connection {
public:
    explicit Connection(Descriptor socket) : socket_(std::move(socket)) {}
    std::optional<std::size_t> read(std::span<std::uint8_t> into) {
        const auto got = ::recv(socket_.get(), into.data(), into.size(), MSG_DONTWAIT);
        if (got > 0) return static_cast<std::size_t>(got);
        if (got < 0 && would_wait(errno)) return std::size_t{0};
        if (got < 0) failure_ = errno;
        return std::nullopt;
    }
    std::array<pollfd, 2> waits() const { return {pollfd{socket_.get(), POLLIN, 0}, {-1, POLLIN, 0}}; }
    std::string how_it_ended() const {
        return failure_ == 0 ? "closed the connection" : "was lost (" + failure_words(failure_) + ")";
    }

private:
    Descriptor socket_;
    int failure_ = 0;
};

/// Bytes of a running program: the standard output of a command that /bin/sh runs, or a connection.
using LiveBytes = std::variant<std::unique_ptr<ChildProcess>, std::unique_ptr<Connection>>;

Result<SocketAddress> read_address(const std::string& words) {
    const auto url = read_stream_url("tcp://" + words);
    const auto address = url && !url->host.empty() && url->port > 0 && url->path.empty() && url->query.empty()
                             ? own_address(*url)
                             : std::nullopt;
    if (address) return *address;
    return usage_error("tcp://" + printable(words) +
                       ": must be an address in numbers or localhost, and a port, such as "
                       "tcp://192.168.0.5:7000 or tcp://[::1]:7000");
}

/// 0, or the errno of a failed connection.
Result<int> wait_for_connection(int socket) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    const bool is_there = work_until(until, [&] { return wait_unless_stopped(socket, POLLOUT); });
    if (!is_there && stop_requested()) return interrupted_error();
    if (!is_there) return ETIMEDOUT;
    int failure = 0;
    ::socklen_t length = sizeof failure;
    return ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &failure, &length) == 0 ? failure : errno;
}

Result<LiveBytes> start_command(const std::string& command) {
    TRY_ASSIGN(auto process,
               error_at("pipe:" + printable(command), ChildProcess::start({"/bin/sh", "-c", command})));
    if (!process) return input_error("pipe:" + printable(command) + ": there is no /bin/sh to start it");
    return process;
}

/// Connects within 5 s, or returns an error, which is of kind interrupted if the program is to stop.
Result<LiveBytes> connect_to(const std::string& address) {
    TRY_ASSIGN(const auto read, read_address(address));
    Descriptor socket(::socket(read.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto no_connection = [&](int failure) {
        return input_error("tcp://" + address + ": no connection: " + failure_words(failure) +
                           "; does the sender listen there?");
    };
    if (socket.get() < 0) return no_connection(errno);
    if (::connect(socket.get(), read.get(), read.length) != 0 && errno != EINPROGRESS)
        return no_connection(errno);
    TRY_ASSIGN(const auto failure, wait_for_connection(socket.get()));
    if (failure != 0) return no_connection(failure);
    return std::make_unique<Connection>(std::move(socket));
}

class FramesetCamera final : public LiveReader {
public:
    explicit FramesetCamera(const FramesetChoice& choice)
        : LiveReader(printable(choice.name())), choice_(choice) {}
    /// Finds what is sent, and its meaning.
    Result<void> open(SourceDescription known, const std::optional<std::filesystem::path>& scene_file) {
        constexpr int first_framesets = 8;
        TRY_ASSIGN(source_,
                   choice_.command.empty() ? connect_to(choice_.address) : start_command(choice_.command));
        std::vector<RawFrame> frames;
        std::vector<std::int64_t> sent_ns;
        FramesetHeader sent;
        for (int k = 0; k < first_framesets; ++k) {
            TRY_ASSIGN(auto first, first_frame());
            if (k == 0) sent = newest_;
            sent_ns.push_back(newest_.time_ns);
            frames.push_back(std::move(first.frame));
        }
        if (!known.intrinsics && !known.fov && known.preset.empty())
            known.intrinsics = Intrinsics{sent.fx, sent.fy, sent.cx, sent.cy, sent.width, sent.height};
        if (!known.metres_per_code && known.preset.empty()) known.metres_per_code = sent.metres_per_unit;
        NodeFacts facts;
        facts.node = name_;
        facts.card = "a sender of framesets";
        TRY_ASSIGN(auto meaning, meaning_of_depth(facts, V4L2_PIX_FMT_Z16, frames, known, scene_file));
        meaning.scene.rate = rate_of(sent_ns);
        take_meaning(std::move(meaning));
        notes_.push_back(name_ + " sends depth of " +
                         formatted("%dx%d, %.6g m a code, fx %.6g, fy %.6g, at %.4g frames/s", sent.width,
                                   sent.height, sent.metres_per_unit, sent.fx, sent.fy,
                                   scene_.rate.per_second()));
        if (sent.time_ns == 0)
            notes_.emplace_back(
                "the sender does not say when frames are taken: they count from their arrival");
        tracks_.push_back({"depth", "frameset", "gray16le", sent.width, sent.height, true});
        shows_colour_ = sent.has_colour();
        if (!shows_colour_) return {};
        tracks_.push_back({"colour", "frameset", "rgb24", sent.colour_width, sent.colour_height, true});
        if (!sent.colour_is_registered)
            notes_.emplace_back(
                "its colour is as another camera sees it: it is not moved to where depth is seen from");
        return {};
    }

    void leave_out_colour() override { shows_colour_ = false; }

private:
    MaybeTaken poll() override {
        constexpr std::size_t most_at_once = std::size_t{16} << 20U;  // then it checks for a stop
        std::optional<Frameset> best;
        std::int64_t at_ns = 0;
        for (std::size_t read = 0; read < most_at_once;) {
            auto whole = parser_.next();
            damaged_ = parser_.damaged();
            repeated_ = parser_.repeated();
            if (!whole && best) break;  // the error comes again
            if (!whole) return gone(whole.error().message);
            if (*whole) {
                best = std::move(*whole);
                at_ns = clock_.add(best->header.time_ns, steady_now_ns()).taken_ns;
                if (!has_begun()) break;
                continue;
            }
            const auto got = std::visit([&](auto& source) { return source->read(chunk_); }, source_);
            if (!got && best) break;
            if (!got) return gone(std::visit([](auto& source) { return source->how_it_ended(); }, source_));
            if (*got == 0) break;
            if (!heard_) heard_ = std::chrono::steady_clock::now();
            read += *got;
            parser_.take(std::span(chunk_).first(*got));
        }
        if (!best) return std::optional<Taken>();
        newest_ = best->header;
        Taken taken{static_cast<std::uint32_t>(newest_.number), at_ns};
        add_plane(taken.frame, PlaneRole::depth, {best->depth(), best->payload});
        if (shows_colour_)
            if (auto colour = fit_plane(PlaneRole::colour, {best->colour(), best->payload, 8}, scene_, name_))
                add_plane(taken.frame, PlaneRole::colour, std::move(*colour));
        return std::optional(std::move(taken));
    }

    void wait() override {
        auto sources = std::visit([](auto& source) { return source->waits(); }, source_);
        (void)::poll(sources.data(), sources.size(), static_cast<int>(stop_look.count()));
    }

    std::optional<Error> nothing_came(Moment since) const override {
        const auto longest = heard_ ? choice_.patience : choice_.first_patience;
        if (std::chrono::steady_clock::now() <= std::max(since, heard_.value_or(since)) + longest)
            return std::nullopt;
        return input_error(name_ + (heard_ ? ": sent no whole frameset in " : ": sent nothing in ") +
                           std::to_string(longest.count()) + " ms" +
                           (damaged_ > 0 ? ", but damaged ones" : ""));
    }

    const FramesetChoice choice_;
    LiveBytes source_;
    FramesetParser parser_;
    JitterBuffer clock_{0, longest_way_ns};
    std::vector<std::uint8_t> chunk_ = std::vector<std::uint8_t>(std::size_t{1} << 18U);
    std::optional<Moment> heard_;  // when the first byte came
    FramesetHeader newest_;        // of the frameset that was taken last
    bool shows_colour_ = false;
};

}  // namespace

Result<void> check_address(const std::string& address) {
    TRY(read_address(address));
    return {};
}

PlaneView Frameset::colour() const {
    if (!header.has_colour()) return {};
    return packed_plane(payload->data() + header.depth_bytes(), header.colour_width, header.colour_height, 1,
                        3);
}

void FramesetParser::take(std::span<const std::uint8_t> bytes) {
    if (begin_ > 0 && begin_ >= bytes_.size() / 2) {
        bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin_));
        begin_ = 0;
    }
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    credit_ = std::min(credit_ + checks_per_byte * bytes.size(), most_credit);
}

/// Skips bytes up to the next header. False: more bytes are needed.
bool FramesetParser::find_header() {
    while (true) {
        const auto left = rest();
        const void* const found =
            left.empty() ? nullptr : ::memmem(left.data(), left.size(), magic.data(), magic.size());
        if (found == nullptr) {
            // They may begin a magic number that goes on in the next bytes.
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
        return input_error("sent " + std::to_string(most_strays >> 20U) +
                           " MiB without a whole frameset (docs/streaming.md describes one)");
    return std::optional<Frameset>();
}

Result<std::unique_ptr<ClipReader>> open_frameset_camera(
    const FramesetChoice& choice, const SourceDescription& known,
    const std::optional<std::filesystem::path>& scene_file) {
    return opened_as<ClipReader>(std::make_unique<FramesetCamera>(choice), known, scene_file);
}

}  // namespace touchable
