#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

namespace touchable {

/// Rows [first, last) of a picture, and which of the threads, 0 to `threads()` - 1, is at work on them: what
/// a thread needs for itself is kept by this number.
struct RowBand {
    int first, last, thread;
};

/// As many as pay for so many pixels, if a thread more pays where it has `pixels_per_thread`: work of 50 us,
/// of which waking it takes some 5 of CPU time and a few tens of waiting. At most 4, since more of them wait
/// for memory, and others of a program want cores too; and no more than there are cores.
int threads_for(long pixels, long pixels_per_thread);

/// Threads that share the rows of a picture: the one that calls, and others that sleep in between.
class RowBands {
public:
    /// `threads` with the one that calls, at least 1. The others start when first needed, and take on the
    /// scheduling of the thread that calls then. `until_stopped`: bands are left out once the thread that
    /// calls is asked to stop, which the caller looks for (stop_requested).
    explicit RowBands(int threads, bool until_stopped = false);
    ~RowBands();
    RowBands(const RowBands&) = delete;
    RowBands& operator=(const RowBands&) = delete;

    int threads() const { return threads_; }

    /// Calls `work(RowBand)` for bands that together are rows 0 to `rows` - 1, each a multiple of `step` rows
    /// but the last; returns when all are done. What a band writes no other may read or write, and which
    /// thread has a band must not matter. What `work` throws is thrown on, the first of several, and bands
    /// that had not begun are left out. One call at a time. No allocation but where threads start.
    template <class Work>
    void for_each_band(int rows, int step, Work&& work) {
        using Plain = std::remove_reference_t<Work>;
        run({rows, step, [](void* call, const RowBand& band) { (*static_cast<Plain*>(call))(band); }, &work});
    }

private:
    struct Job {
        int rows = 0, step = 1;
        void (*call)(void* work, const RowBand& band) = nullptr;
        void* work = nullptr;
        int band_rows = 0, next_row = 0, bands_at_work = 0;
    };
    void run(Job job);
    void start_others();
    void work_on(std::unique_lock<std::mutex>& lock, const RowBand& band);
    void take_bands(std::unique_lock<std::mutex>& lock, int thread);
    void serve(int thread);

    const int threads_;
    const bool until_stopped_;
    std::mutex mutex_;
    std::condition_variable there_is_work_, all_done_;
    Job job_;
    std::exception_ptr fault_;
    bool ending_ = false;
    std::vector<std::thread> others_;
};

}  // namespace touchable
