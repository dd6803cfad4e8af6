// The share of a processor that a thread gets beside others.
#pragma once

namespace takt::os {

/// How much higher the nice value of a background thread is: a third of the processor time of another thread
/// that wants the same core.
inline constexpr int kBackgroundNice = 5;

/// Makes the calling thread a background thread, for work that has time while others have deadlines. Threads
/// that it starts later inherit this. To be called once in a thread. Without effect where the system refuses.
void become_background_thread();

}  // namespace takt::os
