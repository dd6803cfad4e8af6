// The example projects are without a finding and are written as they are read, and the scenarios of
// docs/specification.md, section 5, give their counts.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "takt/file/convert.hpp"
#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/plan/plan.hpp"

namespace takt {
namespace examples_test {

struct Example {
    std::string_view file;
    std::size_t requests;
    std::size_t ungrouped;
};

class Examples : public testing::TestWithParam<Example> {};

TEST_P(Examples, AreGoodProjects) {
    const auto loaded = file::load_project(std::string(TAKT_EXAMPLES "/").append(GetParam().file));
    ASSERT_TRUE(loaded.readable);
    const auto checked = model::interpret(loaded.document);
    for (const auto& findings : {loaded.findings, checked.findings})
        for (const auto& finding : findings)
            ADD_FAILURE() << finding.location.line << ":" << finding.location.column << " " << finding.path
                          << " " << finding.code;
    const auto plan = plan::make_plan(checked.project);
    ASSERT_EQ(plan.lines.size(), 1U);
    EXPECT_EQ(plan.lines[0].request_count, GetParam().requests);
    EXPECT_EQ(plan.lines[0].ungrouped_requests, GetParam().ungrouped);
}

INSTANTIATE_TEST_SUITE_P(All, Examples,
                         testing::Values(Example{"scenario-1.yaml", 1, 10},
                                         Example{"scenario-2.yaml", 10, 10}, Example{"scenario-3.yaml", 4, 6},
                                         Example{"boiler.yaml", 6, 7}, Example{"meters.yaml", 4, 12},
                                         Example{"demo.yaml", 6, 16}, Example{"tank-farm.yaml", 7, 10},
                                         Example{"gateway.yaml", 2, 2}, Example{"converter.yaml", 2, 3},
                                         Example{"mqtt.yaml", 1, 2}),
                         [](const auto& example) {
                             std::string name(example.param.file.substr(0, example.param.file.find('.')));
                             for (auto& c : name)
                                 if (c == '-') c = '_';
                             return name;
                         });

/// The contents of a document, without locations and quotes.
std::string shape(const model::Node& node) {
    std::string text;
    switch (node.kind) {
        case model::Node::Kind::null: return "~";
        case model::Node::Kind::scalar: return '"' + node.text + '"';
        case model::Node::Kind::list:
            for (const auto& item : node.items) text += shape(item) + ',';
            return '[' + text + ']';
        case model::Node::Kind::mapping:
            for (const auto& [key, value] : node.entries) text += key.text + ':' + shape(value) + ',';
            return '{' + text + '}';
    }
    return text;
}

TEST(ExampleFiles, AreWrittenAsTheyAreRead) {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(TAKT_EXAMPLES)) {
        if (entry.path().extension() != ".yaml") continue;
        ++count;
        const auto read = file::load_project(entry.path().string());
        ASSERT_TRUE(read.readable) << entry.path();
        EXPECT_TRUE(model::interpret(read.document).findings.empty()) << entry.path();
        const auto written = file::write_project(read.document.root);
        const auto again = file::load_text("written.yaml", written);
        EXPECT_TRUE(again.findings.empty()) << entry.path() << '\n' << written;
        EXPECT_EQ(shape(again.document.root), shape(read.document.root)) << entry.path() << '\n' << written;
    }
    EXPECT_GE(count, 10U);
}

}  // namespace examples_test
}  // namespace takt
