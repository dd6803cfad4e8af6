#include "takt/console/notices.hpp"

#include <gtest/gtest.h>

#include "support.hpp"

namespace takt::console {
namespace notices_test {

using namespace test;

TEST(PutNotice, WarningsAreErrorsAndTheRestIsStatus) {
    std::string status;
    std::string error;
    const Messages messages{[&](const std::string& text) { status += text; },
                            [&](const std::string& text) { error += text; }};
    using Severity = endpoint::Notice::Severity;
    put_notice(english(), messages,
               {Severity::status, "endpoint.serving", {{"where", "tcp://127.0.0.1:1502"}}, {}});
    EXPECT_TRUE(status.ends_with('\n'));
    EXPECT_NE(status.find("tcp://127.0.0.1:1502"), std::string::npos) << status;
    EXPECT_EQ(error, "");
    for (const auto severity : {Severity::warning, Severity::error}) {
        error.clear();
        put_notice(english(), messages, {severity, "host.retain.damaged", {{"file", "plant.state"}}, {}});
        EXPECT_NE(error.find("plant.state"), std::string::npos) << error;
        EXPECT_FALSE(error.ends_with('\n'));
    }
}

}  // namespace notices_test
}  // namespace takt::console
