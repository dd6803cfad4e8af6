// Assertions for programming errors. They are checked in release builds too and cannot be reached from input.
#pragma once

#include <cstdlib>

namespace takt {

/// Called with the failed expression before the program aborts. A firmware or a test may replace it.
using AssertHook = void (*)(const char* expression, const char* file, int line);
void set_assert_hook(AssertHook hook);

/// Calls the hook with the failed expression and aborts.
[[noreturn]] void assertion_failed(const char* expression, const char* file, int line);

}  // namespace takt

#define TAKT_ASSERT(expression) \
    (static_cast<bool>(expression) ? void(0) : ::takt::assertion_failed(#expression, __FILE__, __LINE__))
