// SPDX-License-Identifier: Apache-2.0
#include "engine/stream/listeners.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>

#include "engine/base/words.hpp"

namespace touchable {
namespace {

struct HttpStatus {
    int number;
    std::string_view reason, words;
};
constexpr HttpStatus http_statuses[] = {
    {200, "OK", ""},
    {206, "Partial Content", ""},
    {304, "Not Modified", ""},
    {404, "Not Found", "there is nothing of this name\n"},
    {405, "Method Not Allowed", "the stream is only read: GET or HEAD\n"},
    {416, "Range Not Satisfiable", ""},
    {503, "Service Unavailable", "as many listen as there is room for; try again later\n"},
    {400, "Bad Request", "this is no request of HTTP/1.0 or HTTP/1.1\n"},
};

/// 400 for a status that is not in the table.
const HttpStatus& http_status(int status) {
    const HttpStatus* const known = std::ranges::find(http_statuses, status, &HttpStatus::number);
    return known != std::end(http_statuses) ? *known : std::end(http_statuses)[-1];
}

/// The first lines of an answer, after which the connection is closed.
std::string begin_of_answer(int status) {
    return "HTTP/1.1 " + std::to_string(status) + " " + std::string(http_status(status).reason) +
           "\r\nConnection: close\r\n";
}

/// The kinds of files that a page has, by the ends of their names.
constexpr struct {
    std::string_view ending, type;
} page_files[] = {{".html", "text/html; charset=utf-8"}, {".js", "text/javascript; charset=utf-8"},
                  {".css", "text/css; charset=utf-8"},   {".json", "application/json"},
                  {".wasm", "application/wasm"},         {".bin", "application/octet-stream"}};

/// A page's scripts, and what they request, come from this server alone.
constexpr std::string_view page_policy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src 'self' blob: data:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'";

/// Bytes of a file.
struct BytePart {
    std::uint64_t at = 0, end = 0;
};

/// The part that the field Range names: bytes=A-B, bytes=A- or bytes=-COUNT; it is empty if it begins behind
/// the file's end. Nothing: another form, such as several parts, which is answered with the whole file.
std::optional<BytePart> part_in_range(std::string_view range, std::uint64_t size) {
    if (cut_part(range, '=') != "bytes" || range.find('-') == std::string_view::npos) return std::nullopt;
    const std::string_view first = cut_part(range, '-');
    const auto at = parsed_as<std::uint64_t>(first), last = parsed_as<std::uint64_t>(range);
    if (at ? !last && !range.empty() : !first.empty() || !last) return std::nullopt;
    if (!at) return BytePart{size - std::min(size, *last), size};
    if (last && *last < *at) return std::nullopt;
    return BytePart{std::min(*at, size), last && *last < size ? *last + 1 : size};
}

}  // namespace

// --- Requests over HTTP

void HttpRequest::take(std::string_view bytes) {
    if (status_ != 0) return;
    const std::size_t before = head_.size();
    head_.append(bytes.substr(0, most_bytes + 1 - before));
    // A line may end without its CR (RFC 9112, 2.2).
    const std::size_t from = before < 3 ? 0 : before - 3;
    const std::size_t end = std::min(head_.find("\r\n\r\n", from), head_.find("\n\n", from));
    if (end != std::string::npos && end < most_bytes) {
        head_.resize(end);
        status_ = judged(head_);
    } else if (head_.size() > most_bytes) {
        status_ = 400;
    }
}

int HttpRequest::judged(std::string_view head) {
    std::string_view line = head.substr(0, std::min(head.find_first_of("\r\n"), head.size()));
    const std::string_view method = cut_part(line, ' '), target = cut_part(line, ' '),
                           version = cut_part(line, ' ');
    if (!line.empty() || !target.starts_with('/') || (version != "HTTP/1.0" && version != "HTTP/1.1"))
        return 400;
    is_head_ = method == "HEAD";
    if (method != "GET" && !is_head_) return 405;
    target_ = target.substr(0, target.find('?'));
    return target_ == path_ ? 200 : 404;
}

std::string_view HttpRequest::field(std::string_view name) const {
    for (std::string_view rest = head_; !rest.empty();) {
        std::string_view line = cut_line(rest);
        if (small_letters(std::string(cut_part(line, ':'))) == name) return trimmed(line);
    }
    return {};
}

std::string http_answer(int status, std::string_view type) {
    const std::string_view words = http_status(status).words;
    std::string head = begin_of_answer(status) + "Cache-Control: no-store\r\n";
    if (status == 200)
        return head.append("Content-Type: ").append(type).append("\r\nAccept-Ranges: none\r\n\r\n");
    if (status == 405) head += "Allow: GET, HEAD\r\n";
    return head.append("Content-Type: text/plain; charset=utf-8\r\nContent-Length: ")
        .append(std::to_string(words.size()))
        .append("\r\n\r\n")
        .append(words);
}

ServedFile served_file(const HttpRequest& request, std::span<const std::filesystem::path> folders) {
    const std::string name(request.target() == "/" ? "index.html" : request.target().substr(1));
    const auto* const kind =
        std::ranges::find_if(page_files, [&](const auto& each) { return name.ends_with(each.ending); });
    const bool leads_elsewhere = name.find_first_of(std::string_view("/\0", 2)) != std::string::npos;
    if (kind == std::end(page_files) || leads_elsewhere) return {http_answer(404)};
    ServedFile answer;
    struct stat found {};
    for (const auto& folder : folders) {
        answer.file = Descriptor(::open((folder / name).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
        if (::fstat(answer.file.get(), &found) == 0 && S_ISREG(found.st_mode)) break;
        answer.file.reset();
    }
    if (answer.file.get() < 0) return {http_answer(404)};
    const auto size = static_cast<std::uint64_t>(found.st_size);
    const std::string tag = '"' + std::to_string(size) + '-' + std::to_string(found.st_mtim.tv_sec) + '.' +
                            std::to_string(found.st_mtim.tv_nsec) + '"';
    // A part of the file as it was before is of no use: with If-Range it is sent whole.
    const std::string_view if_range = request.field("if-range");
    const auto part =
        if_range.empty() || if_range == tag ? part_in_range(request.field("range"), size) : std::nullopt;
    const auto [at, end] = part.value_or(BytePart{0, size});
    const bool is_known = request.field("if-none-match") == tag;
    const int status = is_known ? 304 : !part ? 200 : at < end ? 206 : 416;
    answer.head = begin_of_answer(status) + "Cache-Control: no-cache\r\nETag: " + tag +
                  "\r\nAccept-Ranges: bytes\r\nX-Content-Type-Options: nosniff\r\nContent-Security-Policy: ";
    answer.head.append(page_policy).append("\r\nContent-Type: ").append(kind->type);
    if (status == 206 || status == 416)
        answer.head += "\r\nContent-Range: bytes " +
                       (status == 416 ? "*" : std::to_string(at) + '-' + std::to_string(end - 1)) + '/' +
                       std::to_string(size);
    answer.head += "\r\nContent-Length: " + std::to_string(end - at) + "\r\n\r\n";
    answer.at = at;
    answer.end = is_known || request.is_head() ? at : end;
    return answer;
}

// --- Links

bool NarrowLink::is_behind(std::int64_t now_ns, bool is_tried) {
    if (!behind_since_ns_) behind_since_ns_ = now_ns;
    if (!first_behind_ns_) first_behind_ns_ = now_ns;
    // A listener that joins begins with a key of up to half a second ago.
    if (is_tried || now_ns - *first_behind_ns_ < joins_within_ns) return false;
    if (now_ns - *behind_since_ns_ < colour_goes_after_ns) return false;
    if (has_colour_) {
        const bool was_in_vain = colour_back_ns_ && now_ns - *colour_back_ns_ < longest_trial_ns;
        trial_ns_ = was_in_vain ? std::min(2 * trial_ns_, longest_trial_ns) : shortest_trial_ns;
    }
    next_trial_ns_ = now_ns + trial_ns_;
    return std::exchange(has_colour_, false);
}

void LinkRate::look(const Look& look) {
    if (!first_in_slice_) first_in_slice_ = look;
    if (look.rtt_ns > 0) {
        shortest_ns_ = shortest_ns_ > 0 ? std::min(shortest_ns_, look.rtt_ns) : look.rtt_ns;
        slice_.rtt_ns = std::min(slice_.rtt_ns, look.rtt_ns);
    }
    slice_.is_full = slice_.is_full || look.is_full;
    const std::int64_t passed_ns = look.now_ns - first_in_slice_->now_ns;
    if (passed_ns < slice_ns) return;
    const auto more = [](std::int64_t now, std::int64_t then) {
        return std::max<std::int64_t>(now - then, 0);
    };
    constexpr double ns_per_second = 1e9;
    slice_.rate = static_cast<double>(more(look.arrived_bytes, first_in_slice_->arrived_bytes)) *
                  ns_per_second / static_cast<double>(passed_ns);
    slice_.datagrams = more(look.datagrams, first_in_slice_->datagrams);
    slice_.lost = more(look.lost, first_in_slice_->lost);
    slices_[slice_count_++ % recent] = std::exchange(slice_, Slice{});
    first_in_slice_ = look;
    grow();
    forget_shortest();
}

std::int64_t LinkRate::bytes_per_second() const {
    double most = 0;
    for (const std::size_t before : {std::size_t{0}, recent / 2}) {
        const std::size_t there = slice_count_ - std::min(slice_count_, before);
        const std::size_t slices = std::min(there, recent / 2);
        double sum = 0;
        for (std::size_t k = 0; k < slices; ++k) sum += slices_[(there - 1 - k) % recent].rate;
        if (slices > 0) most = std::max(most, sum / static_cast<double>(slices));
    }
    return static_cast<std::int64_t>(most);
}

std::int64_t LinkRate::window_bytes() const {
    constexpr std::size_t first_slices = 4;
    // Acknowledgements are sent every 10 ms and read every 5; a thread may have to wait for a core. With a
    // long round trip the rate has to be able to grow by a quarter.
    constexpr double least_slack_ns = 80e6, ns_per_second = 1e9;
    const auto way_ns = static_cast<double>(shortest_ns_);
    const double slack_ns = std::max(least_slack_ns, way_ns / 4);
    std::int64_t datagrams = 0, lost = 0;
    for (const Slice& slice : slices_) {
        datagrams += slice.datagrams;
        lost += slice.lost;
    }
    // Acknowledgements stop at a lost datagram until it was requested and sent again. Of the hundreds of
    // datagrams under way, some are lost once more when they are resent.
    constexpr int loses_from = 200;  // one datagram in this many
    const double ways = lost * loses_from > datagrams ? 6 : 1;
    const double seconds = ((ways + (is_growing_ ? 1 : 0)) * way_ns + slack_ns) / ns_per_second;
    const double bytes = static_cast<double>(bytes_per_second()) * seconds;
    constexpr double most_bytes = 64 << 20;
    return std::max(
        slice_count_ < first_slices || shortest_ns_ == 0 ? first_window_bytes : least_window_bytes,
        static_cast<std::int64_t>(std::min(bytes, most_bytes)));
}

void LinkRate::grow() {
    if (!is_growing_ || shortest_ns_ == 0) return;
    constexpr double grows_by = 1.25;
    constexpr std::int64_t queue_ns = 100'000'000, least_in_vain_ns = 1'000'000'000, ways_in_vain = 3,
                           fits_for_ns = 4'000'000'000;
    const Slice& newest = slices_[(slice_count_ - 1) % recent];
    const auto rate = static_cast<double>(bytes_per_second());
    if (rate > grows_by * fastest_) {
        fastest_ = rate;
        in_vain_ns_ = 0;
    } else if (newest.is_full) {
        in_vain_ns_ += slice_ns;
    }
    fits_ns_ = newest.is_full ? 0 : fits_ns_ + slice_ns;
    const bool has_queue = newest.rtt_ns < std::numeric_limits<std::int64_t>::max() &&
                           newest.rtt_ns > 2 * shortest_ns_ + queue_ns;
    is_growing_ = !has_queue && fits_ns_ < fits_for_ns &&
                  in_vain_ns_ < std::max(least_in_vain_ns, ways_in_vain * shortest_ns_);
}

/// Measures the round trip anew while none of our data queues before the link. While the window is full some
/// does, and to trust that time would widen the window again and again.
void LinkRate::forget_shortest() {
    if (slice_count_ < recent) return;
    std::int64_t shortest_ns = std::numeric_limits<std::int64_t>::max();
    for (const Slice& slice : slices_) {
        if (slice.is_full) return;
        shortest_ns = std::min(shortest_ns, slice.rtt_ns);
    }
    if (shortest_ns < std::numeric_limits<std::int64_t>::max()) shortest_ns_ = shortest_ns;
}

}  // namespace touchable
