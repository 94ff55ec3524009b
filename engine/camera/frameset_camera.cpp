// Programs that send framesets: the bytes of a command or a connection, the framesets found in them, and
// these as a clip.
#include "engine/camera/frameset_camera.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <netinet/in.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <bit>
#include <cerrno>
#include <csignal>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/camera/camera_reader.hpp"
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

/// Of a lens that can have made the picture. False for what is no number, too.
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

constexpr std::chrono::milliseconds step(10);

/// Bytes of a program that come when they come: its standard output, or a connection. What it began it ends
/// with itself.
class LiveBytes {
public:
    virtual ~LiveBytes() = default;
    /// What is there, up to the size of `into`, at once: its length; 0: nothing is there yet; nothing at all:
    /// it has ended.
    virtual std::optional<std::size_t> read(std::span<std::uint8_t> into) = 0;
    /// What poll waits for: of them a descriptor of -1 does not count.
    virtual std::array<pollfd, 2> waits() const = 0;
    /// Once it has ended: how, such as "ended with status 1". Waits for that for a fifth of a second at most.
    virtual std::string how_it_ended() = 0;
};

class Descriptor {
public:
    explicit Descriptor(int of = -1) : of_(of) {}
    ~Descriptor() { reset(); }
    Descriptor(Descriptor&& other) noexcept : of_(std::exchange(other.of_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(of_, other.of_);
        return *this;
    }
    int get() const { return of_; }
    void reset() {
        if (of_ >= 0) ::close(of_);
        of_ = -1;
    }

private:
    int of_;
};

std::string failure_text(int failure) {
    return std::generic_category().message(failure);
}

bool is_for_later(int failure) {
    return failure == EAGAIN || failure == EWOULDBLOCK || failure == EINTR;
}

struct Pipe {
    Descriptor out, in;  ///< to be read without waiting; to be written
};
Result<Pipe> make_pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        return Error{ErrorKind::internal, "no pipe can be made: " + failure_text(errno)};
    Pipe made{Descriptor(ends[0]), Descriptor(ends[1])};
    ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    return made;
}

class Command final : public LiveBytes {
public:
    Command(::pid_t process, Descriptor output, Descriptor errors)
        : process_(process), output_(std::move(output)), errors_(std::move(errors)) {}
    ~Command() override;
    std::optional<std::size_t> read(std::span<std::uint8_t> into) override;
    std::array<pollfd, 2> waits() const override {
        return {pollfd{output_.get(), POLLIN, 0}, {errors_.get(), POLLIN, 0}};
    }
    std::string how_it_ended() override;

private:
    void hear_errors();
    std::string last_words() const;
    bool has_ended(siginfo_t& how) const;

    const ::pid_t process_;  // and its group, which is there until it is waited for
    Descriptor output_, errors_;
    std::string errors_said_;  // the last of it
};

std::optional<std::size_t> Command::read(std::span<std::uint8_t> into) {
    hear_errors();
    if (output_.get() < 0) return std::nullopt;
    const auto got = ::read(output_.get(), into.data(), into.size());
    if (got > 0) return static_cast<std::size_t>(got);
    if (got < 0 && is_for_later(errno)) return std::size_t{0};
    output_.reset();
    return std::nullopt;
}

void Command::hear_errors() {
    constexpr std::size_t most_kept = 2000;
    constexpr int most_at_once = 16;
    for (int k = 0; k < most_at_once && errors_.get() >= 0; ++k) {
        std::array<char, 4096> words;
        const auto got = ::read(errors_.get(), words.data(), words.size());
        if (got < 0 && is_for_later(errno)) return;
        if (got <= 0) return errors_.reset();
        errors_said_.append(words.data(), static_cast<std::size_t>(got));
        if (errors_said_.size() > most_kept) errors_said_.erase(0, errors_said_.size() - most_kept);
    }
}

std::string Command::last_words() const {
    constexpr std::size_t longest = 200;
    const std::size_t end = errors_said_.find_last_not_of(" \t\r\n");
    if (end == std::string::npos) return "";
    const std::size_t before = errors_said_.find_last_of("\r\n", end);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    return ": " + printable(errors_said_.substr(begin, end + 1 - begin), longest);
}

