#include <numeric>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "tests/gpu/gpu_fixture.hpp"

namespace touchable::test {
namespace {

class Buffer : public GpuTest {
protected:
    void run(GpuCommands commands) { must(must(std::move(commands).submit()).wait()); }
};

TEST_F(Buffer, BytesGoUpAcrossAndBack) {
    constexpr std::size_t count = 1001;  // an odd one
    const auto up = must(GpuBuffer::create(*gpu, "up", count * 4, GpuMemory::upload));
    const auto there = must(GpuBuffer::create(*gpu, "there", count * 4, GpuMemory::device));
    const auto back = must(GpuBuffer::create(*gpu, "back", count * 4, GpuMemory::readback));
    EXPECT_TRUE(there.mapped<std::uint32_t>().empty());
    ASSERT_EQ(up.mapped<std::uint32_t>().size(), count);
    std::iota(up.mapped<std::uint32_t>().begin(), up.mapped<std::uint32_t>().end(), 7U);
    std::fill_n(back.mapped<std::uint32_t>().begin(), count, 0U);

    auto commands = must(GpuCommands::begin(gpu, "round trip"));
    commands.copy(up, 0, there, 0, count * 4);
    commands.barrier(GpuStage::transfer, GpuStage::transfer);
    commands.copy(there, 0, back, 0, count * 4);
    run(std::move(commands));
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(back.mapped<std::uint32_t>()[i], i + 7) << i;
}

TEST_F(Buffer, ImportsMemoryThatStaysTheCpus) {
    ASSERT_GT(gpu->facts().import_alignment, 0U);
    constexpr std::size_t count = 5000;
    std::shared_ptr<std::uint8_t> memory = take_plane_memory(count * 4);
    auto* const words = reinterpret_cast<std::uint32_t*>(memory.get());
    auto imported = must(GpuBuffer::import(*gpu, "words", plane_block_of(memory.get(), count * 4)));
    EXPECT_TRUE(imported.mapped<std::uint32_t>().empty());
    const auto back = must(GpuBuffer::create(*gpu, "back", count * 4, GpuMemory::readback));
    // What is written after it was imported counts, and the memory outlives its lease while it is read.
    std::iota(words, words + count, 9U);
    auto commands = must(GpuCommands::begin(gpu, "from the CPU's"));
    commands.copy(imported, 0, back, 0, count * 4);
    memory.reset();
    imported = {};
    run(std::move(commands));
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(back.mapped<std::uint32_t>()[i], i + 9) << i;
}

TEST_F(Buffer, FillsWhatItIsToldTo) {
    const auto buffer = must(GpuBuffer::create(*gpu, "filled", 64, GpuMemory::shared));
    auto commands = must(GpuCommands::begin(gpu, "fill"));
    commands.fill(buffer, 0xAAAAAAAAU);
    commands.barrier(GpuStage::transfer, GpuStage::transfer);
    commands.fill(buffer, 5, 8, 12);
    run(std::move(commands));
    const auto words = buffer.mapped<std::uint32_t>();
    for (std::size_t i = 0; i < words.size(); ++i)
        EXPECT_EQ(words[i], i >= 2 && i < 5 ? 5U : 0xAAAAAAAAU) << i;
}

TEST_F(Buffer, IsWholeTexelsForKernelsAndExactForTheCpu) {
    const auto buffer = must(GpuBuffer::create(*gpu, "odd", 33, GpuMemory::shared));
    EXPECT_EQ(buffer.bytes(), 33U);
    EXPECT_EQ(buffer.size(), 48U);
    EXPECT_EQ(buffer.mapped<std::byte>().size(), 33U);
    EXPECT_NE(buffer.texels(), VkBufferView(VK_NULL_HANDLE));
    EXPECT_FALSE(GpuBuffer());
}

TEST_F(Buffer, OutlivesTheDevicesHandle) {
    auto buffer = must(GpuBuffer::create(*gpu, "late", 64, GpuMemory::shared));
    auto other = must(GpuDevice::open({"auto", true}));
    const auto its_messages = other->messages();
    buffer = must(GpuBuffer::create(*other, "later", 64, GpuMemory::shared));
    other.reset();
    buffer.mapped<std::uint32_t>()[0] = 3;
    EXPECT_EQ(buffer.mapped<std::uint32_t>()[0], 3U);
    buffer = {};
    EXPECT_TRUE(its_messages->all().empty());
}

TEST_F(Buffer, TooMuchOrNothingIsRefusedWithItsName) {
    for (const std::size_t bytes : {std::size_t{0}, std::size_t{1} << 50U, ~std::size_t{0}})
        for (const GpuMemory memory : {GpuMemory::device, GpuMemory::shared}) {
            const auto buffer = GpuBuffer::create(*gpu, "too much", bytes, memory);
            ASSERT_FALSE(buffer);
            EXPECT_EQ(buffer.error().kind, ErrorKind::gpu);
            EXPECT_NE(buffer.error().message.find("'too much'"), std::string::npos) << buffer.error().message;
        }
}

}  // namespace
}  // namespace touchable::test
