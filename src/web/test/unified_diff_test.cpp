#include "project/unified_diff.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cstdio>
#include <sstream>

namespace takt::web {
namespace unified_diff_test {

/// What patch(1) does with one file.
std::string applied(const std::string& old_text, const std::string& diff) {
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < old_text.size();) {
        const auto end = std::min(old_text.find('\n', at), old_text.size() - 1) + 1;
        lines.push_back(old_text.substr(at, end - at));
        at = end;
    }
    std::string result;
    std::size_t next = 0;
    std::istringstream in(diff);
    std::string line;
    bool body = false;
    while (std::getline(in, line)) {
        std::size_t begin = 0;
        std::size_t count = 1;
        if (line.starts_with("@@")) {
            if (std::sscanf(line.c_str(), "@@ -%zu,%zu", &begin, &count) < 2) count = 1;
            const auto first = count == 0 ? begin : begin - 1;
            while (next < first) result += lines.at(next++);
            body = true;
        } else if (body && line.starts_with("\\")) {
            result.pop_back();
        } else if (body && line.starts_with("-")) {
            ++next;
        } else if (body) {
            result += line.substr(1) + "\n";
            if (line.starts_with(" ")) ++next;
        }
    }
    // A missing line break stays missing where the line itself did not change.
    while (next < lines.size()) result += lines.at(next++);
    return result;
}

TEST(UnifiedDiff, HasThreeLinesOfContext) {
    EXPECT_EQ(unified_diff("a\nb\nc\nd\ne\nf\ng\nh\ni\nj\n", "a\nb\nc\nd\nE\nf\ng\nh\ni\nj\n", "p", "q"),
              "--- p\n+++ q\n@@ -2,7 +2,7 @@\n b\n c\n d\n-e\n+E\n f\n g\n h\n");
    EXPECT_EQ(unified_diff("a\n", "a\n", "p", "q"), "");
    EXPECT_EQ(unified_diff("", "a\nb\n", "p", "q"), "--- p\n+++ q\n@@ -0,0 +1,2 @@\n+a\n+b\n");
    EXPECT_EQ(unified_diff("a\nb", "a\nc", "p", "q"),
              "--- p\n+++ q\n@@ -1,2 +1,2 @@\n a\n-b\n\\ No newline at end of file\n+c\n"
              "\\ No newline at end of file\n");
}

TEST(UnifiedDiff, KeepsDistantChangesApart) {
    std::string old_text;
    for (int i = 0; i < 30; ++i) old_text += std::to_string(i) + "\n";
    auto text = old_text;
    text.replace(text.find("\n3\n"), 3, "\nthree\n");
    text.erase(text.find("\n25\n"), 3);
    const auto diff = unified_diff(old_text, text, "p", "q");
    EXPECT_NE(diff.find("@@ -1,7 +1,7 @@"), std::string::npos) << diff;
    EXPECT_NE(diff.find("@@ -23,7 +23,6 @@"), std::string::npos) << diff;
}

RC_GTEST_PROP(UnifiedDiffRandom, PatchMakesTheNewText, ()) {
    const auto lines = rc::gen::container<std::vector<std::string>>(
        rc::gen::elementOf(std::vector<std::string>{"a\n", "b\n", "c\n", "\n", "-\n", "long line\n"}));
    std::string old_text;
    for (const auto& line : *lines) old_text += line;
    std::string text;
    for (const auto& line : *lines) text += line;
    const auto diff = unified_diff(old_text, text, "p", "q");
    RC_LOG() << diff;
    RC_ASSERT(applied(old_text, diff) == text);
}

TEST(UnifiedDiff, IsBoundedForTextsWithNothingInCommon) {
    std::string old_text;
    std::string text;
    for (int i = 0; i < 20000; ++i) {
        old_text += "a" + std::to_string(i) + "\n";
        text += "b" + std::to_string(i) + "\n";
    }
    const auto diff = unified_diff(old_text, text, "p", "q");
    EXPECT_EQ(std::ranges::count(diff, '\n'), 40003);
    EXPECT_EQ(applied(old_text, diff), text);
}

}  // namespace unified_diff_test
}  // namespace takt::web
