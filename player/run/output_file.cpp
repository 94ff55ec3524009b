// SPDX-License-Identifier: Apache-2.0
#include "player/run/run_files.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <system_error>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/run/terminal.hpp"

namespace touchable {
namespace {

/// A row's fields, separated by commas.
class CsvRow {
public:
    explicit CsvRow(std::string& text) : text_(text) {}
    CsvRow& operator<<(double value) { return add(value, std::chars_format::general, 17); }
    CsvRow& operator<<(std::int64_t value) { return add(value); }
    CsvRow& operator<<(const glm::dvec3& v) { return *this << v.x << v.y << v.z; }
    /// An empty field, for a missing number.
    CsvRow& empty() {
        text_ += ',';
        return *this;
    }
    void end() { text_.back() = '\n'; }

private:
    CsvRow& add(auto number, auto... format) {
        std::array<char, 40> digits;
        char* const begin = digits.data();
        text_.append(begin, std::to_chars(begin, begin + digits.size(), number, format...).ptr);
        return empty();
    }
    std::string& text_;
};

class ForcesTable final : public TickTable {
public:
    explicit ForcesTable(std::unique_ptr<OutputFile> file) : TickTable(std::move(file)) {}

private:
    Result<void> write(const TouchTick& tick) override {
        rows_.clear();
        for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
            const Contact& contact = tick.contacts[k];
            CsvRow row(rows_);
            row << tick.tick << static_cast<double>(tick.time_ns) / 1e9 << static_cast<std::int64_t>(k)
                << contact.goal << contact.proxy << tick.sent(k) << std::int64_t{contact.touching}
                << contact.pixel_x << contact.pixel_y << contact.properties.stiffness
                << contact.properties.static_friction << contact.properties.dynamic_friction
                << tick.pair.prev.number << tick.pair.next.number << tick.blend
                << std::int64_t{tick.forces[k].reasons} << tick.metres_per_scene_unit
                << std::int64_t{contact.counts.capped} << tick.share(k) << std::int64_t{contact.hops}
                << contact.error_degrees << contact.error_newtons;
            row.end();
        }
        return file_->write(rows_);
    }

    std::string rows_;  // of one tick
};

class DeviceTable final : public TickTable {
public:
    DeviceTable(std::unique_ptr<OutputFile> file, DeviceTickLog& log)
        : TickTable(std::move(file)), log_(log) {}
    Result<void> finish() override {
        if (!is_faulty()) TRY(consume({}));
        if (!is_faulty() && log_.lost() > 0) return fell_behind_error(file_->name(), log_.lost());
        return file_->finish();
    }

private:
    /// Writes all ticks logged so far.
    Result<void> write(const TouchTick&) override {
        Result<void> written;
        const auto add = [this, &written](const DeviceTickLog::Tick& tick) {
            rows_.clear();
            for (std::size_t finger = 0; finger < tick.places.size(); ++finger) {
                CsvRow row(rows_);
                row << static_cast<double>(tick.tick) / 1000 << static_cast<std::int64_t>(finger);
                if (const glm::dvec3& place = tick.places[finger]; std::isfinite(place.x + place.y + place.z))
                    row << place;
                else
                    row.empty().empty().empty();
                row << std::int64_t{tick.buttons};
                if (std::isfinite(tick.age_s))
                    row << tick.age_s * 1000;
                else
                    row.empty();
                row << tick.newtons[finger] << std::int64_t{tick.exerts};
                row.end();
            }
            if (written) written = file_->write(rows_);
        };
        while (log_.pop(add)) {
        }
        return written;
    }

    DeviceTickLog& log_;
    std::string rows_;  // of one tick
};

constexpr std::size_t written_at_once = 1 << 16;

// Bytes that a ready pipe takes without blocking (PIPE_BUF).
constexpr std::size_t at_once = 4096;
// ms; interval at which a wait polls for a stop request.
constexpr int look_ms = 50;

}  // namespace

Result<void> StandardOutput::write(std::string_view piece) {
    if (gone_ || piece.empty()) return {};
    waiting_ += piece;
    all_ += piece.size();
    if (pace_ == Pace::own) return rest().size() < at_once ? Result<void>() : give_all();
    ends_.push_back(all_);
    while (!rest().empty()) {
        TRY_ASSIGN(const auto taken, give(0));
        if (taken == Taken::nothing_yet) break;
    }
    while (!ends_.empty() && ends_.front() <= written_) ends_.pop_front();
    return ends_.size() > most_waiting ? lagging() : Result<void>();
}

Error StandardOutput::lagging() {
    lags_ = true;
    return input_error("its disk or its reader was too slow for 1000 ticks a second: " +
                       std::to_string(ends_.size()) + " ticks are missing, so it is not complete");
}

/// Writes what fits at once if the reader accepts data within `patience_ms`.
Result<StandardOutput::Taken> StandardOutput::give(int patience_ms) {
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    if (poll(&output, 1, patience_ms) <= 0) return Taken::nothing_yet;
    const std::string_view bytes = rest().substr(0, at_once);
    const ssize_t count = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) return Taken::nothing_yet;
    if (count < 0 && errno != EPIPE)
        return input_error("standard output cannot be written: " + failure_words(errno));
    gone_ = count < 0;  // the reader has closed the pipe: no error
    const std::size_t given = gone_ ? rest().size() : static_cast<std::size_t>(count);
    given_ += given;
    written_ += given;
    if (given_ == waiting_.size() || given_ > 16 * at_once) {
        waiting_.erase(0, given_);
        given_ = 0;
    }
    return Taken::some;
}

