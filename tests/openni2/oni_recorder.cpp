#include "tests/openni2/oni_recorder.h"

#include <OpenNI.h>

#include "tests/openni2/emulated_driver.h"

namespace scanknit::test {
namespace {

bool record(const std::filesystem::path& path, const OniRecorderOptions& options) {
  openni::Device device;
  openni::VideoStream depth, colour;
  openni::Recorder recorder;
  if (device.open(kEmulatedUri) != openni::STATUS_OK) return false;
  if (depth.create(device, openni::SENSOR_DEPTH) != openni::STATUS_OK) return false;
  if (colour.create(device, openni::SENSOR_COLOR) != openni::STATUS_OK) return false;
  depth.setMirroringEnabled(options.is_mirrored);
  colour.setMirroringEnabled(options.is_mirrored);
  if (recorder.create(path.c_str()) != openni::STATUS_OK) return false;
  if (recorder.attach(depth) != openni::STATUS_OK) return false;
  if (recorder.attach(colour, options.is_lossy) != openni::STATUS_OK) return false;
  if (recorder.start() != openni::STATUS_OK) return false;
  if (depth.start() != openni::STATUS_OK || colour.start() != openni::STATUS_OK) return false;
  openni::VideoFrameRef frame;
  for (int i = 0; i < options.pictures + 2; ++i) {  // the recorder misses the first ones now and then
    if (depth.readFrame(&frame) != openni::STATUS_OK) return false;
  }
  frame.release();
  recorder.stop();
  depth.stop();
  colour.stop();
  recorder.destroy();
  depth.destroy();
  colour.destroy();
  device.close();
  return true;
}

}  // namespace

bool record_oni(const std::filesystem::path& path, const OniRecorderOptions& options) {
  if (openni::OpenNI::initialize() != openni::STATUS_OK) return false;
  const bool is_recorded = record(path, options);
  openni::OpenNI::shutdown();
  return is_recorded;
}

}  // namespace scanknit::test
