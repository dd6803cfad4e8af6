#include "takt/console/clock_text.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <regex>

#include "takt/line/loop.hpp"

namespace takt::console {
namespace clock_text_test {

/// The zone of the process for one test.
class Zone {
public:
    explicit Zone(const char* name) {
        ::setenv("TZ", name, 1);
        ::tzset();
    }
    ~Zone() {
        ::unsetenv("TZ");
        ::tzset();
    }
};

TEST(ClockText, IsoTimeHasTheOffsetOfTheZone) {
    const struct {
        const char* zone;
        const char* offset;
    } cases[] = {{"UTC0", "+00:00"}, {"EET-2", "+02:00"}, {"NST3:30", "-03:30"}};
    for (const auto& [zone, offset] : cases) {
        const Zone set(zone);
        const auto text = iso_time(line::now());
        EXPECT_TRUE(
            std::regex_match(text, std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d)")))
            << text;
        EXPECT_EQ(text.substr(23), offset);
    }
}

}  // namespace clock_text_test
}  // namespace takt::console