Result<void> StandardOutput::give_all() {
    using Clock = std::chrono::steady_clock;
    // A live run that was interrupted still writes its remaining rows.
    const bool was_interrupted = pace_ == Pace::wall_clock && stop_requested();
    std::size_t taken_before = written_;
    Clock::time_point since = Clock::now();
    while (!rest().empty()) {
        TRY_ASSIGN(const auto taken, give(look_ms));
        const bool waits = pace_ == Pace::wall_clock || taken == Taken::nothing_yet;
        if (waits && !was_interrupted && stop_requested()) return interrupted_error();
        if (pace_ == Pace::own || rest().empty()) continue;
        if (written_ - taken_before >= least_taken) {
            taken_before = written_;
            since = Clock::now();
        }
        if (Clock::now() - since < patience_) continue;
        lags_ = true;
        return input_error("its reader takes too little, so it is not complete");
    }
    return {};
}

Result<void> StandardOutput::finish() {
    TRY(flush_standard_output());
    return give_all();
}

OutputFile::OutputFile(std::string what, const std::filesystem::path& file, Existing existing, Pace pace)
    : what_(std::move(what)), pace_(pace) {
    if (is_standard_output(file)) {
        standard_.emplace(pace);
        return;
    }
    file_.emplace(file, existing);
    if (file_->check()) out_ = open(file_->path().c_str(), O_RDWR | O_CLOEXEC);
}

OutputFile::~OutputFile() {
    if (out_ >= 0) close(out_);
}

Result<std::unique_ptr<OutputFile>> OutputFile::create(std::string what, const std::filesystem::path& file,
                                                       Existing existing, Pace pace) {
    std::unique_ptr<OutputFile> out(new OutputFile(std::move(what), file, existing, pace));
    if (out->standard_) return out;
    const int why = errno;
    if (auto usable = out->file_->hold(); !usable)
        return input_error(out->what_ + ' ' + usable.error().message);
    if (out->out_ < 0) return out->failed(why);
    return out;
}

Result<void> OutputFile::write(std::string_view piece) {
    if (fault_) return *fault_;
    if (standard_) {
        auto written = standard_->write(piece);
        if (!written && written.error().kind != ErrorKind::interrupted)
            written = error_at(name(), written.error());
        if (!written) fault_ = written.error();
        return written;
    }
    waiting_ += piece;
    ends_.push_back(waiting_.size());
    return waiting_.size() < written_at_once ? Result<void>() : flush();
}

/// Returns 0, or errno; after an error the file ends with its last whole piece.
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
    const auto whole = std::ranges::upper_bound(ends_, done);
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
        if (!done && done.error().kind == ErrorKind::input) return error_at(name(), done.error());
        return done;
    }
    const auto whole = flush();
    if (whole) return keep();
    if (pace_ == Pace::own || pieces_ < 2) return whole;
    TRY(keep());
    return input_error(whole.error().message + "; it is kept up to there");
}

Error OutputFile::failed(int why) const {
    return input_error(name() + ": cannot be written: " + failure_words(why));
}

Result<void> all_ok(const std::vector<Result<void>>& finished) {
    std::optional<Error> fault;
    for (const Result<void>& done : finished) {
        if (done) continue;
        if (fault)
            fault->message += "; " + done.error().message;
        else
            fault = done.error();
    }
    return fault ? Result<void>(*fault) : Result<void>();
}

void DeviceTickLog::push(const Tick& tick) {
    const bool has_room = ring_.push([&tick](Slot& slot) {
        slot.tick = tick;
        std::copy(tick.places.begin(), tick.places.end(), slot.places.begin());
        std::copy(tick.newtons.begin(), tick.newtons.end(), slot.newtons.begin());
        slot.tick.places = slot.places;
        slot.tick.newtons = slot.newtons;
    });
    if (!has_room) lost_.fetch_add(1, std::memory_order_relaxed);
}

Result<std::unique_ptr<TickTable>> TickTable::create_forces(const std::filesystem::path& file,
                                                            Existing existing, Pace pace, std::string name) {
    TRY_ASSIGN(auto out, OutputFile::create(std::move(name), file, existing, pace));
    constexpr std::string_view header =
        "tick,time_s,finger,goal_x,goal_y,goal_z,proxy_x,proxy_y,proxy_z,force_x,force_y,force_z,contact,"
        "pixel_x,pixel_y,stiffness,mu_static,mu_dynamic,frame_prev,frame_next,blend,guard,S,capped,share,"
        "hop,error_degrees,error_newtons\n";
    TRY(out->write(header));
    return std::make_unique<ForcesTable>(std::move(out));
}

Result<std::unique_ptr<TickTable>> TickTable::create_device_log(const std::filesystem::path& file,
                                                                Existing existing, DeviceTickLog& log,
                                                                std::string name) {
    TRY_ASSIGN(auto out, OutputFile::create(std::move(name), file, existing, Pace::wall_clock));
    TRY(out->write("time_s,finger,x,y,z,buttons,age_ms,fx,fy,fz,force_on\n"));
    return std::make_unique<DeviceTable>(std::move(out), log);
}

}  // namespace touchable
