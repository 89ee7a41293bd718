// A second opinion of our model: libuvc, which knows UVC up to 1.1, and no Z16 but 16-bit grey, streams its pictures.
#include <libuvc/libuvc.h>

#include "tests/usb/emulated/live_camera.h"

namespace scanknit::test {
namespace {

struct Seen {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<int> numbers;
};

void on_frame(uvc_frame_t* frame, void* user) {
  auto& seen = *static_cast<Seen*>(user);
  const std::lock_guard lock(seen.mutex);
  std::uint16_t number = 0;
  std::memcpy(&number, frame->data, sizeof(number));
  const auto expected = std::as_bytes(Vcam::depth_pixels(number, 640 * 480));
  EXPECT_EQ(frame->data_bytes, expected.size());
  EXPECT_EQ(std::memcmp(frame->data, expected.data(), std::min(frame->data_bytes, expected.size())), 0) << number;
  seen.numbers.push_back(number);
  seen.changed.notify_all();
}

TEST(Libuvc, StreamsTheModelsPictures) {
  EmulatedBus bus;
  Seen seen;
  // It queues a hundred transfers of a payload each: whole pictures would not fit into the system's USB memory.
  bus.plug({.uvc_version = 0x0110, .payload_bytes = 65536, .has_colour = false, .depth_code = "Y16 "});
  uvc_context_t* context = nullptr;
  uvc_device_t* device = nullptr;
  uvc_device_handle_t* handle = nullptr;
  uvc_stream_ctrl_t control{};
  ASSERT_EQ(uvc_init(&context, nullptr), UVC_SUCCESS);
  ASSERT_EQ(uvc_find_device(context, &device, 0x8086, 0x0b07, nullptr), UVC_SUCCESS);
  ASSERT_EQ(uvc_open(device, &handle), UVC_SUCCESS);
  EXPECT_EQ(uvc_get_stream_ctrl_format_size(handle, &control, UVC_FRAME_FORMAT_GRAY16, 640, 480, 30), UVC_SUCCESS);
  EXPECT_EQ(uvc_start_streaming(handle, &control, on_frame, &seen, 0), UVC_SUCCESS);
  {
    std::unique_lock lock(seen.mutex);
    EXPECT_TRUE(seen.changed.wait_for(lock, 10s, [&] { return seen.numbers.size() >= 20; }));
  }
  uvc_stop_streaming(handle);
  uvc_close(handle);
  uvc_unref_device(device);
  uvc_exit(context);
  EXPECT_TRUE(std::is_sorted(seen.numbers.begin(), seen.numbers.end()));
}

}  // namespace
}  // namespace scanknit::test
