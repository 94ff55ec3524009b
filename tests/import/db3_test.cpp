// Recordings of ROS 2 in SQLite, written by SQLite itself in the tables of rosbag2_storage_sqlite3.
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <zstd.h>

#include <algorithm>
#include <map>
#include <memory>

#include "tests/clip/clip_fixture.hpp"
#include "tests/import/ros2_messages.hpp"

namespace touchable::test {
namespace {

/// A database that SQLite writes.
class WrittenDatabase {
public:
    explicit WrittenDatabase(const std::filesystem::path& file) {
        std::filesystem::remove(file);
        EXPECT_EQ(sqlite3_open(file.c_str(), &database_), SQLITE_OK);
    }
    ~WrittenDatabase() { EXPECT_EQ(sqlite3_close(database_), SQLITE_OK); }
    void run(const std::string& statements) {
        char* wrong = nullptr;
        EXPECT_EQ(sqlite3_exec(database_, statements.c_str(), nullptr, nullptr, &wrong), SQLITE_OK)
            << (wrong == nullptr ? "" : wrong);
    }
    /// Texts, but for the last value, which is bytes.
    void insert(const std::string& statement, const std::vector<std::string>& values) {
        sqlite3_stmt* prepared = nullptr;
        ASSERT_EQ(sqlite3_prepare_v2(database_, statement.c_str(), -1, &prepared, nullptr), SQLITE_OK);
        for (std::size_t k = 0; k < values.size(); ++k) {
            const int place = static_cast<int>(k) + 1, size = static_cast<int>(values[k].size());
            if (k + 1 == values.size())
                sqlite3_bind_blob(prepared, place, values[k].data(), size, SQLITE_TRANSIENT);
            else
                sqlite3_bind_text(prepared, place, values[k].data(), size, SQLITE_TRANSIENT);
        }
        EXPECT_EQ(sqlite3_step(prepared), SQLITE_DONE);
        sqlite3_finalize(prepared);
    }

private:
    sqlite3* database_ = nullptr;
};

/// As Humble has them, and as Foxy had.
constexpr const char* tables =
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,metadata TEXT NOT NULL);"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format "
    "TEXT "
    "NOT NULL,offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data "
    "BLOB NOT NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);";
constexpr const char* older_tables =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format "
    "TEXT "
    "NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data "
    "BLOB NOT NULL);";

struct Db3Options {
    std::string begin{};  ///< statements before the tables
    const char* made = tables;
    std::string format = "cdr";
    bool is_packed = false;    ///< each message, by zstd
    bool is_reversed = false;  ///< the last message first
};

void fill(WrittenDatabase& database, const Db3Options& options) {
    database.run(options.begin + options.made + "BEGIN");
    std::map<std::string, std::string> topics;
    auto messages = ros2_recording();
    if (options.is_reversed) std::reverse(messages.begin(), messages.end());
    for (const Ros2Message& each : messages) {
        auto& topic = topics[each.topic];
        if (topic.empty()) {
            topic = std::to_string(topics.size());
            database.insert(std::string("INSERT INTO topics VALUES (?1, ?2, ?3, CAST(?4 AS TEXT)") +
                                (options.made == tables ? ", '')" : ")"),
                            {topic, each.topic, each.type, options.format});
        }
        std::string bytes = each.bytes;
        if (options.is_packed) {
            bytes.resize(ZSTD_compressBound(each.bytes.size()));
            bytes.resize(ZSTD_compress(bytes.data(), bytes.size(), each.bytes.data(), each.bytes.size(), 1));
        }
        database.insert("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)",
                        {topic, std::to_string(each.time_ns), bytes});
    }
    database.run("COMMIT");
}

void write_db3(const std::filesystem::path& file, const Db3Options& options = {}) {
    WrittenDatabase database(file);
    fill(database, options);
}

std::string refusal(const std::filesystem::path& file) {
    std::string said = message(open_clip(file));
    EXPECT_NE(said.find(file.filename().string() + ": "), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos);
    return said;
}

TEST(Db3, ARecordingOfRos2OpensHoweverItWasWritten) {
    const TemporaryFolder folder;
    for (const Db3Options& options :
         {Db3Options{}, Db3Options{"", older_tables}, Db3Options{"", tables, "cdr", false, true},
          Db3Options{"PRAGMA page_size=512;"}, Db3Options{"PRAGMA page_size=65536;"},
          Db3Options{"PRAGMA journal_mode=WAL;"}}) {
        SCOPED_TRACE(options.begin + (options.is_reversed ? " reversed" : ""));
        write_db3(folder / "x.db3", options);
        const auto clip = open_clip(folder / "x.db3");
        ASSERT_EQ(message(clip), "");
        expect_ros2_recording(**clip);
    }
}

TEST(Db3, AFolderIsItsFile) {
    const TemporaryFolder folder;
    write_bytes(folder / "metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "neither a .db3 nor an .mcap"));
    write_bytes(folder / "x_0.db3.zstd", "packed");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "zstd -d "));
    write_db3(folder / "x_0.db3");
    const auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    expect_ros2_recording(**clip);
    const auto guessed = guess_clip(folder.path(), {});
    ASSERT_EQ(message(guessed), "");
    EXPECT_EQ(guessed->scene.video->depth, "x_0.db3");
    write_db3(folder / "x_1.db3");
    const std::string said = message(open_clip(folder.path()));
    EXPECT_NE(said.find("in 2 files"), std::string::npos) << said;
    EXPECT_NE(said.find("x_0.db3"), std::string::npos) << said;
}

