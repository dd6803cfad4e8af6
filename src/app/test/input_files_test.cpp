// Files of the user that a command reads: what is wrong with them goes to stderr.
#include "offline/input_files.hpp"

#include <gtest/gtest.h>

#include <string>

#include "folder.hpp"
#include "takt/table/format.hpp"

namespace takt::app {
namespace input_files_test {

const std::string kServer = R"(takt: 1
servers:
  - name: gate
    listen: 127.0.0.1
    tcp_port: 1502
    units: [{address: 1, banks: [{area: holding_register, items: [0..9]}]}]
)";

class InputFilesTest : public testing::Test {
protected:
    std::string put(const std::string& name, const std::string& text) {
        folder_.write(name, text);
        return folder_ / name;
    }
    /// Calls with stderr captured in `printed_`.
    template <class Call>
    auto quietly(Call call) {
        testing::internal::CaptureStderr();
        auto result = call();
        printed_ = testing::internal::GetCapturedStderr();
        return result;
    }

    const takt::test::Folder folder_;
    const Texts texts_{text::Language::english};
    std::string printed_;
};

TEST_F(InputFilesTest, OnlyAProjectWithoutErrorsIsRun) {
    const struct {
        const char* text;
        const char* printed;
    } cases[] = {
        {"takt: 1\nlines: many\n", "lines"},
        {"takt: 1\nlines:\n  - {name: l, transport: serial, port: /dev/ttyS1, baud: 7}\n", "baud"},
        {"takt: [", "plant.yaml:"},
        {"", "plant.yaml"},
    };
    for (const auto& [text, printed] : cases) {
        SCOPED_TRACE(text);
        const auto path = put("plant.yaml", text);
        EXPECT_FALSE(quietly([&] { return load_to_run(texts_, path); }));
        EXPECT_NE(printed_.find(printed), std::string::npos) << printed_;
        EXPECT_NE(printed_.find("error: "), std::string::npos) << printed_;
    }
    const auto good = put("plant.yaml", kServer);
    const auto loaded = quietly([&] { return load_to_run(texts_, good); });
    ASSERT_TRUE(loaded) << printed_;
    EXPECT_EQ(loaded->project.servers.size(), 1U);
    EXPECT_EQ(printed_, "");
    EXPECT_FALSE(quietly([&] { return load_to_run(texts_, folder_ / "missing.yaml"); }));
    EXPECT_NE(printed_.find("missing.yaml"), std::string::npos);
}

TEST_F(InputFilesTest, TheFileOfWhatWasLearntIsBesideTheProject) {
    std::string learnt;
    const auto path = put("plant.yaml", R"(takt: 1
lines:
  - name: l
    transport: simulated
    devices:
      - name: d
        address: 1
        strategy: optimal
        gaps: learn
        poll_period: 1s
        variables: [{name: a, type: int16, register: 0, read: 0x03}]
)");
    ASSERT_TRUE(quietly([&] { return load_to_run(texts_, path, &learnt); })) << printed_;
    EXPECT_EQ(learnt, host::learnt_path(path));
    const auto plain = put("plain.yaml", kServer);
    ASSERT_TRUE(quietly([&] { return load_to_run(texts_, plain, &learnt); })) << printed_;
    EXPECT_EQ(learnt, "") << "nothing learns";
}

TEST_F(InputFilesTest, AccessRulesAreReadFromAFileOfTheirOwn) {
    const auto good = put("rules.yaml", "- {functions: [read], rule: allow}\n");
    const auto rules = quietly([&] { return load_access(texts_, good); });
    ASSERT_TRUE(rules) << printed_;
    EXPECT_EQ(rules->size(), 1U);
    const auto bad = put("rules.yaml", "- {functions: [read], rule: perhaps}\n");
    EXPECT_FALSE(quietly([&] { return load_access(texts_, bad); }));
    EXPECT_NE(printed_.find("perhaps"), std::string::npos) << printed_;
}

TEST_F(InputFilesTest, RulesThatCannotBeUsedLeaveThoseInForce) {
    const auto kept = "takt: " + texts_("app.access.kept", {{"file", folder_ / "plant.yaml"}}) + '\n';
    const struct {
        std::string text;
        bool fits;
        int asked;
        bool reported;
    } cases[] = {
        {kServer, true, 1, false}, {kServer, false, 1, true}, {"takt: 1\nserver: []\n", true, 0, true}};
    for (const auto& [text, fits, asked, reported] : cases) {
        const auto path = put("plant.yaml", text);
        int calls = 0;
        (void)quietly([&] {
            reload_access(texts_, path, [&, answer = fits](const model::Project&) {
                ++calls;
                return answer;
            });
            return true;
        });
        EXPECT_EQ(calls, asked);
        EXPECT_EQ(printed_.ends_with(kept), reported) << printed_;
    }
}

TEST_F(InputFilesTest, ATableIsOfTheControllerByItsFirstBytes) {
    const std::string owen(table::kOwenMagic);
    const struct {
        std::string bytes;
        bool owen;
    } cases[] = {
        {owen + "rest", true}, {owen.substr(1), false}, {"", false}, {std::string("\0\xFF", 2), false}};
    for (const auto& [bytes, is_owen] : cases) {
        const auto path = put("p.takt", bytes);
        const auto file = quietly([&] { return read_table_file(texts_, path); });
        ASSERT_TRUE(file) << printed_;
        EXPECT_EQ(file->owen, is_owen);
        EXPECT_EQ(std::string(file->image.begin(), file->image.end()), bytes);
    }
    EXPECT_FALSE(quietly([&] { return read_table_file(texts_, folder_ / "missing"); }));
    EXPECT_NE(printed_.find("missing"), std::string::npos) << printed_;
    const auto huge = put("huge", std::string(table::kMaxImage + 1, 'x'));
    EXPECT_FALSE(quietly([&] { return read_table_file(texts_, huge); }));
}

}  // namespace input_files_test
}  // namespace takt::app
