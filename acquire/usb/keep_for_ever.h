// keep_for_ever(): memory that the system may still write into when nobody needs it any more.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace scanknit {

/// Never frees `thing`, but keeps it reachable, so that the leak sanitizer tells it from what was forgotten. For
/// transfers that a camera does not give back in time; each is a few kilobytes, and there are few of them.
template <typename T>
void keep_for_ever(std::unique_ptr<T> thing) {
  struct Kept {
    std::mutex mutex;
    std::vector<std::unique_ptr<T>> things;
  };
  static Kept& kept = *new Kept;  // not destroyed at the end of the process
  const std::lock_guard lock(kept.mutex);
  kept.things.push_back(std::move(thing));
}

}  // namespace scanknit
