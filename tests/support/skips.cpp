// Where TAKT_SKIPS names a file, each skipped case of a test program appends a line "SUITE.TEST: REASON" to
// it. `./dev test` prints and counts them (tests/conftest.py does the same for pytest).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace takt::test {
namespace {

std::string reason(const testing::TestResult& result) {
    for (int i = 0; i < result.total_part_count(); ++i) {
        const auto& part = result.GetTestPartResult(i);
        if (!part.skipped()) continue;
        std::string text = part.message();
        std::ranges::replace(text, '\n', ' ');
        return text;
    }
    return "no reason";
}

class SkipReport final : public testing::EmptyTestEventListener {
    void OnTestEnd(const testing::TestInfo& test) override {
        const char* const path = std::getenv("TAKT_SKIPS");
        if (!path || !test.result()->Skipped()) return;
        const std::string line =
            std::string(test.test_suite_name()) + "." + test.name() + ": " + reason(*test.result()) + "\n";
        std::FILE* const file = std::fopen(path, "a");
        if (!file) return;
        std::fputs(line.c_str(), file);  // one write: programs append beside each other
        std::fclose(file);
    }
};

// googletest owns the listener.
[[maybe_unused]] const bool kListens = [] {
    testing::UnitTest::GetInstance()->listeners().Append(new SkipReport);
    return true;
}();

}  // namespace
}  // namespace takt::test
