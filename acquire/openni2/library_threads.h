// Threads that call libOpenNI2. The library keeps an error text for every thread that ever called it, and asks when a
// new one comes whether the others still live: of one that has ended, asking may crash (libOpenNI2 2.2.0.33,
// glibc 2.36). So those that call it do not end before the program.
#pragma once

#include <functional>
#include <future>
#include <memory>

#include "acquire/device_source.h"

namespace scanknit {

/// Begins `work` on a thread that is idle, or on a new one. The future is ready when it has ended.
[[nodiscard]] std::future<void> begin_on_library_thread(std::function<void()> work);

/// The same, and waits.
void do_on_library_thread(std::function<void()> work);

/// `camera`, every call of which that may reach the library is made on such a thread.
[[nodiscard]] std::unique_ptr<DeviceSource> on_library_thread(std::unique_ptr<DeviceSource> camera);

}  // namespace scanknit
