#include "takt/console/notices.hpp"

#include <gtest/gtest.h>

#include "support.hpp"

namespace takt::console {
namespace {

using namespace test;

TEST(PutNotice, WarningsAreErrorsAndTheRestIsStatus) {
    std::string status;
    std::string error;
    const Messages messages{[&](const std::string& text) { status += text; },
                            [&](const std::string& text) { error += text; }};
    const auto serving = endpoint::make_notice("app.serving", {{"where", "tcp://127.0.0.1:1502"}});
    put_notice(english(), messages, serving);
    EXPECT_TRUE(status.ends_with('\n'));
    EXPECT_NE(status.find("tcp://127.0.0.1:1502"), std::string::npos) << status;
    EXPECT_EQ(error, "");
    put_notice(english(), messages, endpoint::make_notice("app.serve.unknown", {}));
    EXPECT_NE(error, "");
    EXPECT_FALSE(error.ends_with('\n'));
}

}  // namespace
}  // namespace takt::console
