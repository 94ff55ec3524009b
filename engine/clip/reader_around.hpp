#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// A reader around another one, which it is like but for what a class derived from this changes.
class ReaderAround : public ClipReader {
public:
    const Scene& scene() const override { return reader_->scene(); }
    UnstatedFilters unstated_filters() const override { return reader_->unstated_filters(); }
    const std::vector<TrackInfo>& tracks() const override { return reader_->tracks(); }
    std::optional<std::int64_t> frame_count() const override { return reader_->frame_count(); }
    const std::vector<std::string>& notes() const override { return reader_->notes(); }
    std::span<const Camera> frame_cameras() const override { return reader_->frame_cameras(); }
    Result<std::optional<RawFrame>> next() override { return reader_->next(); }
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override { return reader_->seek(frame); }
    std::int64_t access_point(std::int64_t frame) const override { return reader_->access_point(frame); }
    void leave_out_colour() override { reader_->leave_out_colour(); }
    bool is_live() const override { return reader_->is_live(); }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override { return reader_->begin(zero); }
    void interrupt() override { reader_->interrupt(); }
    std::int64_t taken_before(std::int64_t frame) const override { return reader_->taken_before(frame); }
    std::optional<std::int64_t> taken_at(std::int64_t frame) const override {
        return reader_->taken_at(frame);
    }
    std::vector<std::string> remarks() const override { return reader_->remarks(); }
    std::optional<StreamFigures> stream_figures() const override { return reader_->stream_figures(); }

protected:
    explicit ReaderAround(std::unique_ptr<ClipReader> reader) : reader_(std::move(reader)) {
        for (const auto& input : reader_->inputs()) add_input(input);
    }
    ClipReader& inner() { return *reader_; }

private:
    std::unique_ptr<ClipReader> reader_;
};

}  // namespace touchable
