// Loading a project: its findings, what was learnt of its devices, and the files beside it.
#include "takt/host/project_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "folder.hpp"
#include "takt/file/learnt.hpp"
#include "takt/file/read.hpp"

namespace takt::host {
namespace project_file_test {

constexpr const char* kLearning = R"(takt: 1
lines:
  - name: main
    transport: simulated
    framing: rtu
    devices:
      - name: Boiler
        address: 1
        poll_period: 100ms
        strategy: optimal
        gaps: learn
        variables:
          - {name: Level, type: int, register: 0, read: 0x03}
          - {name: Speed, type: int, register: 2, read: 0x03}
)";

std::size_t count_of(const LoadedFile& loaded, std::string_view code) {
    return static_cast<std::size_t>(
        std::ranges::count_if(loaded.findings, [&](const auto& finding) { return finding.code == code; }));
}

TEST(ProjectFile, ATextWithoutErrorsGivesItsProject) {
    const auto loaded = load_project_text("plant.yaml", kLearning);
    EXPECT_FALSE(loaded.has_errors());
    ASSERT_EQ(loaded.project.lines.size(), 1U);
    EXPECT_EQ(loaded.files, std::vector<std::string>{"plant.yaml"});
}

TEST(ProjectFile, FilesOfOutputsAreChecked) {
    namespace fs = std::filesystem;
    const takt::test::Folder folder;
    const auto path = folder / "plant.yaml";
    const auto findings_of = [&] {
        auto loaded = load_project_text(
            "plant.yaml", std::string(kLearning) +
                              "outputs:\n  - {name: o, transport: mqtt, brokers: [mqtts://b], user: u, "
                              "password_file: secret, ca_file: ca.pem}\n");
        EXPECT_TRUE(loaded.findings.empty());
        check_output_files(loaded, path);
        std::string all;
        for (const auto& finding : loaded.findings) all += finding.code + ' ' + finding.path + '\n';
        return all;
    };
    EXPECT_EQ(findings_of(),
              "output.file_missing outputs[0].password_file\n"
              "output.file_missing outputs[0].ca_file\n");
    folder.write("secret", "x\n");
    fs::permissions(folder / "secret", fs::perms::owner_read | fs::perms::others_read);
    fs::create_directory(folder / "ca.pem");
    EXPECT_EQ(findings_of(),
              "output.file_exposed outputs[0].password_file\n"
              "output.file_unreadable outputs[0].ca_file\n");
    fs::permissions(folder / "secret", fs::perms::owner_read);
    fs::remove(folder / "ca.pem");
    folder.write("ca.pem", "x\n");
    EXPECT_EQ(findings_of(), "");
}

struct OutputFileCase {
    std::string_view key;
    std::string_view name;
    std::string_view code;  // empty: no finding
    std::string_view allowed;
};

// The program that reads a FIFO would wait, and a device may have no end.
TEST(ProjectFile, FilesOfOutputsAreRegularAndHaveALimit) {
    namespace fs = std::filesystem;
    const takt::test::Folder folder;
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    ASSERT_EQ(::mkfifo((folder / "open").c_str(), 0644), 0);
    fs::permissions(folder / "open", fs::perms::owner_read | fs::perms::others_read);
    fs::create_symlink("fifo", folder / "link");
    const auto write = [&](const std::string& name, std::size_t size) {
        folder.write(name, std::string(size, 'x'));
        fs::permissions(folder / name, fs::perms::owner_read);
    };
    write("largest", file::kMaxSecretBytes);
    write("long", file::kMaxSecretBytes + 1);
    write("bundle", file::kMaxCertificateBytes);
    write("long_bundle", file::kMaxCertificateBytes + 1);
    constexpr auto kIrregular = "output.file_irregular";
    constexpr auto kTooLong = "output.file_too_long";
    const OutputFileCase cases[] = {
        {"password_file", "fifo", kIrregular, ""},
        {"password_file", "open", kIrregular, ""},
        {"password_file", "link", kIrregular, ""},
        {"password_file", "/dev/zero", kIrregular, ""},
        {"password_file", "long", kTooLong, "0..65536"},
        {"password_file", "largest", "", ""},
        {"key_file", "open", kIrregular, ""},
        {"key_file", "long", kTooLong, "0..65536"},
        {"ca_file", "fifo", kIrregular, ""},
        {"ca_file", "long_bundle", kTooLong, "0..4194304"},
        {"ca_file", "bundle", "", ""},
        {"certificate_file", "/dev/null", kIrregular, ""},
        {"certificate_file", "long_bundle", kTooLong, "0..4194304"},
    };
    for (const auto& [key, name, code, allowed] : cases) {
        LoadedProject loaded;
        auto& mqtt = loaded.project.outputs.emplace_back().mqtt;
        (key == "password_file" ? mqtt.password_file
         : key == "key_file"    ? mqtt.key_file
         : key == "ca_file"     ? mqtt.ca_file
                                : mqtt.certificate_file) = name;
        check_output_files(loaded, folder / "plant.yaml");
        const auto context = std::string(key) + ' ' + std::string(name);
        ASSERT_EQ(loaded.findings.size(), code.empty() ? 0U : 1U) << context;
        if (code.empty()) continue;
        const auto& finding = loaded.findings.front();
        EXPECT_EQ(finding.code, code) << context;
        EXPECT_EQ(finding.path, "outputs[0]." + std::string(key));
        EXPECT_EQ(finding.value, (fs::path(folder / "") / name).string()) << context;
        EXPECT_EQ(finding.allowed, allowed) << context;
    }
}

TEST(ProjectFile, AnUnsetEnvironmentVariableOfAPasswordIsAWarning) {
    const auto findings_of = [](const std::string& variable) {
        auto loaded = load_project_text(
            "plant.yaml", std::string(kLearning) +
                              "outputs:\n  - {name: o, transport: mqtt, brokers: [mqtts://b], user: u, "
                              "password_env: " +
                              variable + "}\n");
        check_output_files(loaded, "plant.yaml");
        std::string all;
        for (const auto& finding : loaded.findings)
            all += finding.code + ' ' + finding.path + '=' + finding.value;
        return all;
    };
    EXPECT_EQ(findings_of("TAKT_NO_SUCH_VARIABLE"),
              "output.variable_unset outputs[0].password_env=TAKT_NO_SUCH_VARIABLE");
    EXPECT_EQ(findings_of("PATH"), "");
}

TEST(ProjectFile, FindingsAreInTheOrderOfTheText) {
    std::string text = kLearning;
    text += "          - {name: Bad, type: nonsense, register: 5, read: 0x03}\nlocals: 5\nunknown_key: 1\n";
    const auto loaded = load_project_text("plant.yaml", text);
    EXPECT_TRUE(loaded.has_errors());
    EXPECT_TRUE(loaded.readable);
    ASSERT_GE(loaded.findings.size(), 3U);
    EXPECT_TRUE(std::ranges::is_sorted(loaded.findings, {},
                                       [](const auto& finding) { return finding.location.line; }));
}

TEST(ProjectFile, WhatIsNoDocumentIsUnreadable) {
    const auto loaded = load_project_text("plant.yaml", "lines: [");
    EXPECT_FALSE(loaded.readable);
    EXPECT_TRUE(loaded.has_errors());
    EXPECT_FALSE(load_project("/dev/null/plant.yaml").readable);
    EXPECT_TRUE(load_access("/dev/null/rules.yaml").has_errors());
}

TEST(ProjectFile, AddsTheFindingsOfTheGuarantees) {
    auto loaded = load_project_text("plant.yaml", kLearning);
    const auto before = loaded.findings.size();
    plan::Proof proof;
    proof.findings.emplace_back().code = "some.finding";
    add_findings(loaded, proof);
    EXPECT_EQ(loaded.findings.size(), before + 1);
    EXPECT_EQ(count_of(loaded, "some.finding"), 1U);
}

TEST(ProjectFile, FilesBesideAProjectHaveItsName) {
    EXPECT_EQ(learnt_path("a/plant.yaml"), "a/plant.learnt.json");
    EXPECT_EQ(default_state_path("a/plant.yaml"), "a/plant.state");
    EXPECT_EQ(default_state_path("plant"), "plant.state");
}

class FolderTest : public testing::Test {
protected:
    std::string put(const std::string& name, const std::string& text) const {
        folder.write(name, text);
        return folder / name;
    }
    takt::test::Folder folder;
};

TEST_F(FolderTest, AProfileReplacesThatOfTheFile) {
    const auto path = put("plant.yaml", std::string(kLearning) + "profile: generic\n");
    EXPECT_EQ(load_project(path).project.profile, model::Profile::generic);
    EXPECT_EQ(load_project(path, model::Profile::owen_kc1).project.profile, model::Profile::owen_kc1);
}

// 99 is a mark that no planner makes.
TEST_F(FolderTest, AProjectOfTheControllerIsPlannedOnce) {
    const auto path = put("plant.yaml", std::string(kLearning));
    EXPECT_FALSE(load_project(path).plan) << "generic: the plan is made with its proof";
    EXPECT_EQ(prove(load_project(path), false, false).plan.lines.size(), 1U);
    auto loaded = load_project(path, model::Profile::owen_kc1);
    ASSERT_TRUE(loaded.plan);
    loaded.plan->lines[0].ungrouped_requests = 99;
    EXPECT_EQ(prove(loaded, false, false).plan.lines[0].ungrouped_requests, 99U);
    put("plant.learnt.json", R"({"takt_learnt": 1, "lines": []})");
    (void)recall_learnt(loaded, path);
    EXPECT_FALSE(loaded.plan) << "what was learnt may change it";
    EXPECT_NE(prove(loaded, false, false).plan.lines[0].ungrouped_requests, 99U);
}

TEST_F(FolderTest, ReadsAListOfAccessRules) {
    const auto loaded = load_access(put("rules.yaml", "- {peers: [127.0.0.1], rule: allow}\n"));
    EXPECT_FALSE(loaded.has_errors());
    EXPECT_EQ(loaded.rules.size(), 1U);
    EXPECT_TRUE(load_access(put("bad.yaml", "- {peers: [nowhere], rule: allow}\n")).has_errors());
}

TEST_F(FolderTest, WhatWillBeLearntGoesBesideAProjectWithLines) {
    const auto path = put("plant.yaml", kLearning);
    auto loaded = load_project(path);
    EXPECT_EQ(recall_learnt(loaded, path), folder / "plant.learnt.json");
    EXPECT_EQ(loaded.files.size(), 1U);
    loaded.project.lines[0].devices[0].gaps = model::Gaps::never;
    EXPECT_EQ(recall_learnt(loaded, path), folder / "plant.learnt.json") << "a device may be late";
    loaded.project.lines.clear();
    EXPECT_EQ(recall_learnt(loaded, path), "");
}

TEST_F(FolderTest, ADeviceThatWasLaterThanTheProjectAllowsIsAWarning) {
    const auto path = put("plant.yaml", kLearning);
    auto loaded = load_project(path);
    auto& device = loaded.project.lines[0].devices[0];
    std::vector<std::vector<model::LearntTimes>> times(1);
    times[0].push_back(
        {.measured = {.attempts = 300,
                      .late = 7,
                      .lateness = std::chrono::milliseconds(412),
                      .next_latest = {{std::chrono::milliseconds(180), std::chrono::milliseconds(120)}}}});
    folder.write("plant.learnt.json", file::learnt_text(loaded.project, {{model::Learnt{}}}, times, {}));
    device.response_timeout = std::chrono::milliseconds(100);
    device.response_timeout_set = true;
    EXPECT_EQ(recall_learnt(loaded, path), folder / "plant.learnt.json");
    ASSERT_EQ(count_of(loaded, "learnt.late"), 1U);
    const auto& finding = loaded.findings.back();
    EXPECT_EQ(finding.severity, model::Severity::warning);
    EXPECT_EQ(finding.value, "412 ms");
    EXPECT_EQ(finding.arguments[1].second, "response_timeout");
    EXPECT_EQ(finding.arguments[3].second, "150ms") << "from the third longest";
    EXPECT_EQ(finding.arguments[4].second, "7");
    EXPECT_EQ(finding.arguments[5].second, "2") << "would be late with it, too";
    EXPECT_EQ(finding.arguments.size(), 6U);
    loaded.findings.clear();
    times[0][0].measured.next_latest = {{std::chrono::milliseconds(410), std::chrono::milliseconds(410)}};
    folder.write("plant.learnt.json", file::learnt_text(loaded.project, {{model::Learnt{}}}, times, {}));
    EXPECT_EQ(recall_learnt(loaded, path), folder / "plant.learnt.json");
    EXPECT_EQ(loaded.findings.back().arguments.back().second, "none_later");
    loaded.findings.clear();
    device.response_timeout = std::chrono::milliseconds(420);
    EXPECT_EQ(recall_learnt(loaded, path), folder / "plant.learnt.json");
    EXPECT_TRUE(loaded.findings.empty());
}

TEST_F(FolderTest, AFileThatCannotBeUsedIsAWarningAndIsNotOverwritten) {
    const auto path = put("plant.yaml", kLearning);
    folder.write("plant.learnt.json", "no JSON");
    auto loaded = load_project(path);
    const auto before = loaded.findings.size();
    EXPECT_EQ(recall_learnt(loaded, path), "");
    EXPECT_GT(loaded.findings.size(), before);
    EXPECT_FALSE(loaded.has_errors());
    EXPECT_EQ(loaded.files.back(), folder / "plant.learnt.json");
}

TEST_F(FolderTest, AFolderInPlaceOfTheFileIsAWarning) {
    const auto path = put("plant.yaml", kLearning);
    std::filesystem::create_directory(folder / "plant.learnt.json");
    auto loaded = load_project(path);
    EXPECT_EQ(recall_learnt(loaded, path), "");
    EXPECT_EQ(count_of(loaded, "learnt.unreadable"), 1U);
}

}  // namespace project_file_test
}  // namespace takt::host
