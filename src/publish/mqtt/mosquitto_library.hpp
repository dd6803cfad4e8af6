// The process-wide state of libmosquitto.
#pragma once

namespace takt::publish {

/// Initializes libmosquitto with the first call in the process. The library stays initialized until the
/// process ends, because a detached thread may still use it. May be called from any thread.
/// @returns the version of the loaded library: major * 1,000,000 + minor * 1,000 + revision
int use_mosquitto_library();

}  // namespace takt::publish
