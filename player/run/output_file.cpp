#include "player/run/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace touchable {
namespace {

constexpr std::size_t written_at_once = 1 << 16;

}  // namespace

OutputFile::OutputFile(std::string what, const std::filesystem::path& file, Existing existing, Pace pace)
    : what_(std::move(what)), pace_(pace) {
    if (is_standard_output(file)) {
        standard_.emplace(pace);
        return;
    }
    file_.emplace(file, existing);
    if (file_->check().ok()) out_ = open(file_->path().c_str(), O_RDWR | O_CLOEXEC);
}

OutputFile::~OutputFile() {
    if (out_ >= 0) close(out_);
}

Result<std::unique_ptr<OutputFile>> OutputFile::create(std::string what, const std::filesystem::path& file,
                                                       Existing existing, Pace pace) {
    std::unique_ptr<OutputFile> out(new OutputFile(std::move(what), file, existing, pace));
    if (out->standard_) return out;
    const int why = errno;
    if (auto usable = out->file_->check(); !usable.ok())
        return input_error(out->what_ + ' ' + usable.error().message);
    if (out->out_ < 0) return out->failed(why);
    return out;
}

Result<void> OutputFile::write(std::string_view piece) {
    if (fault_) return *fault_;
    if (standard_) {
        auto written = standard_->write(piece);
        if (!written.ok() && written.error().kind != ErrorKind::interrupted)
            written = input_error(name() + ": " + written.error().message);
        if (!written.ok()) fault_ = written.error();
        return written;
    }
    waiting_ += piece;
    ends_.push_back(waiting_.size());
    return waiting_.size() < written_at_once ? Result<void>() : flush();
}

/// 0, or errno: then the file ends behind its last whole piece.
int OutputFile::write_out() {
    std::size_t done = 0;
    int why = 0;
    while (done < waiting_.size() && why == 0) {
        const ssize_t count =
            pwrite(out_, waiting_.data() + done, waiting_.size() - done, static_cast<off_t>(size_ + done));
        if (count > 0) done += static_cast<std::size_t>(count);
        if (count == 0) why = ENOSPC;
        if (count < 0 && errno != EINTR) why = errno;
    }
    const auto whole = std::upper_bound(ends_.begin(), ends_.end(), done);
    pieces_ += static_cast<std::size_t>(whole - ends_.begin());
    if (whole != ends_.begin()) size_ += *(whole - 1);
    waiting_.clear();
    ends_.clear();
    if (why != 0 && ftruncate(out_, static_cast<off_t>(size_)) != 0) size_ = pieces_ = 0;
    return why;
}

Result<void> OutputFile::flush() {
    if (!fault_)
        if (const int why = write_out()) fault_ = failed(why);
    return fault_ ? Result<void>(*fault_) : Result<void>();
}

Result<void> OutputFile::write_over(std::uint64_t at, std::string_view bytes) {
    const ssize_t count = pwrite(out_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (count == static_cast<ssize_t>(bytes.size())) return {};
    return failed(count < 0 ? errno : ENOSPC);
}

std::string OutputFile::read(std::uint64_t at, std::size_t size) const {
    std::string bytes(size, '\0');
    for (std::size_t done = 0; done < size;) {
        const ssize_t count = pread(out_, bytes.data() + done, size - done, static_cast<off_t>(at + done));
        if (count == 0 || (count < 0 && errno != EINTR)) return {};
        if (count > 0) done += static_cast<std::size_t>(count);
    }
    return bytes;
}

Result<void> OutputFile::go_on_from(std::uint64_t size) {
    if (ftruncate(out_, static_cast<off_t>(size)) != 0) return failed(errno);
    size_ = size;
    fault_.reset();
    return {};
}

Result<void> OutputFile::keep() {
    close(std::exchange(out_, -1));
    return file_->commit();
}

Result<void> OutputFile::finish() {
    if (standard_) {
        if (fault_) return *fault_;
        auto done = standard_->finish();
        if (!done.ok() && done.error().kind == ErrorKind::input)
            return input_error(name() + ": " + done.error().message);
        return done;
    }
    const auto whole = flush();
    if (whole.ok()) return keep();
    if (pace_ == Pace::own || pieces_ < 2) return whole;
    if (auto kept = keep(); !kept.ok()) return kept;
    return input_error(whole.error().message + "; it is kept up to there");
}

std::string OutputFile::name() const {
    return what_ + ' ' + (file_ ? file_->target().string() : "-");
}

Error OutputFile::failed(int why) const {
    return input_error(name() + ": cannot be written: " + std::generic_category().message(why));
}

Result<void> all_ok(const std::vector<Result<void>>& finished) {
    std::optional<Error> fault;
    for (const Result<void>& done : finished) {
        if (done.ok()) continue;
        if (fault)
            fault->message += "; " + done.error().message;
        else
            fault = done.error();
    }
    return fault ? Result<void>(*fault) : Result<void>();
}

}  // namespace touchable
