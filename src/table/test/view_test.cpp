// Images that are refused, and that no other image can do harm.
#include "takt/table/view.hpp"

#include <gtest/gtest.h>

#include "project.hpp"
#include "takt/table/owen.hpp"

namespace takt::table {
namespace view_test {

using namespace test;

model::Project boiler() {
    auto boiler = device("Boiler", 16);
    for (std::uint16_t i = 0; i < 3; ++i)
        boiler.variables.push_back(
            variable("V" + std::to_string(i), DataType::float32, 2 * i, Function::read_holding_registers));
    boiler.variables[1].write = Function::write_multiple_registers;
    boiler.variables[1].write_on_change = true;
    boiler.poll_enable = 0;
    boiler.status = 1;
    auto result = project({boiler});
    result.locals = {local("on"), local("state", DataType::int16)};
    return result;
}

Error error_of(const Image& image) {
    const auto view = View::open(image);
    return view ? Error{} : view.error();
}

Error owen_error_of(const Image& image) {
    const auto table = read_owen(image);
    return table ? Error{} : table.error();
}

std::vector<std::pair<Image, Error (*)(const Image&)>> both_formats() {
    const auto described = boiler();
    return {{image_of(described).value(), error_of},
            {write_owen(build_owen(described, plan::make_plan(described)).table), owen_error_of}};
}

TEST(View, TakesWhatWasBuilt) {
    for (const auto& [image, error] : both_formats()) EXPECT_EQ(error(image), Error{});
}

TEST(View, RefusesEveryTruncation) {
    for (const auto& [image, error] : both_formats())
        for (std::size_t size = 0; size < image.size(); ++size) {
            const Image cut(image.begin(), image.begin() + static_cast<std::ptrdiff_t>(size));
            EXPECT_EQ(error(cut).code, Code::too_short) << size;
        }
}

TEST(View, RefusesWhatFollows) {
    for (auto& [image, error] : both_formats()) {
        Image longer = image;
        longer.push_back(0);
        EXPECT_EQ(error(longer).code, Code::too_long);
    }
}

TEST(View, RefusesEveryFlippedByte) {
    for (const auto& [image, error] : both_formats())
        for (std::size_t i = 0; i < image.size(); ++i)
            for (const int mask : {0x01, 0x80, 0xFF}) {
                Image flipped = image;
                flipped[i] = static_cast<std::uint8_t>(flipped[i] ^ mask);
                EXPECT_NE(error(flipped), Error{}) << i;
            }
}

TEST(View, RefusesOtherVersionsForeignAndEmptyByName) {
    for (const auto& [image, error] : both_formats()) {
        const std::uint8_t known = image[kMagicSize];
        for (const int other : {known - 1, known + 1}) {
            if (other == 0) continue;
            Image changed = image;
            changed[kMagicSize] = static_cast<std::uint8_t>(other);
            seal(changed);
            const auto refused = error(changed);
            EXPECT_EQ(refused.code, Code::unsupported);
            EXPECT_EQ(refused.subject.view(), "version");
            EXPECT_EQ(refused.numbers[0], other);
            EXPECT_EQ(refused.numbers[1], known);
        }
        Image foreign = image;
        foreign[0] = 'X';
        seal(foreign);
        EXPECT_EQ(error(foreign).code, Code::malformed);
        EXPECT_EQ(error(foreign).subject.view(), "magic");
        EXPECT_EQ(error({}).code, Code::too_short);
        Image corrupt = image;
        corrupt.back() ^= 1;
        EXPECT_EQ(error(corrupt).code, Code::bad_checksum);
    }
}

// An accepted image with one wrong byte and a good checksum can be used without harm; sanitizers check this.
TEST(View, ASealedLieIsFoundOrHarmless) {
    const auto image = image_of(boiler()).value();
    for (std::size_t i = kChecksumOffset + 4; i < image.size(); ++i)
        for (const int mask : {0x01, 0x80, 0xFF}) {
            Image lie = image;
            lie[i] = static_cast<std::uint8_t>(lie[i] ^ mask);
            seal(lie);
            const auto view = View::open(lie);
            if (!view) continue;
            std::size_t sum = 0;
            for (std::uint32_t e = 0; e < view->entry_count(); ++e)
                for (std::uint32_t m = 0; m < view->entry(e).member_count; ++m)
                    sum += view->text(view->item(view->member(view->entry(e), m)).name).size();
            EXPECT_LT(sum, 10000U);
        }
}

// A broadcast has no response. The engine rejects such a request.
TEST(View, ARequestThatReadsIsNoBroadcast) {
    Image image = image_of(boiler()).value();
    const std::size_t unit = View::open(image)->header().devices.offset + sizeof(DeviceRecord::line);
    ASSERT_EQ(image[unit], View::open(image)->device(0).unit);
    image[unit] = 0;
    seal(image);
    EXPECT_EQ(error_of(image).code, Code::malformed);
    EXPECT_EQ(error_of(image).subject.view(), "entry");
}

TEST(Crc32, IsTheKnownOne) {
    Crc32 crc;
    for (const char c : std::string("123456789")) crc.add(static_cast<std::uint8_t>(c));
    EXPECT_EQ(crc.value(), 0xCBF43926U);
}

}  // namespace view_test
}  // namespace takt::table
