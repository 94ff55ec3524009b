#include "engine/base/threads.hpp"

#include <gtest/gtest.h>

#include <mutex>
#include <new>
#include <set>
#include <vector>

namespace touchable::test {
namespace {

TEST(RowBands, GiveEveryRowToOneBandWhateverTheRowsStepsAndThreads) {
    for (const int threads : {1, 2, 3, 7}) {
        RowBands bands(threads);
        for (const int step : {1, 3, 16})
            for (const int rows : {1, 2, 15, 16, 17, 100, 1080}) {
                std::vector<int> visits(static_cast<std::size_t>(rows));  // no two bands touch the same row
                bands.for_each_band(rows, step, [&](const RowBand& band) {
                    EXPECT_LT(band.first, band.last);
                    EXPECT_EQ(band.first % step, 0);
                    EXPECT_TRUE(band.last % step == 0 || band.last == rows);
                    for (int y = band.first; y < band.last; ++y) ++visits[static_cast<std::size_t>(y)];
                });
                EXPECT_EQ(visits, std::vector<int>(static_cast<std::size_t>(rows), 1))
                    << rows << ", " << step;
            }
    }
}

TEST(RowBands, NeverHaveAThreadAtTwoBandsAtOnce) {
    RowBands bands(3);
    std::mutex mutex;
    std::set<int> busy, seen;
    for (int round = 0; round < 200; ++round)
        bands.for_each_band(64, 1, [&](const RowBand& band) {
            {
                const std::lock_guard lock(mutex);
                EXPECT_TRUE(busy.insert(band.thread).second);
                seen.insert(band.thread);
            }
            std::this_thread::yield();
            const std::lock_guard lock(mutex);
            busy.erase(band.thread);
        });
    for (const int thread : seen) EXPECT_TRUE(thread >= 0 && thread < 3) << thread;
}

/// One band waits until another has begun, which only another thread can have.
TEST(RowBands, AreWorkedOnByAnotherThreadToo) {
    RowBands bands(2);
    std::mutex mutex;
    std::condition_variable other_came;
    std::set<std::thread::id> workers;
    bands.for_each_band(64, 1, [&](const RowBand&) {
        std::unique_lock lock(mutex);
        workers.insert(std::this_thread::get_id());
        other_came.notify_all();
        other_came.wait(lock, [&] { return workers.size() == 2; });
    });
    EXPECT_EQ(workers.size(), 2U);
}

TEST(RowBands, ShowWhatOneRunWroteToTheBandsOfTheNext) {
    RowBands bands(3);
    std::vector<int> values(512), sums(512);
    for (int round = 1; round <= 100; ++round) {
        bands.for_each_band(512, 2, [&](const RowBand& band) {
            for (int y = band.first; y < band.last; ++y) values[static_cast<std::size_t>(y)] = round * y;
        });
        bands.for_each_band(512, 4, [&](const RowBand& band) {
            for (int y = band.first; y < band.last; ++y)
                sums[static_cast<std::size_t>(y)] =
                    values[static_cast<std::size_t>(y)] + values[static_cast<std::size_t>(511 - y)];
        });
        ASSERT_EQ(sums, std::vector<int>(512, 511 * round));
    }
}

TEST(RowBands, StartNoThreadForASinglePieceOfWork) {
    RowBands bands(4);
    for (int round = 0; round < 3; ++round)
        bands.for_each_band(16, 16, [caller = std::this_thread::get_id()](const RowBand& band) {
            EXPECT_EQ(std::this_thread::get_id(), caller);
            EXPECT_TRUE(band.first == 0 && band.last == 16 && band.thread == 0);
        });
}

TEST(RowBands, GiveTheCallerWhatABandThrewAndGoOn) {
    for (const int threads : {1, 3}) {
        RowBands bands(threads);
        for (int round = 0; round < 20; ++round) {
            auto refuse_one = [](const RowBand& band) {
                if (band.first >= 300) throw std::bad_alloc();
            };
            EXPECT_THROW(bands.for_each_band(512, 1, refuse_one), std::bad_alloc);
            std::vector<int> visits(512);
            bands.for_each_band(512, 1, [&](const RowBand& band) {
                for (int y = band.first; y < band.last; ++y) ++visits[static_cast<std::size_t>(y)];
            });
            EXPECT_EQ(visits, std::vector<int>(512, 1));
        }
    }
}

}  // namespace
}  // namespace touchable::test
