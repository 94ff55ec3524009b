#include "engine/stream/http_source.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <utility>
#include <vector>

namespace touchable {
namespace {

/// One for all who read the file: of its parts the one that was read last.
class HttpFile {
public:
    HttpFile(StreamUrl url, const StreamPatience& patience, std::uint64_t size,
             std::shared_ptr<StreamWait> wait, std::shared_ptr<StreamBytes> connection)
        : url_(std::move(url)),
          patience_(patience),
          size_(size),
          wait_(std::move(wait)),
          connection_(std::move(connection)) {}

    /// As GivenFile::Reading.
    std::ptrdiff_t read(std::uint64_t at, char* to, std::size_t count, bool may_wait) {
        std::unique_lock held(mutex_, std::defer_lock);
        if (may_wait)
            held.lock();
        else if (!held.try_lock())
            return -EAGAIN;
        if (at >= size_) return 0;
        if (at < at_ || at - at_ >= part_.size()) {
            if (const int failure = failure_; failure != 0) return -failure;
            if (!may_wait) return -EAGAIN;
            if (const int failure = fetch(at); failure != 0) return -failure;
        }
        const auto from = static_cast<std::size_t>(at - at_);
        const std::size_t some = std::min(count, part_.size() - from);
        std::memcpy(to, part_.data() + from, some);
        return static_cast<std::ptrdiff_t>(some);
    }

    std::optional<Error> end_opening() {
        is_opening_ = false;
        switch (failure_) {
            case 0:
                return std::nullopt;
            case ETIMEDOUT:
                return input_error("comes too slowly: its clip was not open within " +
                                   std::to_string(patience_.opening.count() / 1000) +
                                   " s; save it first, and open it here");
            default:
                return input_error("cannot be read: the connection was lost, and another gave no more of it");
        }
    }

private:
    /// 0, or an errno.
    int fetch(std::uint64_t at) {
        constexpr std::uint64_t part_bytes = std::uint64_t{1} << 20;
        part_.resize(static_cast<std::size_t>(std::min(part_bytes, size_ - at)));
        at_ = at;
        if (!is_opening_) wait_->together_at_most(patience_.frameset);
        for (int go = 0; go < 2; ++go) {
            if (!connection_) connect();
            wait_->at_most(patience_.frameset);
            if (connection_ && connection_->read_at(at, part_.data(), part_.size())) return 0;
            connection_.reset();
            if (wait_->is_over()) break;
        }
        part_.clear();
        if (wait_->is_interrupted()) return EIO;
        failure_ = wait_->is_too_long() ? ETIMEDOUT : EIO;
        return failure_;
    }

    /// To a file that is as long as it was.
    void connect() {
        auto made = StreamBytes::connect(url_, wait_, patience_);
        if (made && (*made)->file_size() == size_) connection_ = std::move(*made);
    }

    const StreamUrl url_;
    const StreamPatience patience_;
    const std::uint64_t size_;
    const std::shared_ptr<StreamWait> wait_;
    std::atomic<bool> is_opening_{true};
    std::atomic<int> failure_{0};  // the errno for which nothing more is read
    std::mutex mutex_;
    std::shared_ptr<StreamBytes> connection_;  // guarded by it, as is what follows
    std::uint64_t at_ = 0;
    std::vector<std::uint8_t> part_;
};

}  // namespace

Result<HttpSource> open_http(const StreamUrl& url, const StreamPatience& patience) {
    const auto wait = std::make_shared<StreamWait>();
    wait->together_at_most(patience.opening);
    auto connection = StreamBytes::connect(url, wait, patience);
    if (!connection) return error_at(url.name(), connection.error());
    const auto size = (*connection)->file_size();
    if (!size) return HttpSource{.stream = std::move(*connection)};
    const auto file = std::make_shared<HttpFile>(url, patience, *size, wait, std::move(*connection));
    const GivenFile given([file](std::uint64_t at, char* to, std::size_t count,
                                 bool may_wait) { return file->read(at, to, count, may_wait); },
                          *size);
    return HttpSource{.file = SourceFile(std::filesystem::path(url.name()), given),
                      .end_opening = [file] { return file->end_opening(); }};
}

}  // namespace touchable
