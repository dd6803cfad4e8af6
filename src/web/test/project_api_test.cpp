#include "takt/web/project_api.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <thread>

#include "folder.hpp"
#include "takt/file/json.hpp"

namespace takt::web {
namespace project_api_test {

using file::Json;

constexpr const char* kProject =
    "# the plant\ntakt: 1\nlines:\n  - name: bus       # the only one\n    transport: simulated\n    "
    "devices:\n"
    "      - name: Boiler\n        address: 16\n        poll_period: 1s\n        variables:\n"
    "          - {name: Level, type: float, register: 0, read: 0x03}\n"
    "          - {name: Pump, type: bool, register: 8, bit: 0, read: 0x01}\n";

class ProjectApiTest : public testing::Test {
protected:
    void SetUp() override {
        folder_.write("plant.yaml", kProject);
        make({});
    }

    void make(std::function<Result<void>(host::LoadedProject)> apply) {
        api_.emplace(ProjectApiOptions{file_, std::move(apply)});
        routes_ = api_->routes();
    }

    ApiResponse call(Method method, std::string_view path, const Json& body = {},
                     const std::multimap<std::string, std::string, std::less<>>& query = {}) {
        const ApiRequest request{.query = query, .body = body.dump(), .texts = texts_, .peer = "127.0.0.1"};
        for (const auto& route : routes_)
            if (route.method == method && route.path == path) return route.handler(request);
        return ApiResponse::error(404, "test", std::string(path));
    }
    Json project() { return Json::parse(call(Method::get, "/project").body, std::size_t{8} << 20).value(); }
    static Json body_of(Json document, const Json& revision = {}) {
        auto body = Json::object();
        body.set("document", std::move(document));
        body.set("revision", revision);
        body.set("apply", true);
        return body;
    }
    static std::string text_at(const Json& json, std::initializer_list<std::string_view> keys) {
        const Json* at = &json;
        for (const auto key : keys) {
            at = at->find(key);
            if (at == nullptr) return "none";
        }
        const auto* const text = std::get_if<std::string>(&at->value());
        return text == nullptr ? at->dump() : *text;
    }
    /// The document with another text for the first place where `old_text` is.
    static Json changed(const Json& document, const std::string& old_text, const std::string& new_text) {
        auto text = document.dump();
        const auto at = text.find(old_text);
        EXPECT_NE(at, std::string::npos) << text;
        return Json::parse(text.replace(at, old_text.size(), new_text)).value();
    }
    static std::string code_of(const ApiResponse& response) {
        return std::to_string(response.status) + " " +
               text_at(Json::parse(response.body, std::size_t{8} << 20).value(), {"error", "code"});
    }

