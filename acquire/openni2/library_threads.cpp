#include "acquire/openni2/library_threads.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace scanknit {
namespace {

class LibraryThreads {
 public:
  std::future<void> begin(std::function<void()> work) {
    std::packaged_task<void()> task(std::move(work));
    auto done = task.get_future();
    {
      const std::lock_guard lock(mutex_);
      if (idle_ <= tasks_.size()) {  // first: where there is no thread, no task may stay
        threads_.emplace_back([this](const std::stop_token& stop) { run(stop); });
      }
      tasks_.push_back(std::move(task));
    }
    changed_.notify_one();
    return done;
  }

 private:
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (true) {
      ++idle_;
      const bool has_task = changed_.wait(lock, stop, [this] { return !tasks_.empty(); });
      --idle_;
      if (!has_task) return;
      auto task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      task();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<std::packaged_task<void()>> tasks_;
  std::size_t idle_ = 0;
  std::vector<std::jthread> threads_;  // last: they use the others
};

LibraryThreads& library_threads() {
  static LibraryThreads threads;
  return threads;
}

/// Every call of a camera, by way of a thread of the library's own.
class OnLibraryThread final : public DeviceSource {
 public:
  explicit OnLibraryThread(std::unique_ptr<DeviceSource> camera) : camera_(std::move(camera)) {}
  ~OnLibraryThread() override {
    at_the_end([this] { camera_.reset(); });
  }
  [[nodiscard]] const DeviceInfo& info() const override { return camera_->info(); }
  [[nodiscard]] std::vector<StreamProfile> profiles() const override { return camera_->profiles(); }
  [[nodiscard]] Result<RawCalibration> calibration(std::span<const StreamProfile> streams) override {
    std::optional<Result<RawCalibration>> result;
    do_on_library_thread([&] { result = camera_->calibration(streams); });
    return *std::move(result);
  }
  [[nodiscard]] Result<void> start(std::span<const StreamProfile> streams, FrameSink frames,
                                   EventSink events) override {
    Result<void> result;
    do_on_library_thread([&] { result = camera_->start(streams, std::move(frames), std::move(events)); });
    return result;
  }
  void stop() override {
    at_the_end([this] { camera_->stop(); });
  }
  [[nodiscard]] LossCounters losses() const override { return camera_->losses(); }
  [[nodiscard]] Result<void> set_control(DeviceControl control, int value) override {
    Result<void> result;
    do_on_library_thread([&] { result = camera_->set_control(control, value); });
    return result;
  }

 private:
  /// Where no thread is left, on the caller's own.
  static void at_the_end(const std::function<void()>& work) {
    try {
      do_on_library_thread(work);
    } catch (const std::system_error&) {
      work();
    }
  }

  std::unique_ptr<DeviceSource> camera_;
};

}  // namespace

std::future<void> begin_on_library_thread(std::function<void()> work) {
  return library_threads().begin(std::move(work));
}

void do_on_library_thread(std::function<void()> work) {
  begin_on_library_thread(std::move(work)).get();
}

std::unique_ptr<DeviceSource> on_library_thread(std::unique_ptr<DeviceSource> camera) {
  return std::make_unique<OnLibraryThread>(std::move(camera));
}

}  // namespace scanknit
