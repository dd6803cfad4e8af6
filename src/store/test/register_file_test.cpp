// After a power cut at any point of a write to a file of registers, the last acknowledged image or the one
// that was being written is found in it.
#include "takt/store/register_file.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string_view>

#include "takt/store/crc32c.hpp"
#include "torn_disk.hpp"

namespace takt::store {
namespace register_file_test {

using test::TornDisk;
using Image = std::vector<std::uint8_t>;

const RegisterLayout kSmall{1, {{3, false, 0, 299}, {0, true, 7, 90}}};  // one page a copy, two sectors of it
const RegisterLayout kLarge{1, {{3, false, 0, 5999}, {2, false, 100, 150}}};  // three pages a copy

Image image_of(const RegisterLayout& layout, unsigned seed) {
    Image image(layout.bytes());
    for (std::size_t i = 0; i < image.size(); ++i)
        image[i] = static_cast<std::uint8_t>((i * 31 + seed * 17) >> (seed % 3));
    return image;
}

Image bytes_of(Bytes bytes) {
    return {bytes.begin(), bytes.end()};
}

TornDisk made(const RegisterLayout& layout) {
    TornDisk disk(RegisterFile::file_size(layout));
    EXPECT_TRUE(RegisterFile::make(disk, layout, image_of(layout, 0)));
    EXPECT_TRUE(disk.unsynced().empty());
    return disk;
}

TEST(Crc32c, IsThatOfTheStandard) {
    // RFC 3720, appendix B.4
    EXPECT_EQ(crc32c(Image(32, 0x00)), 0x8A9136AAU);
    EXPECT_EQ(crc32c(Image(32, 0xFF)), 0x62A8AB43U);
    Image ascending(32);
    for (std::size_t i = 0; i < ascending.size(); ++i) ascending[i] = static_cast<std::uint8_t>(i);
    EXPECT_EQ(crc32c(ascending), 0x46DD794EU);
    EXPECT_EQ(crc32c(Bytes(ascending).subspan(5), crc32c(Bytes(ascending).first(5))), 0x46DD794EU);
}

TEST(RegisterFile, HoldsWhatWasCommitted) {
    TornDisk disk = made(kSmall);
    for (unsigned i = 1; i < 5; ++i) {
        auto file = RegisterFile::open(disk, kSmall);
        ASSERT_TRUE(file);
        EXPECT_FALSE(file->was_damaged());
        EXPECT_EQ(bytes_of(file->image()), image_of(kSmall, i - 1));
        EXPECT_TRUE(file->commit(image_of(kSmall, i)));
        EXPECT_EQ(file->sequence(), i + 1);
        EXPECT_EQ(bytes_of(file->image()), image_of(kSmall, i));
    }
}

TEST(RegisterFile, WritesNothingWhereNothingChanged) {
    TornDisk disk = made(kSmall);
    auto file = RegisterFile::open(disk, kSmall);
    ASSERT_TRUE(file);
    const int before = disk.operations();
    EXPECT_TRUE(file->commit(image_of(kSmall, 0)));
    EXPECT_EQ(disk.operations(), before);
    EXPECT_EQ(file->counters().commits, 0u);
}

TEST(RegisterFile, WritesOnlyThePagesThatDiffer) {
    TornDisk disk = made(kLarge);
    auto file = RegisterFile::open(disk, kLarge);
    ASSERT_TRUE(file);
    Image image = image_of(kLarge, 0);
    for (int i = 0; i < 4; ++i) {
        const auto before = file->counters().bytes;
        image.back() = static_cast<std::uint8_t>(image.back() + 1);
        ASSERT_TRUE(file->commit(image));
        EXPECT_EQ(file->counters().bytes - before, 2 * RegisterFile::kPage) << i << ": header and last page";
    }
}

/// Every way in which up to `most` unsynchronised sectors arrive or not, and one of them in part.
template <class Check>
void for_each_survival(const TornDisk& disk, const Check& check) {
    const std::size_t pieces = disk.unsynced().size();
    ASSERT_LE(pieces, 8u);
    for (unsigned arrives = 0; arrives < 1U << pieces; ++arrives)
        check(disk.after_cut([&, at = 0U](const TornDisk::Piece& piece) mutable {
            return (arrives >> at++ & 1) != 0 ? piece.bytes.size() : 0;
        }));
    for (std::size_t torn = 0; torn < pieces; ++torn)
        for (std::size_t length = 1; length < TornDisk::kSector; length += length < 64 ? 3 : 61)
            check(disk.after_cut([&, at = std::size_t{0}](const TornDisk::Piece& piece) mutable {
                return at++ == torn ? length : piece.bytes.size();
            }));
}

TEST(RegisterFile, SurvivesEveryCut) {
    constexpr unsigned kCommits = 4;
    const TornDisk start = made(kSmall);
    int cuts = 0;
    for (int fuse = 0;; ++fuse) {
        TornDisk disk = start;
        auto file = RegisterFile::open(disk, kSmall);
        ASSERT_TRUE(file);
        disk.fuse = fuse;
        unsigned acknowledged = 0;
        while (acknowledged < kCommits && file->commit(image_of(kSmall, acknowledged + 1))) ++acknowledged;
        if (!disk.cut()) break;
        ++cuts;
        for_each_survival(disk, [&](TornDisk left) {
            const auto found = RegisterFile::open(left, kSmall);
            ASSERT_TRUE(found) << "cut at operation " << fuse;
            const Image image = bytes_of(found->image());
            EXPECT_TRUE(image == image_of(kSmall, acknowledged) ||
                        image == image_of(kSmall, acknowledged + 1))
                << "cut at operation " << fuse;
        });
    }
    EXPECT_EQ(cuts, 2 * int{kCommits});  // a write and a synchronisation each
}

/// Commits, power cuts, and synchronisations that fail, with any part of them on the disk; over several
/// starts.
RC_GTEST_PROP(RegisterFile, IsFoundAfterAnyLife, ()) {
    const RegisterLayout& layout = **rc::gen::element(&kSmall, &kLarge);
    TornDisk disk = made(layout);
    const auto survival = [](const TornDisk::Piece& piece) {
        const auto kind = *rc::gen::inRange(0, 5);
        if (kind == 0) return *rc::gen::inRange<std::size_t>(0, piece.bytes.size() + 1);
        return kind < 3 ? piece.bytes.size() : 0;
    };
    std::vector<Image> possible{image_of(layout, 0)};
    const int lives = *rc::gen::inRange(1, 5);
    for (int life = 0; life < lives; ++life) {
        auto file = RegisterFile::open(disk, layout);
        RC_ASSERT(file.has_value());
        Image image = bytes_of(file->image());
        RC_ASSERT(std::ranges::find(possible, image) != possible.end());
        possible = {image};
        disk.fuse = *rc::gen::inRange(0, 12);
        while (!disk.cut()) {
            Image next = image;
            const auto at = *rc::gen::inRange<std::size_t>(0, next.size());
            const auto length = *rc::gen::inRange<std::size_t>(1, next.size() - at + 1);
            for (std::size_t i = at; i < at + length; ++i) next[i] = static_cast<std::uint8_t>(next[i] + 1);
            if (*rc::gen::inRange(0, 4) == 0) disk.fails_sync = survival;
            if (file->commit(next)) {
                image = next;
                possible = {image};
            } else {
                possible.push_back(next);  // refused, and yet it may be what is found
                RC_ASSERT(bytes_of(file->image()) == image);
            }
        }
        disk = disk.after_cut(survival);
    }
}

TEST(RegisterFile, KnowsWhatIsNotItsOwn) {
    TornDisk text(RegisterFile::file_size(kSmall));
    ASSERT_TRUE(text.write_at(0, Image(5000, 'x')));
    EXPECT_EQ(RegisterFile::open(text, kSmall).error().code, Code::unsupported);
}

TEST(RegisterFile, ZerosAndAPartOfTheMarkAreDamage) {
    TornDisk zeros(RegisterFile::file_size(kSmall));
    EXPECT_EQ(RegisterFile::open(zeros, kSmall).error().code, Code::malformed);
    for (const std::size_t length : {0U, 1U, 7U, 8U, 511U, 4095U}) {
        TornDisk few_zeros(length);
        EXPECT_EQ(RegisterFile::open(few_zeros, kSmall).error().code, Code::too_short) << length;
        TornDisk cut_off(length);
        ASSERT_TRUE(cut_off.write_at(0, Bytes(made(kSmall).durable()).first(length)));
        EXPECT_EQ(RegisterFile::open(cut_off, kSmall).error().code, Code::too_short) << length;
    }
}

TEST(RegisterFile, ReportsItsOwnLayout) {
    TornDisk disk = made(kSmall);
    const auto file = RegisterFile::open(disk, kLarge);
    ASSERT_TRUE(file);
    EXPECT_EQ(file->layout(), kSmall);
    EXPECT_EQ(bytes_of(file->image()), image_of(kSmall, 0));
}

TEST(RegisterFile, AnyDamagedByteIsFoundOut) {
    TornDisk start = made(kSmall);
    {
        auto file = RegisterFile::open(start, kSmall);
        ASSERT_TRUE(file->commit(image_of(kSmall, 1)));
    }
    // The description, then the copies: image 0 in the first, image 1 in the second. 28 bytes of header, 611
    // of the image; later bytes are ignored.
    const std::size_t described = 20 + 2 * 6 + 4;
    const std::size_t used = 28 + kSmall.bytes();
    for (std::size_t page = 0; page < 3; ++page)
        for (std::size_t at = 0; at < (page == 0 ? described : used); at += page == 0 ? 1 : 7) {
            TornDisk disk = start;
            const std::size_t where = page * RegisterFile::kPage + at;
            const Image changed{static_cast<std::uint8_t>(disk.durable()[where] ^ 0x10)};
            ASSERT_TRUE(disk.write_at(where, changed));
            ASSERT_TRUE(disk.sync());
            const auto file = RegisterFile::open(disk, kSmall);
            ASSERT_TRUE(file) << where;
            EXPECT_TRUE(file->was_damaged()) << where;
            EXPECT_EQ(file->layout(), kSmall) << where;
            EXPECT_EQ(bytes_of(file->image()), image_of(kSmall, page == 2 ? 0 : 1)) << where;
        }
}

TEST(RegisterFile, NoticesThatANewestCopyReadsAsZeros) {
    for (unsigned commits = 0; commits < 4; ++commits) {
        TornDisk disk = made(kSmall);
        for (unsigned i = 1; i <= commits; ++i) {
            auto file = RegisterFile::open(disk, kSmall);
            ASSERT_TRUE(file);
            ASSERT_FALSE(file->was_damaged()) << commits;
            ASSERT_TRUE(file->commit(image_of(kSmall, i)));
        }
        const std::uint64_t newest = RegisterFile::kPage * (1 + commits % 2);
        ASSERT_TRUE(disk.write_at(newest, Image(RegisterFile::kPage)));
        const auto file = RegisterFile::open(disk, kSmall);
        ASSERT_TRUE(file);
        EXPECT_TRUE(file->was_damaged()) << commits;
        EXPECT_EQ(bytes_of(file->image()), image_of(kSmall, commits == 0 ? 0 : commits - 1));
    }
}

TEST(RegisterFile, WithoutAWholeCopyIsDamaged) {
    TornDisk disk = made(kSmall);
    for (const std::uint64_t copy : {1U, 2U})
        ASSERT_TRUE(disk.write_at(copy * RegisterFile::kPage + 100, Image{0xAA, 0x55}));
    EXPECT_EQ(RegisterFile::open(disk, kSmall).error().code, Code::malformed);
}

}  // namespace register_file_test
}  // namespace takt::store