    const takt::test::Folder folder_;
    const std::string file_ = folder_ / "plant.yaml";
    const report::Texts texts_{text::Language::english};
    std::optional<ProjectApi> api_;
    std::vector<ApiRoute> routes_;
};

TEST_F(ProjectApiTest, GivesTheFileAsADocument) {
    const auto answer = project();
    EXPECT_EQ(text_at(answer, {"file"}), file_);
    EXPECT_EQ(text_at(answer, {"document", "takt"}), "1");
    EXPECT_EQ(text_at(answer, {"findings"}).find("error"), std::string::npos) << answer.dump();
    EXPECT_EQ(text_at(answer, {"read_only_parts"}), "[]");
    folder_.write("plant.yaml", "takt: [1\n");
    const auto broken = project();
    EXPECT_EQ(text_at(broken, {"document"}), "null");
    EXPECT_NE(text_at(broken, {"findings"}).find("file.unclosed_bracket"), std::string::npos);
    std::filesystem::remove(file_);
    EXPECT_EQ(call(Method::get, "/project").status, 500);
}

TEST_F(ProjectApiTest, EvaluatesADocumentWithoutSavingIt) {
    const auto document = *project().find("document");
    const auto answer = call(Method::post, "/project/evaluate", body_of(document));
    ASSERT_EQ(answer.status, 200) << answer.body;
    const auto plan = Json::parse(answer.body, std::size_t{8} << 20).value();
    EXPECT_NE(text_at(plan, {"lines"}).find("\"Level\""), std::string::npos);
    EXPECT_NE(text_at(plan, {"lines"}).find("\"compare\""), std::string::npos);
    EXPECT_NE(plan.find("took_ms"), nullptr);
    EXPECT_EQ(text_at(plan, {"courses"}),
              R"([{"length_ms":1000.0,"bars":[[0,0.0,15026.042,false],[1,15026.042,31770.834,false]]}])");
    const auto wrong =
        call(Method::post, "/project/evaluate", body_of(changed(document, R"("16")", R"("300")")));
    ASSERT_EQ(wrong.status, 200);
    EXPECT_NE(wrong.body.find("lines[0].devices[0].address"), std::string::npos) << wrong.body;
    EXPECT_NE(wrong.body.find("\"line\":0"), std::string::npos) << wrong.body;  // of no file yet
    const auto twice =
        call(Method::post, "/project/evaluate", body_of(changed(document, R"("Pump")", R"("Level")")));
    EXPECT_NE(twice.body.find("already used: bus, Boiler, Level"), std::string::npos) << twice.body;
    EXPECT_EQ(folder_.read("plant.yaml"), kProject);
}

TEST_F(ProjectApiTest, JudgesAnUnknownResponseTimeAsCheckDoes) {
    std::string text =
        "takt: 1\nlines:\n  - name: net\n    transport: tcp\n    host: 127.0.0.1\n    devices:\n"
        "      - name: Meter\n        address: 7\n        poll_period: 100ms\n        variables:\n";
    for (int i = 0; i < 10; ++i)
        text +=
            fmt::format("          - {{name: V{0}, type: int16, register: {1}, read: 0x03}}\n", i, 200 * i);
    folder_.write("plant.yaml", text);
    const auto answer = call(Method::post, "/project/evaluate", body_of(*project().find("document")));
    const auto judged = Json::parse(answer.body, std::size_t{8} << 20).value();
    const auto& findings = std::get<Json::Array>(judged.find("findings")->value());
    ASSERT_EQ(findings.size(), 1U) << answer.body;
    EXPECT_EQ(text_at(findings[0], {"severity"}), "note");
    EXPECT_EQ(text_at(findings[0], {"code"}), "guarantee.response_unknown");
    EXPECT_NE(text_at(judged, {"lines"}).find(R"("verdict":"response_unknown")"), std::string::npos);
}

TEST_F(ProjectApiTest, TheRequestsOfADraftAreFiles) {
    const auto document = *project().find("document");
    const auto as = [&](const std::string& format, const Json& sent) {
        return call(Method::post, "/project/evaluate", body_of(sent), {{"as", format}});
    };
    const auto csv = as("csv", document);
    EXPECT_EQ(csv.file_name, "plant.requests.csv");
    EXPECT_TRUE(csv.body.starts_with("line,device,unit,function,write_function,start,quantity,variables,"))
        << csv.body;
    EXPECT_NE(csv.body.find("\r\nbus,Boiler,16,3,,0,2,Level,2143,1000.0,"), std::string::npos) << csv.body;
    const auto svg = as("svg", document);
    EXPECT_EQ(svg.file_name, "plant.requests.svg");
    EXPECT_NE(svg.body.find("<svg"), std::string::npos);
    const auto json = Json::parse(as("json", document).body);
    ASSERT_TRUE(json.has_value());
    EXPECT_NE(json->find("lines"), nullptr);
    EXPECT_EQ(as("xml", document).status, 400);
    EXPECT_EQ(as("csv", changed(document, R"("16")", R"("300")")).status, 422) << "it has no requests";
}

TEST_F(ProjectApiTest, AnEvaluationThatIsToStopEnds) {
    std::stop_source stop;
    stop.request_stop();
    const ApiRequest request{.query = {},
                             .body = body_of(*project().find("document")).dump(),
                             .texts = texts_,
                             .peer = "127.0.0.1",
                             .stop = stop.get_token()};
    const auto evaluate = std::ranges::find(routes_, "/project/evaluate", &ApiRoute::path);
    EXPECT_EQ(code_of(evaluate->handler(request)), "409 superseded");
    EXPECT_EQ(evaluate->work, Work::planning);
    EXPECT_TRUE(evaluate->newest_only);
}

TEST_F(ProjectApiTest, ShowsTheDifference) {
    const auto loaded = project();
    const auto wanted = changed(*loaded.find("document"), R"("poll_period":"1s")", R"("poll_period":"2s")");
    const auto answer = call(Method::post, "/project/diff", body_of(wanted, *loaded.find("revision")));
    ASSERT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(
        text_at(Json::parse(answer.body).value(), {"diff"}),
        "--- plant.yaml\n+++ plant.yaml\n@@ -6,7 +6,7 @@\n     devices:\n       - name: Boiler\n"
        "         address: 16\n-        poll_period: 1s\n+        poll_period: 2s\n         variables:\n"
        "           - {name: Level, type: float, register: 0, read: 0x03}\n"
        "           - {name: Pump, type: bool, register: 8, bit: 0, read: 0x01}\n");
}

TEST_F(ProjectApiTest, SavesKeepsTheOldFileAndApplies) {
    std::vector<std::string> applied;
    make([&](const host::LoadedProject& loaded) -> Result<void> {
        applied.push_back(loaded.project.lines[0].devices[0].name);
        return {};
    });
    const auto loaded = project();
    const auto wanted = changed(*loaded.find("document"), "Boiler", "Kettle");
    const auto answer = call(Method::put, "/project", body_of(wanted, *loaded.find("revision")));
    ASSERT_EQ(answer.status, 200) << answer.body;
    const auto saved = Json::parse(answer.body).value();
    EXPECT_EQ(text_at(saved, {"applied"}), "true");
    EXPECT_EQ(text_at(saved, {"backup"}), file_ + "~");
    EXPECT_EQ(applied, std::vector<std::string>{"Kettle"});
    std::string expected = kProject;
    expected.replace(expected.find("Boiler"), 6, "Kettle");
    EXPECT_EQ(folder_.read("plant.yaml"), expected);
    EXPECT_EQ(folder_.read("plant.yaml~"), kProject);
    EXPECT_EQ(text_at(project(), {"revision"}), text_at(saved, {"revision"}));
    // A second save with the old revision would undo the first one.
    EXPECT_EQ(code_of(call(Method::put, "/project", body_of(wanted, *loaded.find("revision")))),
              "409 changed_on_disk");
}

TEST_F(ProjectApiTest, KeepsTheModeInTheBackup) {
    ASSERT_EQ(::chmod(file_.c_str(), 0600), 0);
    const auto loaded = project();
    const auto wanted = changed(*loaded.find("document"), "Boiler", "Kettle");
    ASSERT_EQ(call(Method::put, "/project", body_of(wanted, *loaded.find("revision"))).status, 200);
    constexpr std::filesystem::perms kOwnerOnly{0600};
    EXPECT_EQ(std::filesystem::status(file_).permissions(), kOwnerOnly);
    EXPECT_EQ(std::filesystem::status(file_ + "~").permissions(), kOwnerOnly);
}

TEST_F(ProjectApiTest, ReportsAnApplicationThatFails) {
    make([](const host::LoadedProject&) -> Result<void> { return fail(Code::cannot_open, "port", 2); });
    const auto loaded = project();
    const auto wanted = changed(*loaded.find("document"), "Boiler", "Kettle");
    const auto saved =
        Json::parse(call(Method::put, "/project", body_of(wanted, *loaded.find("revision"))).body).value();
    EXPECT_EQ(text_at(saved, {"applied"}), "false");
    EXPECT_NE(text_at(saved, {"apply_error"}).find("port"), std::string::npos);
}

TEST_F(ProjectApiTest, SavesNoErrors) {
    const auto loaded = project();
    const auto wanted = changed(*loaded.find("document"), R"("16")", R"("300")");
    const auto answer = call(Method::put, "/project", body_of(wanted, *loaded.find("revision")));
    EXPECT_EQ(code_of(answer), "422 findings");
    EXPECT_NE(answer.body.find("lines[0].devices[0].address"), std::string::npos);
    EXPECT_EQ(folder_.read("plant.yaml"), kProject);
    EXPECT_FALSE(std::filesystem::exists(file_ + "~"));
}

TEST_F(ProjectApiTest, RefusesWhatIsNoRequest) {
    EXPECT_EQ(code_of(call(Method::put, "/project", Json::array())), "400 malformed");
    EXPECT_EQ(code_of(call(Method::post, "/project/evaluate", body_of(Json(1)))), "200 none");
    const auto loaded = project();
    const auto wanted = changed(*loaded.find("document"), R"("$from":0)", R"("$from":7)");
    EXPECT_EQ(code_of(call(Method::put, "/project",
                           body_of(changed(wanted, "Level", "x"), *loaded.find("revision")))),
              "422 origin");
    api_.emplace(ProjectApiOptions{});
    routes_ = api_->routes();
    EXPECT_EQ(code_of(call(Method::get, "/project")), "404 none");
}

TEST_F(ProjectApiTest, KeepsPartsOfOtherFiles) {
    folder_.write("a.csv", "name,type,register,read\nA,int16,1,0x03\n");
    folder_.write("t.yaml",
                  "takt: 1\nparameters: {}\npoll_period: 5s\nvariables:\n"
                  "  - {name: T, type: int16, register: 5, read: 0x03}\n");
    folder_.write("plant.yaml",
                  "takt: 1\nlines:\n  - name: bus\n    transport: simulated\n    devices:\n"
                  "      - {name: D, address: 1, variables: a.csv}\n"
                  "      - {name: E, address: 2, device_template: t.yaml, variables: [{name: X, type: int16, "
                  "register: 70000, read: 0x03}]}\n");
    const auto loaded = project();
    const auto parts = text_at(loaded, {"read_only_parts"});
    EXPECT_NE(parts.find("lines[0].devices[0].variables"), std::string::npos) << parts;
    EXPECT_NE(parts.find(R"("rows":[{"name":"A","type":"int16","register":"1","read":"0x03"}])"),
              std::string::npos)
        << parts;
    EXPECT_NE(parts.find(R"("rows":[{"name":"E.T")"), std::string::npos) << parts;
    // The finding has the index of the project file, not that behind the variables of the template.
    EXPECT_NE(text_at(loaded, {"findings"}).find("lines[0].devices[1].variables[0].register"),
              std::string::npos)
        << loaded.dump();
}

TEST_F(ProjectApiTest, TakesATableAndATemplateOver) {
    folder_.write("a.csv",
                  "Name;Type;Register;Read;Scale;Enumeration\r\nA;int16;1;0x03;0,1;\r\n"
                  "B;int16;2;0x03;;0=stopped, 1=running\r\n");
    folder_.write("l.csv", "name,type\ngo,bool\n");
    folder_.write("t.yaml",
                  "takt: 1\nparameters: {base}\npoll_period: 5s\nattempts: 2\nvariables:\n"
                  "  - {name: T, type: int16, register: $(base + 5), read: 0x03, bits: {0: hot}}\n");
    folder_.write("plant.yaml",
                  "takt: 1\nlines:\n  - name: bus # c\n    transport: simulated\n    devices:\n"
                  "      - {name: D, address: 1, variables: a.csv}\n"
                  "      - name: E # two\n        address: 2\n        attempts: 4 # more\n"
                  "        device_template: t.yaml\n        parameters: {base: 10}\n"
                  "        variables:\n          - {name: X, type: int16, register: 7, read: 0x03} # x\n"
                  "locals: l.csv\n");
    auto document = *project().find("document");
    const auto take = [&](const std::string& path) {
        auto body = body_of(document);
        body.set("path", path);
        return call(Method::post, "/project/take_over", body);
    };
    const auto put = [&](const std::string& path, const std::string& old_text) {
        const auto answer = take(path);
        ASSERT_EQ(answer.status, 200) << answer.body;
        const auto value = text_at(Json::parse(answer.body).value(), {"value"});
        document = changed(document, old_text, value);
    };
    put("lines[0].devices[0].variables", R"("a.csv")");
    put("lines[0].devices[1].device_template",
        std::get<Json::Array>(
            std::get<Json::Array>(document.find("lines")->value())[0].find("devices")->value())[1]
            .dump());
    put("locals", R"("l.csv")");
    const auto revision = *project().find("revision");
    const auto saved = call(Method::put, "/project", body_of(document, revision));
    ASSERT_EQ(saved.status, 200) << saved.body;
    EXPECT_EQ(folder_.read("plant.yaml"),
              "takt: 1\nlines:\n  - name: bus # c\n    transport: simulated\n    devices:\n"
              "      - {name: D, address: 1, variables: [{name: A, type: int16, register: 1, read: 0x03, "
              "scale: 0.1}, {name: B, type: int16, register: 2, read: 0x03, "
              "enumeration: \"0=stopped, 1=running\"}]}\n"
              "      - name: E # two\n        address: 2\n        poll_period: 5s\n"
              "        attempts: 4 # more\n        variables:\n"
              "          - {name: E.T, type: int16, register: 15, read: 0x03, bits: {0: hot}}\n"
              "          - {name: X, type: int16, register: 7, read: 0x03} # x\n"
              "locals:\n  - {name: go, type: bool}\n");
    EXPECT_EQ(text_at(project(), {"read_only_parts"}), "[]");
    EXPECT_NE(folder_.read("a.csv").find("0,1"), std::string::npos) << "the table stays";
}

TEST_F(ProjectApiTest, TakesNothingOverThatIsNoTableOrHasMistakes) {
    folder_.write("a.csv", "name,type\n\"A,int16\n");
    folder_.write("plant.yaml",
                  "takt: 1\nlines:\n  - name: bus\n    transport: simulated\n    devices:\n"
                  "      - {name: D, address: 1, variables: a.csv}\n");
    const auto take = [&](const std::string& path) {
        auto body = body_of(*project().find("document"));
        body.set("path", path);
        return call(Method::post, "/project/take_over", body);
    };
    const auto broken = take("lines[0].devices[0].variables");
    EXPECT_EQ(code_of(broken), "422 take_over");
    EXPECT_NE(broken.body.find("quote"), std::string::npos) << broken.body;
    folder_.write("a.csv", "name,type,register,read\nA,int16,1,0x03\n");
    for (const auto* const path :
         {"", "lines", "lines[0].devices[0].name", "lines[0].devices[0].device_template",
          "lines[9].devices[0].variables", "lines[0", "lines[].x", "...", "locals",
          "lines[0].devices[0].variables[0]", "lines[0].devices[18446744073709551616]"})
        EXPECT_EQ(code_of(take(path)), "422 take_over") << path;
    EXPECT_EQ(take("lines[0].devices[0].variables").status, 200);
    const auto whole = body_of(*project().find("document"));
    for (const auto* const address : {"/project/take_over", "/project/diff"})
        EXPECT_EQ(code_of(call(Method::post, address, whole)), "400 malformed") << address;
}

TEST_F(ProjectApiTest, NeitherReadsNorNamesOtherFilesOfTheHost) {
    folder_.write("secret.txt", "name,type,key\nA,int16,hidden\n");
    folder_.write("b.csv", "name,type,register,read\nB,int16,1,0x03\n");
    const auto loaded = project();
    const auto document = loaded.find("document")->dump();
    const auto begin = document.find("[{\"name\":\"Level\"");
    const auto end = document.find("}]", begin) + 2;
    const auto with = [&](const std::string& variables) {
        auto text = document;
        return Json::parse(text.replace(begin, end - begin, variables)).value();
    };
    const auto evaluated = [&](const std::string& name) {
        return call(Method::post, "/project/evaluate", body_of(with('"' + name + '"'))).body;
    };
    EXPECT_EQ(evaluated("b.csv").find("file."), std::string::npos) << evaluated("b.csv");
    for (const auto* name : {"secret.txt", "/etc/passwd", "../../etc/passwd"}) {
        EXPECT_NE(evaluated(name).find("file.no_permission"), std::string::npos) << evaluated(name);
        EXPECT_EQ(evaluated(name).find("hidden"), std::string::npos);
    }
    auto wanted = document;
    wanted.insert(
        wanted.size() - 1,
        R"(,"servers":[{"name":"s","listen":"*","units":[{"address":"1","variables":[{"name":"V","type")"
        R"(:"int16","area":"holding_register","register":"0","source":{"command":{"run":["id"]}}}]}]}])");
    EXPECT_EQ(code_of(call(Method::put, "/project",
                           body_of(Json::parse(wanted).value(), *loaded.find("revision")))),
              "403 protected_key");
}

constexpr const char* kWithOutputs =
    "takt: 1\nlines:\n  - name: bus\n    transport: simulated\n    devices:\n"
    "      - {name: D, address: 1, variables: [{name: V, type: int16, register: 1, read: 0x03}]}\n"
    "outputs:\n"
    "  - {name: one, transport: mqtt, brokers: [mqtts://one.example], user: u, password_file: p1}\n"
    "  - {name: two, transport: mqtt, brokers: [mqtts://two.example], ca_file: c, user: u, password_env: "
    "P2}\n"
    "  - {name: open, transport: mqtt, brokers: [mqtts://open.example]}\n";

TEST_F(ProjectApiTest, SendsNoSecretElsewhere) {
    folder_.write("plant.yaml", kWithOutputs);
    const auto loaded = project();
    using Changes = std::vector<std::pair<std::string, std::string>>;
    const auto refused = [&](const Changes& changes) {
        auto document = *loaded.find("document");
        for (const auto& [from, to] : changes) document = changed(document, from, to);
        const auto answer = call(Method::put, "/project", body_of(document, *loaded.find("revision")));
        EXPECT_EQ(folder_.read("plant.yaml"), kWithOutputs) << answer.body;
        return code_of(answer) + " " +
               std::string(answer.body.find("`brokers`") != std::string::npos   ? "brokers"
                           : answer.body.find("`ca_file`") != std::string::npos ? "ca_file"
                                                                                : answer.body);
    };
    EXPECT_EQ(refused({{"mqtts://one.example", "mqtts://evil.example"}}), "403 protected brokers");
    EXPECT_EQ(refused({{"mqtts://one.example", "mqtt://one.example"}}), "403 protected brokers");
    EXPECT_EQ(refused({{"mqtts://one.example", "mqtts://one.example:8884"}}), "403 protected brokers");
    EXPECT_EQ(refused({{R"("mqtts://one.example")", R"("mqtts://one.example","mqtts://evil.example")"}}),
              "403 protected brokers");
    EXPECT_EQ(refused({{R"("ca_file":"c",)", ""}}), "403 protected ca_file");
    EXPECT_EQ(refused({{R"("ca_file":"c")", R"("ca_file":"other")"}}), "403 protected ca_file");
    // The names of two outputs change places, or their origins do.
    EXPECT_EQ(refused({{R"("name":"one")", R"("name":"x")"},
                       {R"("name":"open")", R"("name":"one")"},
                       {"mqtts://one.example", "mqtts://evil.example"}}),
              "403 protected brokers");
    EXPECT_EQ(refused({{R"("password_file":"p1","$from":0)", R"("password_file":"p1","$from":2)"},
                       {R"(open.example"],"$from":2)", R"(open.example"],"$from":0)"},
                       {"mqtts://one.example", "mqtts://open.example:1"}}),
              "403 protected brokers");
    // The secret of one output in another one, and in a new one.
    EXPECT_EQ(refused({{R"("user":"u","password_file":"p1",)", ""},
                       {R"(open.example"])", R"(open.example"],"user":"u","password_file":"p1")"}}),
              "403 protected brokers");
    EXPECT_EQ(refused({{R"("outputs":[)", R"("outputs":[{"name":"new","transport":"mqtt","brokers":)"
                                          R"(["mqtts://evil.example"],"user":"u","password_env":"P2"},)"}}),
              "403 protected brokers");
}

TEST_F(ProjectApiTest, ChangesWhatSendsNoSecretElsewhere) {
    using Changes = std::vector<std::pair<std::string, std::string>>;
    const auto saved = [&](const Changes& changes) {
        folder_.write("plant.yaml", kWithOutputs);
        const auto loaded = project();
        auto document = *loaded.find("document");
        for (const auto& [from, to] : changes) document = changed(document, from, to);
        const auto answer = call(Method::put, "/project", body_of(document, *loaded.find("revision")));
        return answer.status == 200 ? std::string() : answer.body;
    };
    EXPECT_EQ(saved({{"open.example", "other.example"}}), "");
    EXPECT_EQ(saved({{R"("name":"one")", R"("name":"renamed")"}, {R"("user":"u")", R"("user":"v")"}}), "");
    EXPECT_EQ(saved({{"mqtts://one.example", "mqtts://other.example"},
                     {R"("user":"u","password_file":"p1",)", ""}}),
              "");
}

TEST_F(ProjectApiTest, GivesFieldsSchemaAndImportedRows) {
    const auto fields = call(Method::get, "/fields", {}, {{"profile", "owen-kc1"}, {"framing", "ascii"}});
    const auto table = Json::parse(fields.body, std::size_t{8} << 20).value();
    const auto* const device = table.find("objects")->find("device");
    EXPECT_EQ(text_at(*device, {"registers_per_request", "greatest"}), "61");
    EXPECT_EQ(text_at(*device, {"poll_period", "kind"}), "duration");
    EXPECT_EQ(text_at(*device, {"attempts", "default"}), "3");
    EXPECT_EQ(text_at(*table.find("objects"), {"output", "quota_mb", "default"}), "4096");
    EXPECT_EQ(text_at(*table.find("objects"), {"line", "devices", "object"}), "device");
    for (const auto* const name : {"profile", "transport", "framing"}) {
        const auto wrong = call(Method::get, "/fields", {}, {{name, "nonsense"}});
        EXPECT_EQ(code_of(wrong), "400 parameter");
        EXPECT_NE(wrong.body.find(name), std::string::npos) << wrong.body;
    }
    EXPECT_NE(call(Method::get, "/schema").body.find("draft/2020-12"), std::string::npos);
    auto pasted = Json::object();
    pasted.set("text",
               "Имя переменной\tТип переменной\tФункция чтения\tФункция записи\tАдрес регистра\tАдрес бита "
               "(ов)\tКомментарий\nVariable-1\tБулевское\t0x01\t0x05\t0\t0\t\n");
    const auto imported = Json::parse(call(Method::post, "/import", pasted).body).value();
    EXPECT_EQ(text_at(imported, {"kind"}), "variables");
    EXPECT_NE(text_at(imported, {"rows"}).find("\"Variable-1\""), std::string::npos);
    EXPECT_NE(text_at(imported, {"rows"}).find("\"bool\""), std::string::npos);
    pasted.set("text", "Имя;Устройство\nАдрес;16\nПериод опроса, мс;100\nКол-во регистров в запросе;20\n");
    const auto window = Json::parse(call(Method::post, "/import", pasted).body).value();
    EXPECT_EQ(text_at(window, {"kind"}), "devices");
    EXPECT_NE(text_at(window, {"rows"}).find("\"address\":\"16\""), std::string::npos);
    EXPECT_NE(text_at(window, {"rows"}).find("\"poll_period\":\"100ms\""), std::string::npos);
    pasted.set("text", "Имя;Устройство\nАдрес;16\n\nИмя;Тип;Адрес регистра\nA;Целочисленное;1\n");
    const auto both = Json::parse(call(Method::post, "/import", pasted).body).value();
    EXPECT_EQ(text_at(both, {"kind"}), "devices");
    EXPECT_NE(text_at(both, {"rows"}).find(R"("variables":[{"name":"A","type":"int16")"), std::string::npos);
}

TEST_F(ProjectApiTest, ReadsPastedCellsWithoutHeadings) {
    const auto answer = [&](const std::string& body) {
        return call(Method::post, "/import", Json::parse(body).value());
    };
    const auto rows = [&](const std::string& cells) {
        const auto read =
            answer(R"({"keys":["name","type","read","register","period","default"],"cells":)" + cells + "}");
        return text_at(Json::parse(read.body).value(), {"rows"});
    };
    const struct {
        const char* word;
        const char* type;
    } types[] = {{"Целочисленный без знака", "uint16"},
                 {"WORD", "uint16"},
                 {"DWORD", "uint32"},
                 {"Целочисленн...", "int16"},
                 {"2-register int", "int32"},
                 {"С плавающей запя…", "float"},
                 {"Булевское", "bool"},
                 {"flot", "flot"}};
    for (const auto& [word, type] : types)
        EXPECT_EQ(rows(std::string(R"([["A",")") + word + R"("]])"),
                  std::string(R"([{"name":"A","type":")") + type + R"("}])");
    EXPECT_EQ(rows(R"([["< не выбрана >","int"],["B","Булевское","03 (0x03) Read","–","100 мс","Да"],[]])"),
              R"([null,{"name":"B","type":"bool","read":"0x03","period":"100ms","default":"true"},{}])");
    EXPECT_EQ(
        rows(R"([["C","real","нет","10h","1,5","0,01"]])"),
        R"([{"name":"C","type":"real","read":"none","register":"0x10","period":"1.5ms","default":"0.01"}])");
    for (const auto* wrong : {R"({"cells":[]})", R"({"keys":["a"],"cells":[["1","2"]]})",
                              R"({"keys":["a"],"cells":[1]})", R"({"keys":[1],"cells":[]})"})
        EXPECT_EQ(code_of(answer(wrong)), "400 malformed") << wrong;
}

TEST_F(ProjectApiTest, PastedRowsAreCheckedAsInAProject) {
    auto pasted = Json::object();
    const auto answer = [&](const std::string& text) {
        pasted.set("text", text);
        return Json::parse(call(Method::post, "/import", pasted).body).value();
    };
    const auto wrong = answer("Имя;Устройство\nАдрес;abc\n\nИмя;Тип;Адрес регистра\nA;Целочисленное;1\n");
    EXPECT_NE(
        text_at(wrong, {"findings"}).find(R"("line":2,"column":7,"path":"lines[0].devices[0].address")"),
        std::string::npos);
    const std::string list = "\n\nИмя;Тип;Адрес регистра\nA;Целочисленное;1\n\n";
    const auto two = text_at(answer("Имя;P\nАдрес;1" + list + "Имя;Q\nАдрес;250" + list), {});
    EXPECT_NE(two.find("\"name\":\"P.A\""), std::string::npos) << two;
    EXPECT_NE(two.find("\"name\":\"Q.A\""), std::string::npos) << two;
    EXPECT_NE(two.find("names_qualified"), std::string::npos) << two;
    EXPECT_NE(two.find("1..247"), std::string::npos) << two;
    // The line and the names of the project that the rows are for.
    pasted.set("transport", "tcp");
    pasted.set("device", "Boiler");
    auto names = Json::array();
    names.push_back("A");
    pasted.set("names", names);
    const auto one = text_at(answer("Имя;Тип;Адрес регистра\nA;Целочисленное;1\n"), {});
    EXPECT_NE(one.find("\"name\":\"Boiler.A\""), std::string::npos) << one;
    const auto far = text_at(answer("Имя;P\nАдрес;250\nПротокол;Modbus TCP\n"), {});
    EXPECT_EQ(far.find("\"severity\":\"error\""), std::string::npos) << far;
    // A column of devices.
    const auto flat = answer("device,unit_address,name,type,register,read\nP,1,V,int,0,3\nQ,2,W,int,0,3\n");
    EXPECT_EQ(text_at(flat, {"kind"}), "devices");
    EXPECT_NE(text_at(flat, {"rows"}).find("\"address\":\"2\""), std::string::npos);
    // Sources of a server are elsewhere in the project.
    const auto served = text_at(answer("Имя переменной;Тип переменной;Адрес регистра;Использование в проекте;"
                                       "Комментарий\nV;Целочисленное;513;Да;\n"),
                                {});
    EXPECT_EQ(served.find("\"severity\":\"error\""), std::string::npos) << served;
    const auto locals =
        text_at(answer("Имя переменной;Тип переменной;Энергонезависимость;Значение по умолчанию;"
                       "Использование в проекте\nr1;Целочисленное;☑;1;Да\n"),
                {});
    EXPECT_EQ(locals.find("\"severity\":\"error\""), std::string::npos) << locals;
}

TEST_F(ProjectApiTest, TwoBrowsersDoNotOverwriteEachOther) {
    const auto loaded = project();
    std::array<int, 2> status{};
    const auto save = [&](std::size_t i, const std::string& name) {
        const auto wanted = changed(*loaded.find("document"), "Boiler", name);
        status[i] = call(Method::put, "/project", body_of(wanted, *loaded.find("revision"))).status;
    };
    std::thread first([&] { save(0, "One"); });
    std::thread second([&] { save(1, "Two"); });
    first.join();
    second.join();
    EXPECT_EQ(std::ranges::count(status, 200), 1);
    EXPECT_EQ(std::ranges::count(status, 409), 1);
    EXPECT_EQ(folder_.read("plant.yaml~"), kProject);
}

}  // namespace project_api_test
}  // namespace takt::web
