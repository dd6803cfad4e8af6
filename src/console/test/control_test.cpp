#include "takt/console/control.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::console {
namespace control_test {

using Verb = ControlCommand::Verb;

TEST(ParseControl, UnderstandsItsVerbs) {
    struct Case {
        std::string_view line;
        Verb verb;
        std::string name, value;
    };
    const Case cases[] = {
        {"set go true", Verb::set, "go", "true"},
        {"  write   Var1  1.5 \r", Verb::write, "Var1", "1.5"},
        {"write \"Tank level\" 7", Verb::write, "Tank level", "7"},
        {"write label two words", Verb::write, "label", "two words"},
        {"get Var1", Verb::get, "Var1", ""},
        {"status", Verb::status, "", ""},
        {"list", Verb::list, "", ""},
        {"values", Verb::values, "", ""},
        {"values  Tank*", Verb::values, "Tank*", ""},
        {"values \"Tank level\"", Verb::values, "Tank level", ""},
        {"quit", Verb::quit, "", ""},
    };
    for (const auto& expected : cases) {
        const auto command = parse_control(expected.line);
        ASSERT_TRUE(command) << expected.line;
        EXPECT_EQ(command->verb, expected.verb) << expected.line;
        EXPECT_EQ(command->name, expected.name);
        EXPECT_EQ(command->value, expected.value);
    }
}

TEST(ParseControl, RefusesWhatIsIncompleteOrTooMuch) {
    for (const auto* line : {"", "  ", "set", "set go", "get", "get a b", "quit now", "status now", "list a",
                             "values a b", "write \"open 1"}) {
        const auto command = parse_control(line);
        ASSERT_FALSE(command) << line;
        EXPECT_EQ(command.error().code, Code::syntax) << line;
        const auto right =
            std::string_view(line).contains('"')
                ? " → \"…\""
                : " → status, list, values [PATTERN], get NAME, set NAME VALUE, write NAME VALUE, quit";
        EXPECT_TRUE(command.error().subject.view().ends_with(right)) << command.error().subject.view();
    }
}

TEST(LineSplitter, CutsAnyChunksAndReportsAnOverlongLineOnce) {
    LineSplitter splitter;
    std::vector<std::string> lines;
    int errors = 0;
    const auto take = [&](Result<std::string> line) { line ? lines.push_back(*line) : void(++errors); };
    splitter.feed("get a\nge", take);
    splitter.feed("t b\n\n", take);
    splitter.feed(std::string(3 * LineSplitter::kMaxLine, 'x'), take);
    splitter.feed("tail\nget c\n", take);
    EXPECT_EQ(lines, (std::vector<std::string>{"get a", "get b", "", "get c"}));
    EXPECT_EQ(errors, 1);
}

}  // namespace control_test
}  // namespace takt::console
