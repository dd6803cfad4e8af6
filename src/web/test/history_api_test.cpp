#include "takt/web/history_api.hpp"

#include <gtest/gtest.h>

#include <SQLiteCpp/SQLiteCpp.h>

#include "folder.hpp"
#include "takt/host/project_file.hpp"
#include "takt/publish/project_outputs.hpp"
#include "takt/store/history.hpp"

namespace takt::web {
namespace history_api_test {

using Query = std::multimap<std::string, std::string, std::less<>>;

class HistoryApiTest : public testing::Test {
protected:
    void SetUp() override {
        configure(", outputs: [{name: history, transport: history, variables: ['*']}]");
        auto opened = store::History::open(publish::history_database(file_)).value();
        auto& history = opened.history;
        const auto series = history->series({"Level", "Boiler", DataType::int16, false, "m"}).value();
        for (std::int64_t i = 0; i < 10; ++i)
            history->append(series, {.time_ns = (kBegin + i * 1000) * 1'000'000, .value = std::int64_t{i}});
        ASSERT_TRUE(history->commit(kBegin * 1'000'000));
    }

    void configure(const std::string& outputs) {
        auto loaded = host::load_project_text(file_,
                                              "{takt: 1, lines: [{name: bus, transport: simulated, devices: "
                                              "[{name: Boiler, address: 1, variables: "
                                              "[{name: Level, type: int16, register: 0, read: 0x03}]}]}]" +
                                                  outputs + "}");
        EXPECT_FALSE(loaded.has_errors());
        configuration_ =
            std::make_shared<const host::Configuration>(1, std::move(loaded.project), plan::Plan{});
        routes_ = history_routes({file_, [this] { return configuration_; }});
    }

    ApiResponse call(std::string_view path, const Query& query = {}) {
        const ApiRequest request{.query = query, .texts = texts_};
        for (const auto& route : routes_)
            if (route.path == path) return route.handler(request);
        return {};
    }

    static constexpr std::int64_t kBegin = 1'700'000'000'000;  // ms
    const takt::test::Folder folder_;
    const std::string file_ = folder_ / "plant.yaml";
    const report::Texts texts_{text::Language::english};
    host::ConfigurationPtr configuration_;
    std::vector<ApiRoute> routes_;
};

TEST_F(HistoryApiTest, ListsSeriesAndDrawsThem) {
    EXPECT_NE(call("/history/series").body.find("\"Level\""), std::string::npos);
    const Query query{{"variable", "Level"},
                      {"from", std::to_string(kBegin)},
                      {"to", std::to_string(kBegin + 10'000)},
                      {"pixels", "100"}};
    const auto picture = call("/history", query);
    EXPECT_EQ(picture.status, 200);
    EXPECT_NE(picture.body.find("\"variables\":[{"), std::string::npos) << picture.body;
    const auto table = call("/history.csv", query);
    EXPECT_EQ(table.file_name, "history.csv");
    EXPECT_EQ(std::ranges::count(table.body, '\n'), 11) << table.body;
}

TEST_F(HistoryApiTest, RefusesWhatItCannotAnswer) {
    const auto status = [&](Query query) {
        query.emplace("from", "2023-11-14T00:00Z");
        return call("/history", query).status;
    };
    EXPECT_EQ(status({{"variable", "Level"}}), 200);
    EXPECT_EQ(status({{"variable", "Other"}}), 404);
    EXPECT_EQ(status({}), 400);
    EXPECT_EQ(status({{"variable", "Level"}, {"pixels", "4001"}}), 400);
    EXPECT_EQ(status({{"variable", "Level"}, {"pixels", "x"}}), 400);
    EXPECT_EQ(status({{"variable", "Level"}, {"to", "1"}}), 400);
    configure("");
    EXPECT_EQ(status({{"variable", "Level"}}), 404);
    EXPECT_EQ(call("/history/series").status, 404);
}

TEST_F(HistoryApiTest, AnswersWithDamageInPlaceOfAVariable) {
    {
        auto opened = store::History::open(publish::history_database(file_)).value();
        ASSERT_TRUE(opened.history->series({"Flow", "Boiler", DataType::int16, false, "l"}));
    }
    SQLite::Database(publish::history_database(file_), SQLite::OPEN_READWRITE)
        .exec("UPDATE series SET unit = 'cm' WHERE name = 'Level'");
    const Query query{{"variable", "Level"}, {"variable", "Flow"}, {"from", "2023-11-14T00:00Z"}};
    const auto picture = call("/history", query);
    EXPECT_EQ(picture.status, 200);
    EXPECT_NE(picture.body.find(R"("part":"series","row":1,"variable":"Level")"), std::string::npos)
        << picture.body;
    const auto table = call("/history.csv", {{"variable", "Level"}, {"from", "2023-11-14T00:00Z"}});
    EXPECT_EQ(table.status, 200);
    EXPECT_NE(table.body.find("\nLevel,2023-11-14T"), std::string::npos) << table.body;
    EXPECT_EQ(call("/history", {{"variable", "Other"}}).status, 404);
}

}  // namespace history_api_test
}  // namespace takt::web
