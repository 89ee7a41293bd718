// Threads that call libOpenNI2. The library keeps an error text for every thread that has called it. When a new thread
// calls, it checks whether the others still run, and that check may crash for a thread that has ended (libOpenNI2
// 2.2.0.33, glibc 2.36). Therefore these threads run until the program ends.
#pragma once

#include <functional>
#include <future>
#include <memory>

#include "acquire/device_source.h"

namespace scanknit {

/// Starts `work` on an idle thread, or on a new one. The future is ready when `work` has ended.
[[nodiscard]] std::future<void> begin_on_library_thread(std::function<void()> work);

/// The same, and waits for it.
void do_on_library_thread(std::function<void()> work);

/// Wraps `camera` so that every call that may reach the library runs on such a thread.
[[nodiscard]] std::unique_ptr<DeviceSource> on_library_thread(std::unique_ptr<DeviceSource> camera);

}  // namespace scanknit
