// Names of threads, as top, gdb and strace show them.
#pragma once

namespace takt::os {

/// Names the thread that calls it.
/// @param name  at most 15 characters: the system refuses longer ones
void name_thread(const char* name);

}  // namespace takt::os
