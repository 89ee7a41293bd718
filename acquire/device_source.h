// DeviceSource: a scanner that is plugged in, with any driver. It delivers pictures as the camera sent them
// (raw_frame.h).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "acquire/raw_frame.h"
#include "core/result.h"

namespace scanknit {

/// The properties of a scanner that are known without opening it.
struct DeviceInfo {
  std::string uri;     ///< "usb:8086:0b07/0123", "kinect1:A0123": what open_camera() takes
  std::string name;    ///< for messages
  std::string serial;  ///< empty: none
  int bus = 0;         ///< 0: bus and address are unknown
  int address = 0;
  int speed_mbit = 0;   ///< of its USB link: 480, 5000 ...; 0: unknown
  std::string support;  ///< "tested on hardware", "tested on an emulated device" or "should work"
};

/// An event of a streaming scanner; `text` describes it for the user, with the remedy if there is one.
struct DeviceEvent {
  enum class Kind {
    kSlowLink,   ///< the link is too slow for the requested streams
    kStalled,    ///< the camera stopped with an error; it is being restarted
    kSilent,     ///< no data for ten frames; the camera is being restarted
    kDamaged,    ///< only damaged pictures for ten frames; the camera is being restarted
    kRecovered,  ///< frames come again
    kClockJump,  ///< the camera's clock jumped; time continues by this computer's clock
    kLeft,       ///< unplugged
    kReturned,   ///< plugged in again, and streaming
    kNoColour,   ///< colour has failed; depth continues
    kFailed,     ///< the scanner has failed: no more frames will come
  };
  Kind kind;
  std::string text;
};

/// The end of kNoColour's text.
inline constexpr const char* kGoesOnWithoutColour = "The scan goes on without colour; re-plug it to have colour again";

/// The source calls both on its own threads, one call at a time for each sink. They must return soon and must not call
/// the source. A sink that drops a frame counts it (LossCounters::queue).
using FrameSink = std::function<void(RawFrame)>;
using EventSink = std::function<void(const DeviceEvent&)>;

/// In the order of setting: a preset changes the others.
enum class DeviceControl {
  kPreset,            ///< the camera's own numbering
  kEmitter,           ///< 0 off, 1 on
  kLaserPower,        ///< milliwatts
  kAutoExposure,      ///< of depth: 0 fixed at the current value, 1 automatic
  kColourAutomatics,  ///< exposure and white balance of colour: 0 fixed at the current values, 1 automatic
};

/// Call it from one thread; it calls the sinks on other threads.
class DeviceSource {
 public:
  virtual ~DeviceSource() = default;  ///< stops

  [[nodiscard]] virtual const DeviceInfo& info() const = 0;

  /// The streams that the camera offers.
  [[nodiscard]] virtual std::vector<StreamProfile> profiles() const = 0;

  /// The calibration of these streams. The user's intrinsics override the camera's. The result says what is unknown,
  /// and why: the camera can stream without it. Error (kDevice): unplugged.
  [[nodiscard]] virtual Result<RawCalibration> calibration(std::span<const StreamProfile> streams) = 0;

  /// `streams`: one or two of profiles(), of different kind. Errors (kDevice): already started, not offered, refused,
  /// in use, unplugged.
  [[nodiscard]] virtual Result<void> start(std::span<const StreamProfile> streams, FrameSink frames,
                                           EventSink events) = 0;

  /// Returns within a second and calls no sink afterwards. Does nothing unless started.
  virtual void stop() = 0;

  /// The losses of all streams since start(): device, transport and overflow.
  [[nodiscard]] virtual LossCounters losses() const = 0;

  /// Error (kDevice): the camera has no such control, or refused the value.
  [[nodiscard]] virtual Result<void> set_control(DeviceControl control, int value) = 0;
};

struct DeviceOptions {
  std::optional<CameraModel> intrinsics;  ///< of depth, as acquire.intrinsics
  std::optional<double> depth_scale;      ///< raw units per metre, as acquire.depth_scale
  double wait_s = 0;                      ///< how long to wait for a scanner that is not plugged in yet
  double reconnect_s = 0;                 ///< how long to wait for one that was unplugged while streaming; 0: it fails
  bool takes_from_others = false;         ///< also a camera that another program uses
  /// A UVC camera without a good picture for this long, and for ten frames, is restarted. A busy computer may keep
  /// pictures back for as long as the default.
  double silence_s = 0.3;
  bool holds_automatics = true;  ///< fix colour exposure and white balance after the first second
};

/// All supported scanners that are plugged in, by bus and address. Opens none of them. Error (kDevice): USB cannot be
/// used at all.
[[nodiscard]] Result<std::vector<DeviceInfo>> list_cameras();

/// `uri`: "usb:" (the first), "usb:8086:0b07", "usb:8086:0b07/SERIAL", "kinect1:0" (by bus and address),
/// "kinect1:SERIAL", "openni2:" (the first), "openni2:/path/file.oni", or "" for the first of any kind. Errors: no such
/// kind of URI (kUsage); absent, no permission, in use (kDevice, with what to do).
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_camera(const std::string& uri, const DeviceOptions& options,
                                                                std::stop_token stop);

/// Chooses depth of the given size and rate, or the nearest to it, and a colour stream to match: the nearest size that
/// is not smaller, the same rate, preferably uncompressed. Empty if there is no depth; only depth if there is no
/// colour. `depth_format` is kY8i where depth is to be made of pairs of pictures.
[[nodiscard]] std::vector<StreamProfile> choose_streams(std::span<const StreamProfile> profiles, int width, int height,
                                                        double frames_per_second,
                                                        PixelFormat depth_format = PixelFormat::kZ16);

/// Bytes a second of the pictures, with MJPEG counted as a tenth; to check the link, and for messages.
[[nodiscard]] double bandwidth_of(std::span<const StreamProfile> streams);

}  // namespace scanknit
