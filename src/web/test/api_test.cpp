#include "takt/web/api.hpp"

#include <gtest/gtest.h>

namespace takt::web {
namespace api_test {

TEST(Api, GivesTheFirstValueOfAParameter) {
    const report::Texts texts(text::Language::english);
    const ApiRequest request{.query = {{"a", "1"}, {"a", "2"}, {"b", ""}}, .texts = texts};
    EXPECT_EQ(request.parameter("a"), "1");
    EXPECT_EQ(request.parameter("b"), "");
    EXPECT_EQ(request.parameter("c"), "");
}

TEST(Api, WritesErrorsAsOneObject) {
    const auto response = ApiResponse::error(403, "read_only", "A \"text\"");
    EXPECT_EQ(response.status, 403);
    EXPECT_EQ(response.body, "{\"error\":{\"code\":\"read_only\",\"text\":\"A \\\"text\\\"\"}}\n");
}

}  // namespace api_test
}  // namespace takt::web
