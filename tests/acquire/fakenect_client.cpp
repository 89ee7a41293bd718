// A client of libfreenect that knows nothing of ScanKnit: prints a checksum of every depth and colour picture, until
// as many depth pictures have come as its argument says. Run with the player in place of the library, and
// FAKENECT_PATH.
#include <libfreenect.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace {

int depth_pictures = 0;

std::uint32_t checksum(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint32_t sum = 2166136261u;  // FNV-1a
  for (std::size_t i = 0; i < size; ++i) sum = (sum ^ bytes[i]) * 16777619u;
  return sum;
}

void on_depth(freenect_device*, void* data, std::uint32_t) {
  std::printf("d %u\n", checksum(data, 640 * 480 * 2));
  ++depth_pictures;
}

void on_colour(freenect_device*, void* data, std::uint32_t) {
  std::printf("r %u\n", checksum(data, 640 * 480 * 3));
}

}  // namespace

int main(int argc, char** argv) {
  const int wanted = argc > 1 ? std::atoi(argv[1]) : 1;
  freenect_context* context = nullptr;
  freenect_device* device = nullptr;
  if (freenect_init(&context, nullptr) != 0 || freenect_open_device(context, &device, 0) != 0) return 1;
  freenect_set_depth_callback(device, on_depth);
  freenect_set_video_callback(device, on_colour);
  freenect_set_depth_mode(device, freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_DEPTH_11BIT));
  freenect_set_video_mode(device, freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB));
  freenect_start_depth(device);
  freenect_start_video(device);
  for (int i = 0; i < 100 && depth_pictures < wanted; ++i) {
    if (freenect_process_events(context) < 0) return 2;
  }
  return depth_pictures == wanted ? 0 : 3;
}
