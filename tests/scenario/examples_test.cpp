// The example projects are without a finding, and the scenarios of requirements, section 5, give their
// counts.
#include <gtest/gtest.h>

#include <string>

#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/plan/plan.hpp"

namespace takt {
namespace {

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
            ADD_FAILURE() << finding.place.line << ":" << finding.place.column << " " << finding.path << " "
                          << finding.code;
    const auto plan = plan::make_plan(checked.project);
    ASSERT_EQ(plan.lines.size(), 1U);
    EXPECT_EQ(plan.lines[0].request_count, GetParam().requests);
    EXPECT_EQ(plan.lines[0].ungrouped_requests, GetParam().ungrouped);
}

INSTANTIATE_TEST_SUITE_P(All, Examples,
                         testing::Values(Example{"scenario-1.yaml", 1, 10},
                                         Example{"scenario-2.yaml", 10, 10}, Example{"scenario-3.yaml", 4, 6},
                                         Example{"boiler.yaml", 6, 7}, Example{"meters.yaml", 4, 12},
                                         Example{"demo.yaml", 7, 13}, Example{"tank-farm.yaml", 7, 10}),
                         [](const auto& example) {
                             std::string name(example.param.file.substr(0, example.param.file.find('.')));
                             for (auto& c : name)
                                 if (c == '-') c = '_';
                             return name;
                         });

}  // namespace
}  // namespace takt
