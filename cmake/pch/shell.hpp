// Precompiled for the modules that are not pure: headers of files and threads, which these parse in addition.
#include "core.hpp"

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <system_error>
#include <thread>
