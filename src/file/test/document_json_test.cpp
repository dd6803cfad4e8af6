#include "takt/file/document_json.hpp"

#include <gtest/gtest.h>

#include "outline.hpp"
#include "takt/file/load.hpp"

namespace takt::file {
namespace document_json_test {

using model::Node;

constexpr const char* kText =
    "takt: 1\nlines:\n  - name: \"l\"\n    devices:\n      - {name: d, address: 0x10, status: ~}\n    x: [1, "
    "a]\n";

Node root_of(const std::string& text) {
    return read_project_text("p.yaml", text).document.root;
}

TEST(DocumentJson, HasRawTextsAndTheIndexOfItems) {
    EXPECT_EQ(document_json(root_of(kText)).dump(),
              R"({"takt":"1","lines":[{"name":"l","devices":[{"name":"d","address":"0x10","status":null,)"
              R"("$from":0}],"x":["1","a"],"$from":0}]})");
}

TEST(DocumentJson, ComesBackWithItsQuotes) {
    const auto root = root_of(kText);
    auto again = document_of(document_json(root), &root);
    ASSERT_TRUE(again);
    EXPECT_TRUE(same_document(*again, root));
    without_origins(*again);
    const auto* const name = again->find("lines")->items[0].find("name");
    EXPECT_EQ(outline(*name), "\"l\"@0:0");  // a draft has no lines
    // A changed text has no quotes.
    const auto changed = document_of(
        Json::parse(R"({"lines":[{"$from":0,"name":"m","devices":[{"name":"e","address":7,"used":true}]}]})")
            .value(),
        &root);
    EXPECT_EQ(outline(*changed->find("lines")->items[0].find("name")), "m@0:0");
    EXPECT_EQ(outline(*changed->find("lines")->items[0].find("devices")->items[0].find("address")), "7@0:0");
    EXPECT_EQ(changed->find("lines")->items[0].find("devices")->items[0].find("used")->text, "true");
}

TEST(DocumentJson, AReferenceCountsAsQuoted) {
    const auto root = document_of(
        Json::parse(R"({"lines":[{"devices":[{"variables":[{"reference":"40001","register":"1"}]}]}]})")
            .value(),
        nullptr);
    const auto& variable =
        root->find("lines")->items[0].find("devices")->items[0].find("variables")->items[0];
    EXPECT_TRUE(variable.find("reference")->quoted);
    EXPECT_FALSE(variable.find("register")->quoted);
}

TEST(DocumentJson, HasTheLimitsOfFiles) {
    std::string deep = "1";
    for (std::size_t i = 0; i <= kMaxDepth; ++i) deep = "[" + deep + "]";
    EXPECT_EQ(document_of(Json::parse(deep).value(), nullptr).error().code, Code::too_long);
    auto many = Json::object();
    Json::Object keys;
    for (std::size_t i = 0; i <= kMaxEditedKeys; ++i) keys.emplace_back("k" + std::to_string(i), Json());
    EXPECT_EQ(document_of(Json(std::move(keys)), nullptr).error().code, Code::too_long);
}

}  // namespace document_json_test
}  // namespace takt::file