bool Command::has_ended(siginfo_t& how) const {
    how = {};
    return ::waitid(P_PID, static_cast<::id_t>(process_), &how, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           how.si_pid == process_;
}

std::string Command::how_it_ended() {
    constexpr int most_looks = 20;
    siginfo_t how;
    bool ended = has_ended(how);
    for (int looks = 0; !ended && looks < most_looks; ++looks) {
        std::this_thread::sleep_for(step);
        ended = has_ended(how);
    }
    hear_errors();
    if (!ended) return "closed its standard output" + last_words();
    if (how.si_code != CLD_EXITED) return "ended by signal " + std::to_string(how.si_status) + last_words();
    if (how.si_status == 0) return "ended";
    return "ended with status " + std::to_string(how.si_status) + last_words();
}

/// While the first process is not waited for, no other group has its number.
Command::~Command() {
    ::kill(-process_, SIGTERM);
    siginfo_t how;
    // A process of the group that still writes holds the output open.
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    while (!(has_ended(how) && output_.get() < 0) && std::chrono::steady_clock::now() < until) {
        std::array<std::uint8_t, 65536> unread;
        if (read(unread).value_or(0) == 0) std::this_thread::sleep_for(step);
    }
    ::kill(-process_, SIGKILL);
    constexpr int most_steps = 200;
    for (int k = 0; k < most_steps && ::waitpid(process_, nullptr, WNOHANG) == 0; ++k)
        std::this_thread::sleep_for(step);
}

class Connection final : public LiveBytes {
public:
    explicit Connection(Descriptor socket) : socket_(std::move(socket)) {}
    std::optional<std::size_t> read(std::span<std::uint8_t> into) override {
        const auto got = ::recv(socket_.get(), into.data(), into.size(), MSG_DONTWAIT);
        if (got > 0) return static_cast<std::size_t>(got);
        if (got < 0 && is_for_later(errno)) return std::size_t{0};
        if (got < 0) failure_ = errno;
        return std::nullopt;
    }
    std::array<pollfd, 2> waits() const override {
        return {pollfd{socket_.get(), POLLIN, 0}, {-1, POLLIN, 0}};
    }
    std::string how_it_ended() override {
        return failure_ == 0 ? "closed the connection" : "was lost (" + failure_text(failure_) + ")";
    }

private:
    Descriptor socket_;
    int failure_ = 0;
};

struct Address {
    ::sockaddr_storage bytes = {};
    ::socklen_t length = 0;
};
Result<Address> read_address(const std::string& words) {
    const Error wrong =
        usage_error("tcp://" + printable(words) +
                    ": right would be an address in numbers or localhost, and a port, such as "
                    "tcp://192.168.0.5:7000 or tcp://[::1]:7000");
    const std::size_t colon = words.rfind(':');
    if (colon == std::string::npos || colon + 1 == words.size()) return wrong;
    std::string host = words.substr(0, colon);
    const std::string port = words.substr(colon + 1);
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
    if (host == "localhost") host = "127.0.0.1";
    if (host.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos ||
        std::stoi(port) < 1 || std::stoi(port) > 65535)
        return wrong;
    Address address;
    const auto port_there = htons(static_cast<std::uint16_t>(std::stoi(port)));
    if (::sockaddr_in four = {}; ::inet_pton(AF_INET, host.c_str(), &four.sin_addr) == 1) {
        four.sin_family = AF_INET;
        four.sin_port = port_there;
        std::memcpy(&address.bytes, &four, address.length = sizeof four);
        return address;
    }
    ::sockaddr_in6 six = {};
    if (::inet_pton(AF_INET6, host.c_str(), &six.sin6_addr) != 1) return wrong;
    six.sin6_family = AF_INET6;
    six.sin6_port = port_there;
    std::memcpy(&address.bytes, &six, address.length = sizeof six);
    return address;
}

/// 0, or why there is no connection.
Result<int> wait_for_connection(int socket) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    const bool is_there = work_until(until, [&] { return wait_unless_stopped(socket, POLLOUT); });
    if (!is_there && stop_requested()) return interrupted_error();
    if (!is_there) return ETIMEDOUT;
    int failure = 0;
    ::socklen_t length = sizeof failure;
    return ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &failure, &length) == 0 ? failure : errno;
}