TEST(Db3, WhatIsInALogBesideItIsLeftOutAndSaid) {
    const TemporaryFolder folder;
    WrittenDatabase recorder(folder / "x.db3");
    fill(recorder, {"PRAGMA journal_mode=WAL;"});
    recorder.run("PRAGMA wal_checkpoint(TRUNCATE); DELETE FROM messages");
    const auto clip = open_clip(folder / "x.db3");
    ASSERT_EQ(message(clip), "");
    expect_ros2_recording(**clip);
    const auto told = clip_notes(**clip);
    EXPECT_TRUE(std::any_of(told.begin(), told.end(), [](const std::string& note) {
        return note.find("x.db3-wal are left out") != std::string::npos;
    }));
}

TEST(Db3, WhatIsNoRecordingIsRefused) {
    const TemporaryFolder folder;
    const auto file = folder / "x.db3";
    write_bytes(file, "text\n");
    EXPECT_NE(refusal(file).find("nor a recording of ROS"), std::string::npos);
    write_bytes(file, std::string("SQLite format 3\0 and nothing more", 33));
    EXPECT_NE(refusal(file).find("is damaged"), std::string::npos);
    const std::string none = "must have the tables topics and messages";
    { WrittenDatabase(file).run("CREATE TABLE topics(id, name, type, serialization_format)"); }
    EXPECT_NE(refusal(file).find(none), std::string::npos);
    { WrittenDatabase(file).run("CREATE TABLE topics(a); CREATE TABLE messages(a)"); }
    EXPECT_NE(refusal(file).find("no such column"), std::string::npos);
    write_db3(file, {"", tables, "something"});
    EXPECT_NE(refusal(file).find("has no topic of depth (there are no pictures)"), std::string::npos);
    write_db3(file, {"", tables, "cdr", true});
    EXPECT_NE(refusal(file).find("packed by zstd (compression_mode: message)"), std::string::npos);
}

/// Views that never end, tables that are computed or another program's, and indices that say something else.
TEST(Db3, AHostileSchemaIsRefusedAtOnce) {
    const TemporaryFolder folder;
    const auto file = folder / "x.db3";
    const std::string topics =
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
        "INSERT INTO topics VALUES(1, '/depth', 'sensor_msgs/msg/Image', 'cdr');";
    const std::string none = "must have the tables topics and messages";
    const std::map<std::string, std::string> schemas{
        {"CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) SELECT "
         "id, 1 AS "
         "topic_id, 0 AS timestamp, x'00' AS data FROM n",
         none},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp AS "
         "(length(hex(zeroblob(1000000)))), data)",
         none},
        {"CREATE VIRTUAL TABLE messages USING rtree(id, topic_id, timestamp)", "no such module"},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data) WITHOUT ROWID",
         "no such column"},
        {"CREATE TABLE messages(rowid, topic_id, timestamp, data);"
         "INSERT INTO messages VALUES(2, 1, 0, x'00'), (1, 1, 0, x'00')",
         "not in order"},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);"
         "INSERT INTO messages VALUES(1, 1, 0, NULL)",
         "cannot open value of type null"},
        {"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);"
         "CREATE TABLE m(x); PRAGMA writable_schema=ON; UPDATE sqlite_schema SET sql='CREATE VIRTUAL TABLE "
         "messages "
         "USING rtree(a, b, c)' WHERE name='messages'",
         "no such module"}};
    for (const auto& [schema, words] : schemas) {
        SCOPED_TRACE(schema);
        { WrittenDatabase(file).run(topics + schema); }
        const std::string said = refusal(file);
        EXPECT_NE(said.find(words), std::string::npos) << said;
    }
}

/// Whole messages of many pages, beyond what SQLite itself may read at once here.
TEST(Db3, LargePicturesAreRead) {
    const TemporaryFolder folder;
    const auto file = folder / "x.db3";
    {
        WrittenDatabase database(file);
        fill(database, {});
        database.run("UPDATE messages SET data = CAST(data || zeroblob(3000000) AS BLOB)");
    }
    const auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    expect_ros2_recording(**clip);
}

TEST(Db3, DamageIsToldOrReadOver) {
    const TemporaryFolder folder;
    const auto file = folder / "x.db3";
    write_db3(file, {"PRAGMA page_size=512;"});
    const std::string whole = read_bytes(file);
    for (std::size_t length = 16; length < whole.size(); length += 509) {
        write_bytes(file, whole.substr(0, length));
        EXPECT_NE(refusal(file).find("is damaged"), std::string::npos) << length;
    }
    Numbers numbers(7);
    for (int n = 0; n < 300; ++n) {
        std::string damaged = whole;
        for (int k = 0; k < 4; ++k)
            damaged[static_cast<std::size_t>(16 + numbers.below(static_cast<int>(whole.size()) - 16))] =
                static_cast<char>(numbers.below(256));
        write_bytes(file, damaged);
        const auto clip = open_clip(file);
        if (clip) (void)read_all(**clip);
        if (!clip) {
            EXPECT_TRUE(is_refused(clip, "x.db3"));
        }
    }
}

}  // namespace
}  // namespace touchable::test
