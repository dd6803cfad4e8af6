// Precompiled for the modules that make text: src/modules.json lists fmt among their libraries.
#include "shell.hpp"

#include <fmt/format.h>
