#include "takt/base/assert.hpp"

namespace takt {
namespace {

AssertHook g_hook = nullptr;  // the one process-wide setting: an assertion has no object to ask

}  // namespace

void set_assert_hook(AssertHook hook) {
    g_hook = hook;
}

void assertion_failed(const char* expression, const char* file, int line) {
    if (g_hook) g_hook(expression, file, line);
    std::abort();
}

}  // namespace takt