/// The standard output of a command that /bin/sh runs, in a process group of its own, without standard input.
/// The last line that it says on standard error is kept for how it ended. With this object the whole group is
/// asked to end (SIGTERM), and after 2 s made to (SIGKILL).
Result<std::unique_ptr<LiveBytes>> start_command(const std::string& command) {
    TRY_ASSIGN(auto output, make_pipe());
    TRY_ASSIGN(auto errors, make_pipe());
    constexpr int roomy = 1 << 20;
    (void)::fcntl(output.in.get(), F_SETPIPE_SZ, roomy);  // otherwise what it is
    ::posix_spawn_file_actions_t files;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&files, output.in.get(), STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, errors.in.get(), STDERR_FILENO);
    ::posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    ::posix_spawnattr_t attributes;
    ::posix_spawnattr_init(&attributes);
    sigset_t none, all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    ::posix_spawnattr_setflags(&attributes,
                               POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    std::string shell = "sh", option = "-c", words = command;
    char* const arguments[] = {shell.data(), option.data(), words.data(), nullptr};
    ::pid_t process = -1;
    const int failure = ::posix_spawn(&process, "/bin/sh", &files, &attributes, arguments, ::environ);
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
    if (failure != 0)
        return input_error("pipe:" + printable(command) + ": cannot be started: " + failure_text(failure));
    return std::unique_ptr<LiveBytes>(
        std::make_unique<Command>(process, std::move(output.out), std::move(errors.out)));
}

/// It is there within 5 s, or an error says why not; or earlier, of kind interrupted, where the program is
/// asked to stop.
Result<std::unique_ptr<LiveBytes>> connect_to(const std::string& address) {
    TRY_ASSIGN(const auto read, read_address(address));
    Descriptor socket(::socket(read.bytes.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto no_connection = [&](int failure) {
        return input_error("tcp://" + address + ": no connection: " + failure_text(failure) +
                           "; does the sender listen there?");
    };
    if (socket.get() < 0) return no_connection(errno);
    const auto* const to = reinterpret_cast<const ::sockaddr*>(&read.bytes);
    if (::connect(socket.get(), to, read.length) != 0 && errno != EINPROGRESS) return no_connection(errno);
    TRY_ASSIGN(const auto failure, wait_for_connection(socket.get()));
    if (failure != 0) return no_connection(failure);
    return std::unique_ptr<LiveBytes>(std::make_unique<Connection>(std::move(socket)));
}

class FramesetCamera final : public CameraReader {
public:
    explicit FramesetCamera(const FramesetChoice& choice)
        : CameraReader(printable(choice.name())), choice_(choice), name_(printable(choice.name())) {}
    Result<void> open(const SourceDescription& known, const std::optional<std::filesystem::path>& scene_file);

    Result<std::optional<RawFrame>> next() override;
    void leave_out_colour() override { shows_colour_ = false; }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override;
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
    std::unique_ptr<LiveBytes> source_;
    FramesetParser parser_;
    SenderClock clock_;
    std::vector<std::uint8_t> chunk_ = std::vector<std::uint8_t>(std::size_t{1} << 18U);
    bool has_said_anything_ = false, shows_colour_ = true;
    std::atomic<std::int64_t> damaged_{0}, repeated_{0};
};

/// What is there; nothing where no whole one is. An error once no more will come: what happened.
Result<std::optional<TakenFrameset>> FramesetCamera::take(Which which) {
    constexpr std::size_t most_at_once = std::size_t{16} << 20U;  // then it may have been interrupted
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
    take_meaning(std::move(meaning), rate_of(taken));
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
    TRY_ASSIGN(source_,
               choice_.command.empty() ? connect_to(choice_.address) : start_command(choice_.command));
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

Result<void> check_address(const std::string& address) {
    const auto read = read_address(address);
    return read ? Result<void>() : read.error();
}

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

std::int64_t SenderClock::taken_at(std::int64_t sent_ns, std::int64_t arrived_ns) {
    constexpr std::int64_t longest_way = 100'000'000, slower = 1000;  // a thousandth
    constexpr std::int64_t most_known = std::int64_t{1} << 62U;
    if (sent_ns <= 0 || sent_ns >= most_known) {
        last_.reset();
        return arrived_ns;
    }
    const std::int64_t apart_ns = arrived_ns - sent_ns;
    const bool goes_on = last_ && sent_ns > last_->sent_ns;
    if (goes_on) apart_ns_ = std::min(apart_ns_ + (arrived_ns - last_->arrived_ns) / slower, apart_ns);
    if (!goes_on || apart_ns - apart_ns_ > longest_way) apart_ns_ = apart_ns;
    last_ = Moment{sent_ns, arrived_ns};
    return sent_ns + apart_ns_;
}

Result<std::unique_ptr<ClipReader>> open_frameset_camera(
    const FramesetChoice& choice, const std::optional<SourceDescription>& known,
    const std::optional<std::filesystem::path>& scene_file) {
    auto camera = std::make_unique<FramesetCamera>(choice);
    TRY(camera->open(known.value_or(SourceDescription()), scene_file));
    return std::unique_ptr<ClipReader>(std::move(camera));
}

}  // namespace touchable
