// DeviceSource: a scanner that is plugged in, whatever its driver. Pictures come as the camera sent them (raw_frame.h).
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

/// A scanner as the computer sees it, without opening it.
struct DeviceInfo {
  std::string uri;     ///< "usb:8086:0b07/0123", "kinect1:A0123": what open_camera() takes
  std::string name;    ///< for people
  std::string serial;  ///< empty: it has none
  int bus = 0;         ///< 0: unknown, address too
  int address = 0;
  int speed_mbit = 0;   ///< of its USB link: 480, 5000 ...; 0: unknown
  std::string support;  ///< "tested on hardware", "tested on an emulated device" or "should work"
};

/// What happens to a scanner while it streams; `text` says it to a person, with the remedy where there is one.
struct DeviceEvent {
  enum class Kind {
    kSlowLink,   ///< the link is too slow for what was asked
    kStalled,    ///< the camera stopped with an error; it is being started again
    kSilent,     ///< nothing came for ten frames; it is being started again
    kDamaged,    ///< no good picture came for ten frames, but damaged ones did; it is being started again
    kRecovered,  ///< frames come again
    kClockJump,  ///< the camera's clock jumped; time goes on by this computer's
    kLeft,       ///< unplugged
    kReturned,   ///< plugged in again, and streaming
    kNoColour,   ///< colour was given up; depth goes on
    kFailed,     ///< given up: no frame will come any more
  };
  Kind kind;
  std::string text;
};

/// The end of what kNoColour says.
inline constexpr const char* kGoesOnWithoutColour = "The scan goes on without colour; re-plug it to have colour again";

/// Both are called on threads of the source, one call at a time for each sink, and must return soon; they must not call
/// the source. A frame that is not taken at once is the sink's to count (LossCounters::queue).
using FrameSink = std::function<void(RawFrame)>;
using EventSink = std::function<void(const DeviceEvent&)>;

/// In the order in which they are set: a preset changes the others.
enum class DeviceControl {
  kPreset,            ///< the camera's own numbering
  kEmitter,           ///< 0 off, 1 on
  kLaserPower,        ///< milliwatts
  kAutoExposure,      ///< of depth: 0 held as it is, 1 automatic
  kColourAutomatics,  ///< exposure and white balance of colour: 0 held as they are, 1 automatic
};

/// One thread calls it; the sinks are called on others.
class DeviceSource {
 public:
  virtual ~DeviceSource() = default;  ///< stops

  [[nodiscard]] virtual const DeviceInfo& info() const = 0;

  /// What can be asked for, as the camera lists it.
  [[nodiscard]] virtual std::vector<StreamProfile> profiles() const = 0;

  /// For the given streams. A user's intrinsics come before the camera's own. What is not known, and why, is in the
  /// result: the camera streams all the same. Error (kDevice): unplugged.
  [[nodiscard]] virtual Result<RawCalibration> calibration(std::span<const StreamProfile> streams) = 0;

  /// `streams`: one or two of profiles(), of different kind. Errors (kDevice): already started, not offered, refused,
  /// in use, unplugged.
  [[nodiscard]] virtual Result<void> start(std::span<const StreamProfile> streams, FrameSink frames,
                                           EventSink events) = 0;

  /// Within a second. No sink is called after it. Nothing happens when it is not started.
  virtual void stop() = 0;

  /// Of all streams since start(): device, transport and overflow.
  [[nodiscard]] virtual LossCounters losses() const = 0;

  /// Error (kDevice): the camera has no such control, or refused the value.
  [[nodiscard]] virtual Result<void> set_control(DeviceControl control, int value) = 0;
};

struct DeviceOptions {
  std::optional<CameraModel> intrinsics;  ///< of depth, as acquire.intrinsics
  std::optional<double> depth_scale;      ///< raw units per metre, as acquire.depth_scale
  double wait_s = 0;                      ///< for a scanner that is not plugged in yet
  double reconnect_s = 0;                 ///< for one that was unplugged while it streamed; 0: it has failed then
  bool takes_from_others = false;         ///< also a camera that another program uses
  bool holds_automatics = true;           ///< colour exposure and white balance stay as they are after the first second
};

/// All scanners that are plugged in and that we can use, by bus and address. Nothing is opened. Error (kDevice): USB
/// cannot be used at all.
[[nodiscard]] Result<std::vector<DeviceInfo>> list_cameras();

/// `uri`: "usb:" (the first), "usb:8086:0b07", "usb:8086:0b07/SERIAL", "kinect1:0" (by bus and address),
/// "kinect1:SERIAL", "openni2:" (the first), "openni2:/path/file.oni", or "" for the first of any kind. Errors: no such
/// kind of URI (kUsage); absent, forbidden, in use (kDevice, with what to do).
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_camera(const std::string& uri, const DeviceOptions& options,
                                                                std::stop_token stop);

/// Depth of the wanted size and rate and colour to go with it (the nearest size that is not smaller, the same rate,
/// uncompressed first), or what comes nearest. No depth: empty. No colour: depth alone.
[[nodiscard]] std::vector<StreamProfile> choose_streams(std::span<const StreamProfile> profiles, int width, int height,
                                                        double frames_per_second);

/// Bytes a second of the pictures, MJPEG taken as a tenth; for the link's check and for people.
[[nodiscard]] double bandwidth_of(std::span<const StreamProfile> streams);

}  // namespace scanknit
