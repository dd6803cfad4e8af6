#include "sessions/retention.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "folder.hpp"
#include "projects.hpp"
#include "rig.hpp"
#include "tasks.hpp"

namespace takt::host::test {
namespace retention_test {

/// A line without retained variables, and this local.
std::string plant_with(const std::string& local) {
    return project_with(line_of("main", boiler()), "  - " + local + "\n");
}

const std::string kPlant = project_with(line_of("main", pump(kOnChange + ", retain: true")),
                                        "  - {name: recipe, type: int, retain: true}\n"
                                        "  - {name: scratch, type: int}\n");

class RetentionTest : public testing::Test {
protected:
    std::unique_ptr<Retention> open(const Configuration& configuration) {
        return Retention::open(
            configuration, path_, [this](std::function<void()> task) { tasks_.post(std::move(task)); },
            [this](const Notice& notice) { notices_.push_back(notice.code); });
    }

    takt::test::Tasks tasks_;
    takt::test::Folder folder_;
    std::string path_ = folder_ / "plant.state";
    std::vector<std::string> notices_;
};

TEST_F(RetentionTest, AProjectThatRetainsNothingHasNoFile) {
    const auto configuration = configuration_of(plant_with("{name: scratch, type: int}"));
    EXPECT_FALSE(open(*configuration));
    EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(RetentionTest, ASetIsAcknowledgedWhenItIsOnTheDiskAndThereAfterARestart) {
    const auto configuration = configuration_of(kPlant);
    {
        const auto retention = open(*configuration);
        ASSERT_TRUE(retention);
        Rig rig(kPlant, {.retention = retention.get()});
        retention->watch(*rig.engine->configuration(), rig.engine->master().store());
        const auto session = rig.open();
        ASSERT_TRUE(session->submit({Command::Kind::set, rig.slot("recipe"), std::int64_t{5}}));
        rig.serve();
        EXPECT_FALSE(session->next_outcome()) << "not on the disk yet";
        std::optional<Outcome> outcome;
        while (!outcome) {
            tasks_.run_one();
            outcome = session->next_outcome();
        }
        EXPECT_FALSE(outcome->not_retained);
        // Without finish(): as after a kill.
    }
    const auto retention = open(*configuration);
    ASSERT_TRUE(retention);
    Rig rig(kPlant, {.retention = retention.get()});
    EXPECT_TRUE(value::same(rig.engine->master().store()[rig.slot("recipe")].value, std::int64_t{5}));
    EXPECT_TRUE(notices_.empty());
}

TEST_F(RetentionTest, AValueThatMerelyChangedIsWrittenByTheSweepAndAtTheEnd) {
    const auto configuration = configuration_of(kPlant);
    {
        const auto retention = open(*configuration);
        Rig rig(kPlant, {.retention = retention.get()});
        retention->watch(*rig.engine->configuration(), rig.engine->master().store());
        ASSERT_TRUE(rig.engine->set_local(rig.now, rig.slot("recipe"), std::int64_t{6}));
        rig.engine->finish(rig.now);
    }
    const auto retention = open(*configuration);
    ASSERT_EQ(retention->restored().size(), 1U);
    EXPECT_TRUE(value::same(retention->restored()[0].value, std::int64_t{6}));
}

TEST_F(RetentionTest, ACommandThatWaitsForTheDiskEndsWhenAnotherProjectIsApplied) {
    const auto configuration = configuration_of(kPlant);
    const auto retention = open(*configuration);
    Rig rig(kPlant, {.retention = retention.get()});
    retention->watch(*rig.engine->configuration(), rig.engine->master().store());
    const auto session = rig.open();
    ASSERT_TRUE(session->submit({Command::Kind::set, rig.slot("recipe"), std::int64_t{5}}));
    rig.serve();
    rig.apply(kPlant);
    const auto outcome = session->next_outcome();
    ASSERT_TRUE(outcome);
    EXPECT_TRUE(outcome->not_retained) << "not known to be on the disk";
    tasks_.run_one();  // the disk has it now: nothing waits any more
    rig.engine->finish(rig.now);
    EXPECT_FALSE(session->next_outcome());
    EXPECT_TRUE(value::same(rig.engine->master().store()[rig.slot("recipe")].value, std::int64_t{5}));
}

TEST_F(RetentionTest, AValueThatIsNewlyRetainedComesFromTheOpenFileUnlessTheRunningProjectHasOne) {
    const std::string kOther = "  - {name: other, type: int, retain: true}\n";
    const auto with = [](const std::string& locals) { return project_with(line_of("main", pump()), locals); };
    const std::string retained = with("  - {name: recipe, type: int, retain: true}\n" + kOther);
    {
        const auto retention = open(*configuration_of(retained));
        Rig rig(retained, {.retention = retention.get()});
        retention->watch(*rig.engine->configuration(), rig.engine->master().store());
        ASSERT_TRUE(rig.engine->set_local(rig.now, rig.slot("recipe"), std::int64_t{6}));
        rig.engine->finish(rig.now);
    }
    struct Case {
        const char* what;
        std::string running;
        std::optional<std::int64_t> set;
        std::int64_t expected;
    };
    for (const auto& [what, running, set, expected] :
         {Case{"new", with(kOther), std::nullopt, 6},
          Case{"never set", with("  - {name: recipe, type: int}\n" + kOther), std::nullopt, 6},
          Case{"set", with("  - {name: recipe, type: int}\n" + kOther), 9, 9},
          Case{"retained before", with(kOther), std::nullopt, 9}}) {
        SCOPED_TRACE(what);
        const auto retention = open(*configuration_of(running));
        Rig rig(running, {.retention = retention.get()});
        retention->watch(*rig.engine->configuration(), rig.engine->master().store());
        if (set) {
            ASSERT_TRUE(rig.engine->set_local(rig.now, rig.slot("recipe"), *set));
        }
        const auto session = rig.open();
        rig.apply(retained);
        rig.serve();
        EXPECT_TRUE(value::same(rig.engine->master().store()[rig.slot("recipe")].value, expected));
        std::size_t changes = 0;
        for (const auto& event : take_events(*session)) {
            const auto* const changed = std::get_if<ValueChanged>(&event.body);
            if (!changed || event.generation != 2 || changed->slot != rig.slot("recipe")) continue;
            ++changes;
            EXPECT_TRUE(value::same(changed->value, expected));
        }
        EXPECT_EQ(changes, set ? 0U : 1U);
        rig.apply(with(kOther));
        rig.apply(retained);
        EXPECT_TRUE(value::same(rig.engine->master().store()[rig.slot("recipe")].value, expected))
            << "kept aside";
        rig.engine->finish(rig.now);
    }
}

TEST_F(RetentionTest, AFileOfAnotherProgramIsLeftAloneAndReported) {
    std::ofstream(path_) << "not a state file, but a user's notes";
    const auto configuration = configuration_of(kPlant);
    const auto retention = open(*configuration);
    ASSERT_TRUE(retention);
    EXPECT_EQ(notices_, std::vector<std::string>{"host.retain.foreign"});
    bool kept = true;
    Rig rig(kPlant, {.retention = retention.get()});
    retention->watch(*rig.engine->configuration(), rig.engine->master().store());
    retention->keep(rig.slot("recipe"), [&](bool done) { kept = done; });
    EXPECT_FALSE(kept);
    std::ifstream file(path_);
    std::string text(std::istreambuf_iterator<char>(file), {});
    EXPECT_EQ(text, "not a state file, but a user's notes");
}

TEST_F(RetentionTest, NamesThatAreGoneAndTypesThatChangedAreReported) {
    const auto configuration = configuration_of(kPlant);
    {
        const auto retention = open(*configuration);
        Rig rig(kPlant, {.retention = retention.get()});
        retention->watch(*rig.engine->configuration(), rig.engine->master().store());
        ASSERT_TRUE(rig.engine->set_local(rig.now, rig.slot("recipe"), std::int64_t{-7}));
        rig.run(2s);
        rig.engine->finish(rig.now);
    }
    const auto other = configuration_of(plant_with("{name: recipe, type: bool, retain: true}"));
    const auto retention = open(*other);
    EXPECT_EQ(notices_, (std::vector<std::string>{"host.retain.other_type", "host.retain.unknown"}));
}

}  // namespace retention_test
}  // namespace takt::host::test
