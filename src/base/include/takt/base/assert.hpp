// Programmer mistakes: checked in release builds too, unreachable from input.
#pragma once

#include <cstdlib>

namespace takt {

/// Called with the failed expression before the program ends; a firmware or a test may replace it.
using AssertHook = void (*)(const char* expression, const char* file, int line);
void set_assert_hook(AssertHook hook);

/// Reports the broken expectation to the hook and aborts.
[[noreturn]] void assertion_failed(const char* expression, const char* file, int line);

}  // namespace takt

#define TAKT_ASSERT(expression) \
    (static_cast<bool>(expression) ? void(0) : ::takt::assertion_failed(#expression, __FILE__, __LINE__))
